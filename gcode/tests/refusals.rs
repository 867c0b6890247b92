//! Programs that must be refused, with the message for the user.

use gcode::{Dialect, GcodeError, interpret, parse};

fn refused_as(dialect: Dialect, text: &str) -> (String, usize) {
    let program = parse(text);
    match interpret(&program, &dialect.into()) {
        Err(GcodeError::Refused { diagnostics }) => {
            let errors: Vec<_> = diagnostics.iter().filter(|d| d.is_error()).collect();
            (errors[0].render(&program, "part.nc"), errors.len())
        }
        other => panic!("not refused: {other:?}\n{text}"),
    }
}

/// Header that makes everything valid except the error under test.
const HEAD: &str = "G21 G90 G0 X0 Y0 Z0 F100\n";

#[test]
fn a_feed_move_in_a_loop_is_shown() {
    let (text, _) = refused_as(Dialect::Fanuc, &format!("{HEAD}#1=1\nWHILE[#1LE2]DO1\nN20 G1 X#1\n#1=#1+1\nEND1\n"));
    let expected = "\
error: a feed move runs several times
 --> part.nc:4:5
  |
4 | N20 G1 X#1
  |     ^^
  = help: give --expand: it writes the program without loops and subprograms
";
    assert_eq!(text, expected);
}

#[test]
fn an_arc_without_a_circle_is_shown() {
    let (text, _) = refused_as(Dialect::Fanuc, &format!("{HEAD}G91.1\nG3 X10 Y10 I0 J8\n"));
    let expected = "\
error: no circle: its radius is 8.0000 mm at the start and 10.1980 mm at the end
 --> part.nc:3:12
  |
3 | G3 X10 Y10 I0 J8
  |            ^^
";
    assert_eq!(text, expected);
}

#[test]
fn each_fault_has_its_own_message() {
    let cases = [
        (Dialect::Sinumerik, "G1 G2 X1 CR=5", "G2 contradicts G1 in the same block", "^^"),
        (Dialect::LinuxCnc, "G0 G81 X1 Z1 R1", "G81 contradicts G0 in the same block", "^^^"),
        (Dialect::LinuxCnc, "G90 X1 G91 Y2", "G91 contradicts G90 in the same block", "^^^"),
        (Dialect::LinuxCnc, "G1 X1 G20 G21", "G21 contradicts G20 in the same block", "^^^"),
        (Dialect::Fanuc, "G1 X1\nM96 P10 Q27\nX5\nN10 X2", "whether this block jumps is decided at run time", "^^^^^^^^^^^"),
        (
            Dialect::Fanuc,
            "G65 H81 P10 Q#100 R5\nG1 X5\nN10 X2",
            "whether this block jumps is decided at run time",
            "^^^^^^^^^^^^^^^^^^^^",
        ),
        (Dialect::Fanuc, "G#500 X1", "this G code cannot be identified", "^^^^^"),
        (Dialect::Fanuc, "G71 P10 Q20 U1. W0.5 D2.", "G71 is a cycle of lathes", "^^^"),
        (Dialect::Fanuc, "G2 X1 Y1", "an arc without centre or radius", "^^"),
        (Dialect::Fanuc, "G2 X1 Y1 R1 I1", "both a radius and a centre", "^^"),
        (Dialect::Fanuc, "G2 X1 Y1 I1 K1", "not in the plane of the arc", "^^"),
        (Dialect::Fanuc, "G2 R5 X0 Y0", "from a point to itself", "^^"),
        (Dialect::Fanuc, "G2 X10 Y0 R3", "half its chord 5.0000 mm", "^^"),
        (Dialect::LinuxCnc, "G1 X1 X2", "this letter stands twice", "^^"),
        (Dialect::LinuxCnc, "G1 X1 E5", "E has no meaning in this feed move", "^^"),
        (Dialect::LinuxCnc, "G1 X1 I5", "I has no meaning in this feed move", "^^"),
        (Dialect::LinuxCnc, "G1 X1 U5", "U has no meaning in this feed move", "^^"),
        (Dialect::Fanuc, "G1 Y1 X10000000000", "this number is beyond any machine", "^^^^^^^^^^^^"),
        (Dialect::LinuxCnc, "G1 X=5", "not understood in a feed move", "^"),
        (Dialect::Fanuc, "G1 X1 F0", "the feed is not positive", "^^"),
        (Dialect::Fanuc, "G1 X1 F#500", "the feed of line 2 is known only when the program runs", "^^"),
        (Dialect::LinuxCnc, "F#1\nG1 X1", "the feed of line 2 is known only when the program runs", "^^"),
        (Dialect::Fanuc, "G93\nG1 X1", "no feed was given", "^^"),
        (Dialect::Fanuc, "G93 G1 X1 F5\nX2", "G93 needs an F word", "^^"),
        (Dialect::Fanuc, "G1 X1 GOTO 5", "a flow statement in a block with codes", "^^^^^^"),
        (Dialect::Fanuc, "IF[#500EQ0]GOTO10\nG1 X1", "there is no block N10 to jump to", "^^^^^^^^^^^^^^^^^"),
        (Dialect::Fanuc, "G1 X1\nGOTO10", "there is no block N10 to jump to", "^^^^^^"),
        (Dialect::Fanuc, "G1 X1\nM99 P10", "there is no block N10 to jump to", "^^^^^^^"),
        (Dialect::Fanuc, "GOTO#500\nN1 G1 X1", "the target of this jump is not known", "^^^^^^^^"),
        (Dialect::Fanuc, "N5 G1 X#500\nIF[#501EQ0]GOTO5", "a feed move runs several times", "^^"),
        (Dialect::Fanuc, "#1=2\nWHILE[#1LT3]DO1\nG1 X1\nEND1", "the program does not end", "^^^^"),
        (Dialect::Fanuc, "#1=2\nWHILE[#1LT3]DO1\nG1 X1", "the other end of this loop is missing", "^^^^^^^^^^^^^^^"),
        (Dialect::Fanuc, "IF #1 EQ 0 GOTO 5", "this statement is not understood", "^^^^^^^^^^^^^^^^^"),
        (Dialect::Fanuc, "#1=1/0\nG1 X1", "a division by zero", "^^^^^^"),
        (Dialect::Fanuc, "#50=1\nG1 X1", "there is no parameter #50", "^^^^^"),
        (Dialect::LinuxCnc, "o9 sub\nG1 X1\no9 endsub\no9 call\no9 call", "a feed move runs several times", "^^"),
        (Dialect::LinuxCnc, "o9 call\nM2\no9 sub\nG1 X1\no9 call\no9 endsub", "calls nested deeper", "^^^^^^^"),
        (Dialect::LinuxCnc, "o1 repeat [2]\nG0 X1\nG1 Y1\no1 endrepeat", "a feed move runs several times", "^^"),
        (Dialect::LinuxCnc, "o8 call\nG1 X2\nM2\no8 sub\nG1 X1\no8 endsub", "not run in the order of the lines", "^^"),
        (Dialect::LinuxCnc, "o1 do\n#1=1\no1 while [1]", "the program does not end", "^^^^^^^^^^^^"),
        (Dialect::LinuxCnc, "o1 if [1]\nG1 X1", "the end of this statement is missing", "^^^^^^^^^"),
        (Dialect::LinuxCnc, "G1 X[#<depth>+1]", "#<depth> was not assigned", "^^^^^^^^^^^^^"),
        (Dialect::LinuxCnc, "G1 X[1+]", "`]` has no meaning in this expression", "^^^^^"),
        (Dialect::LinuxCnc, "/o1 if [1]\n/o1 endif\nG1 X1", "flow statement in a block that a switch may skip", "^^^^^^^^^"),
        (Dialect::LinuxCnc, "G80\nX1", "no motion code is active", "^^"),
        (Dialect::LinuxCnc, "G3 X0 Y0 I5 P1.5", "whole number of turns", "^^"),
        (Dialect::Fanuc, "G53 G2 X1 Y1 R5", "G53 goes with G0 and G1 only", "^^^"),
        (Dialect::Fanuc, "G90.1 G2 X10 Y0 I5", "an absolute arc centre needs both", "^^"),
    ];
    for (dialect, text, message, carets) in cases {
        let (rendered, _) = refused_as(dialect, &format!("{HEAD}{text}\n"));
        assert!(rendered.contains(message), "{text}: {rendered}");
        assert!(rendered.lines().any(|line| line.ends_with(&format!(" {carets}"))), "{text}: {rendered}");
    }
}

#[test]
fn an_axis_word_without_any_motion_code_is_refused() {
    for text in ["X1 Y2\n", "X1 Y2\nX3 Y4\nM30\n", "X1 Y2 I3\nG1 X5 F100\n"] {
        let (text, _) = refused_as(Dialect::Fanuc, text);
        assert!(text.contains("axis words, but no motion code is active"));
    }
}

#[test]
fn a_feed_a_turn_that_is_read_a_minute_is_refused() {
    for feed in ["G1 X30 F0.2\nY30\n", "G99\nG1 X30 F0.2\n", "G20\nG1 X1 F.005\n"] {
        let (text, count) = refused_as(Dialect::Fanuc, &format!("{HEAD}G0 X0 Y0 Z0\n{feed}M30\n"));
        assert!(text.contains("it may be a feed a turn") && count == 1, "{text}");
    }
    for feed in ["G1 X1 F0.2\n", "G1 X30 F1\n", "G95 S1000 M3\nG1 X30 F0.2\n"] {
        interpret(&parse(format!("{HEAD}G0 X0 Y0 Z0\n{feed}M30\n")), &Dialect::Fanuc.into()).unwrap();
    }
}

#[test]
fn one_cause_is_reported_once_and_the_list_is_capped() {
    let (_, once) = refused_as(Dialect::Fanuc, &format!("{HEAD}F#500\nG1 X1\nX2\nX3\nX4\n"));
    assert_eq!(once, 1);
    let (_, many) = refused_as(Dialect::LinuxCnc, &format!("{HEAD}{}", "G1 X1 E1\n".repeat(100)));
    assert_eq!(many, 20);
    let error = interpret(&parse(format!("{HEAD}G1 X1 E1\nX2 E2\n")), &Dialect::LinuxCnc.into()).expect_err("refused");
    assert_eq!(error.to_string(), "the program is refused: line 2: E has no meaning in this feed move (and 1 more)");
}

#[test]
fn parameters_outside_feed_moves_pass() {
    let text =
        format!("{HEAD}#501=1\nG10 L2 P#501 X[#510]\nS#3 M3\nT#4\nG0 X#5\nG0 X1\nG1 X2\n#<_x>=[2*3]\nIF[#1EQ0]THEN#2=1\nX3\n");
    assert!(interpret(&parse(text), &Dialect::Fanuc.into()).is_ok());
}
