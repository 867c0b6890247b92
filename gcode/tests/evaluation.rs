//! Programs with parameters, branches, loops and subprograms: evaluated in place, and written without them.

use gcode::{
    Dialect, Edits, Fixed, GcodeError, MoveKind, Options, Program, Shiftable, Toolpath, edit, evaluate, expand, interpret, parse,
};
use proptest::prelude::*;

/// Subprogram files by name.
fn files(name: &str) -> Option<Vec<u8>> {
    let text = match name {
        "spot.ngc" => "o<spot> sub\nG0 X#1 Y#2\nG81 Z-1 R1 F50\nG80\no<spot> endsub [#1+#2]\n",
        "cut.ngc" => "(a cut)\no<cut> sub\nG1 X#1 F100\no<cut> endsub\nM2\n",
        "O0077.nc" => "%\nO0077 (SPOT)\nG0 X#24 Y#25\nM99\n%\n",
        _ => return None,
    };
    Some(text.into())
}

fn evaluated(dialect: Dialect, text: &str) -> (Program, Toolpath) {
    let mut program = parse(text);
    let options: Options = dialect.into();
    if let Err(error) = evaluate(&mut program, &options, &files) {
        panic!("{error}\n{text}");
    }
    let toolpath = interpret(&program, &options).unwrap_or_else(|error| panic!("{error}\n{text}"));
    (program, toolpath)
}

fn ends(toolpath: &Toolpath) -> Vec<[f64; 2]> {
    toolpath.moves.iter().map(|of| [of.end.nominal_mm()[0], of.end.nominal_mm()[1]]).collect()
}

fn flat(dialect: Dialect, text: &str) -> String {
    let out = expand(&parse(text), &dialect.into(), &files).unwrap_or_else(|error| panic!("{error}\n{text}"));
    String::from_utf8(out).expect("ASCII")
}

fn error_of(dialect: Dialect, text: &str) -> String {
    match expand(&parse(text), &dialect.into(), &files) {
        Err(GcodeError::Refused { diagnostics }) => diagnostics[0].render(&parse(text), "part.nc"),
        other => panic!("not refused: {other:?}\n{text}"),
    }
}

#[test]
fn constants_at_the_head_give_the_words_their_values() {
    let text = "G21 G90\n#<depth> = -2\n#1=10 #2=[#1*2]\nG0 X0 Y0 Z[#<depth>+5]\nG1 X#1 Y[#1/4] F#1\nX[#1+5] (two)\nM2\n";
    let (program, toolpath) = evaluated(Dialect::LinuxCnc, text);
    assert_eq!(ends(&toolpath), [[0.0, 0.0], [10.0, 2.5], [15.0, 2.5]]);
    assert!(toolpath.moves[1..].iter().all(|of| of.shiftable == Shiftable::Yes && !of.after_shared));
    assert_eq!(toolpath.moves[1].feed_word, Some(10.0));
    let words = toolpath.moves[1].words(&program);
    assert_eq!(words.axes[1].and_then(|index| program.words()[index].number()), Some(2.5));
    // A shifted move gets numbers. All other bytes stay.
    let mut edits = Edits::new();
    edits.replace_motion(&program, 4, Dialect::LinuxCnc, &["G1 X10.01 Y2.49 F10."]).expect("block 4 has motion words");
    let out = String::from_utf8(edit(&program, &edits).expect("no overlap")).expect("ASCII");
    assert_eq!(out, text.replace("G1 X#1 Y[#1/4] F#1", "G1 X10.01 Y2.49 F10."));
    assert_eq!(edit(&program, &Edits::new()).as_deref(), Ok(text.as_bytes()));
}

#[test]
fn assignments_act_after_the_block() {
    let (_, toolpath) = evaluated(Dialect::LinuxCnc, "G21 G0 X0 Y0 Z0\n#1=1\n#1=2 G1 X#1 F100\nY#1\nM2\n");
    assert_eq!(ends(&toolpath)[1..], [[1.0, 0.0], [1.0, 2.0]]);
}

#[test]
fn decided_branches_run_and_others_do_not() {
    let text =
        "G21 G0 X0 Y0 Z0 F100\n#1=3\no1 if [#1 EQ 2]\nG1 X2\no1 elseif [#1 EQ 3]\nG1 X3\no1 else\nG91 X4\no1 endif\nG1 Y1\nM2\n";
    let (_, toolpath) = evaluated(Dialect::LinuxCnc, text);
    assert_eq!(ends(&toolpath)[1..], [[3.0, 0.0], [3.0, 1.0]]);
    assert_eq!(toolpath.moves.iter().map(|of| of.block).collect::<Vec<_>>(), [0, 5, 9]);
    let text = "G21 G0 X0 Y0 Z0 F100\n#1=3\nIF[#1NE3]GOTO10\nG1 X3\nIF[#1EQ3]THEN #2=8\nGOTO20\nN10 G1 X9\nN20 G1 Y#2\nM30\n";
    let (_, toolpath) = evaluated(Dialect::Fanuc, text);
    assert_eq!(ends(&toolpath)[1..], [[3.0, 0.0], [3.0, 8.0]]);
}

#[test]
fn no_line_is_written_before_a_block_that_a_jump_leads_to() {
    let text = "G21 G0 X0 Y0 Z0 F100\n#1=3\nG1 X3\nGOTO20\nN10 G1 X9\nN20 G1 Y5 M9\nN30 G1 Y9 M9\nM30\n";
    let (_, toolpath) = evaluated(Dialect::Fanuc, text);
    let shiftable: Vec<Shiftable> = toolpath.moves[1..].iter().map(|of| of.shiftable).collect();
    assert_eq!(shiftable, [Shiftable::Yes, Shiftable::No(Fixed::Unsplittable), Shiftable::Yes]);
}

#[test]
fn a_block_that_calls_is_left_alone() {
    let text = "G21 G0 X0 Y0 Z0 F100\nG1 X3\nG1 X5 M98 P2\nG1 X9\nM30\nO2\nM8\nM99\n";
    let (_, toolpath) = evaluated(Dialect::Fanuc, text);
    let shiftable: Vec<Shiftable> = toolpath.moves[1..].iter().map(|of| of.shiftable).collect();
    assert_eq!(shiftable, [Shiftable::Yes, Shiftable::No(Fixed::Unsplittable), Shiftable::Yes]);
    assert!(toolpath.moves[3].after_shared);
}

#[test]
fn subprograms_and_loops_without_feed_moves_are_read_where_they_run() {
    let text = "G21 G90 G0 X0 Y0 Z5 F100\n#<n>=0\no<spot> call [1] [2]\no1 while [#<n> LT 3]\nG0 X#<n>\n#<n>=[#<n>+1]\no1 endwhile\n\
                G1 X#<_value> Y1\nX9\nM2\n";
    let (program, toolpath) = evaluated(Dialect::LinuxCnc, text);
    let blocks: Vec<u32> = toolpath.moves.iter().map(|of| of.block).collect();
    // The rapid and the cycle of the subprogram belong to the block that calls it.
    assert_eq!(blocks, [0, 2, 2, 4, 4, 4, 7, 8]);
    assert_eq!(ends(&toolpath)[1..], [[1.0, 2.0], [1.0, 2.0], [0.0, 2.0], [1.0, 2.0], [2.0, 2.0], [3.0, 1.0], [9.0, 1.0]]);
    let marked: Vec<bool> = toolpath.moves.iter().map(|of| of.after_shared).collect();
    assert_eq!(marked, [false, true, true, true, true, true, true, false]);
    assert!(toolpath.moves[6..].iter().all(|of| of.shiftable == Shiftable::Yes));
    assert!(program.subprogram_file("spot.ngc").is_some_and(|file| file.starts_with(b"o<spot> sub")));
    assert_eq!(program.subprogram_file("cut.ngc"), None);
}

#[test]
fn fanuc_calls_pass_their_arguments() {
    let text = "G21 G90 G0 X0 Y0 Z0 F100\nM98 P77\nG65 P77 X3. Y4.\nG65 P500 A1. I2. J3. I4. L2\n#1=7\nM98 P20600\nG1 X#1\nM30\n\
                O500\nG0 X[#1+#4+#5+#7]\nM99\nO600\n#1=#1+1\nG0 Y#1\nM99\n";
    let (_, toolpath) = evaluated(Dialect::Fanuc, text);
    let expected = [[0.0, 0.0], [0.0, 0.0], [3.0, 4.0], [10.0, 4.0], [10.0, 4.0], [10.0, 8.0], [10.0, 9.0], [9.0, 9.0]];
    assert_eq!(ends(&toolpath), expected);
}

#[test]
fn a_comment_may_stand_between_the_arguments_of_a_call() {
    let text = "G21 G90 G0 X0 Y0 Z0 F100\no<to> sub\nG0 X#1 Y#2\no<to> endsub\no<to> call [1] (X) [2] (Y) ; both\nG1 X5\nM2\n";
    let (_, toolpath) = evaluated(Dialect::LinuxCnc, text);
    assert_eq!(ends(&toolpath), [[0.0, 0.0], [1.0, 2.0], [5.0, 2.0]]);
}

#[test]
fn a_subprogram_that_is_not_found_leaves_everything_open() {
    let text = "G21 G90 G0 X0 Y0 Z0 F100\n#101=1\nM98 P900\nG1 X#101\nX1 Y1\nG0 X0 Y0 Z0\nG1 X1\nM30\n";
    let (_, toolpath) = evaluated(Dialect::Fanuc, text);
    let fixed: Vec<Shiftable> = toolpath.moves.iter().filter(|of| of.is_feed()).map(|of| of.shiftable).collect();
    let left = Shiftable::No(Fixed::NotUnderstood);
    assert_eq!(fixed, [Shiftable::No(Fixed::RunTime), left, left]);
    assert!(toolpath.warnings[0].message.contains("that is not found"), "{:?}", toolpath.warnings);
}

#[test]
fn moves_of_unknown_values_are_left_alone() {
    let text = "G21 G90 G0 X0 Y0 Z0 F100\nG38.2 Z-5\n#1=[#5063+1]\nG0 Z#1\nG1 X1\nG1 Z[#1-1]\nX2\nG0 X0 Y0 Z3\nG1 X5\n#1=2\nG1 Y#1\nM2\n";
    let (_, toolpath) = evaluated(Dialect::LinuxCnc, text);
    let fixed: Vec<Shiftable> = toolpath.moves.iter().filter(|of| of.is_feed()).map(|of| of.shiftable).collect();
    let unknown = Shiftable::No(Fixed::UnknownStart);
    assert_eq!(fixed, [unknown, Shiftable::No(Fixed::RunTime), unknown, Shiftable::Yes, Shiftable::Yes]);
}

/// A motion code in a branch holds in it: its further moves are left alone, as the first one, and after the branch reading goes on.
#[test]
fn moves_behind_a_motion_code_in_a_branch_are_left_alone() {
    let after = "G0 X0 Y0 Z5\nG1 X20 F900\nY20\nM30\n";
    for (dialect, branch) in [
        (Dialect::Fanuc, "IF[#500EQ1]GOTO100\nG1 X20 F900\nY20\nN100 "),
        (Dialect::Fanuc, "IF[#500EQ1]GOTO100\nG81 Z-5 R2 F900\nY20\nG80\nN100 "),
        (Dialect::Fanuc, "WHILE[#500GT0]DO1\nG1 X20 F900\nY20\nX0\nEND1\n"),
        (Dialect::LinuxCnc, "o100 if [#5399 GT 0]\nG1 X20 F900\nY20\no100 endif\n"),
    ] {
        let path = interpret(&parse(format!("G21 G90 G17 G94\nG0 X0 Y0 Z5\n{branch}{after}")), &dialect.into()).unwrap();
        let shiftable: Vec<_> = path.moves.iter().map(|step| step.shiftable).collect();
        assert_eq!(shiftable[shiftable.len() - 2..], [Shiftable::Yes; 2], "{branch}");
        let inside = &shiftable[1..shiftable.len() - 3];
        assert!(
            inside.len() >= 2 && inside.iter().all(|shiftable| matches!(shiftable, Shiftable::No(_))),
            "{branch}: {inside:?}"
        );
    }
}

/// The code of an arc before a branch stays where a move behind the branch may run under it.
#[test]
fn a_move_behind_a_branch_keeps_the_code_of_the_arc_before_it() {
    for branch in ["WHILE[#500GT0]DO1\nG0 Z5\n#500=0\nEND1\n", "IF[#500EQ1]GOTO100\nG81 X5 Y5 Z-5 R2\nG80\nN100 "] {
        let text = format!("G21 G90 G17 G94 G54\nG0 X0 Y0 Z5\nG1 Z-1 F600\nG2 X2 Y2 R2\n{branch}X30 Y20 R30\nG0 Z5\nM30\n");
        let path = interpret(&parse(text), &Dialect::Fanuc.into()).unwrap();
        let arc = path.moves.iter().find(|step| matches!(step.kind, MoveKind::Arc(_))).unwrap();
        assert_eq!(arc.shiftable, Shiftable::No(Fixed::OptionalBlock), "{branch}");
    }
}

/// The first moves may stand before any motion code: G0 or G1, as the control is set.
#[test]
fn a_move_before_the_first_motion_code_is_left_alone() {
    let path = interpret(&parse("G21 G90 G17 G94\nX0 Y0\nZ5\nG1 X20 F900\nY20\nM30\n"), &Dialect::Fanuc.into()).unwrap();
    let shiftable: Vec<_> = path.moves.iter().map(|step| step.shiftable).collect();
    let rapid = Shiftable::No(Fixed::Rapid);
    assert_eq!(shiftable, [rapid, rapid, Shiftable::Yes, Shiftable::Yes]);
    assert!(path.warnings.iter().any(|warning| warning.line == 2 && warning.message.contains("no motion code is active yet")));
    let rounded =
        interpret(&parse("G21 G90 G17 G94\nX0 Y0 Z5\nX10 ,R2\nG1 Y20 F600\nX20\nM30\n"), &Dialect::Fanuc.into()).unwrap();
    let shiftable: Vec<_> = rounded.moves.iter().map(|step| step.shiftable).collect();
    assert_eq!(shiftable, [rapid, rapid, Shiftable::No(Fixed::Adjoining), Shiftable::Yes]);
}

#[test]
fn branches_that_only_the_running_program_decides_leave_their_moves_alone() {
    let text =
        "G21 G90 G0 X0 Y0 Z0 F100\n#1=1\no1 if [#5070 EQ 0]\n#1=2\nG1 X8\no1 endif\nG1 Y#1\nX1 Y1\nG0 X0 Y0 Z0\nG1 X5\nM2\n";
    let (_, toolpath) = evaluated(Dialect::LinuxCnc, text);
    let fixed: Vec<Shiftable> = toolpath.moves.iter().filter(|of| of.is_feed()).map(|of| of.shiftable).collect();
    let run_time = Shiftable::No(Fixed::RunTime);
    assert_eq!(fixed, [run_time, run_time, Shiftable::No(Fixed::UnknownStart), Shiftable::Yes]);
    assert!(toolpath.warnings[0].message.contains("decides this when it runs") && toolpath.warnings[0].line == 3);
    // A jump to an alarm leaves no other path.
    let text = "G21 G90 G0 X0 Y0 Z0 F100\nIF[#500GT5]GOTO900\nG1 X5\nM30\nN900 #3000=1(TOO LONG)\n";
    assert_eq!(evaluated(Dialect::Fanuc, text).1.moves[1].shiftable, Shiftable::Yes);
    // A mode that may have changed ends what is known.
    let text = "G21 G90 G0 X0 Y0 Z0 F100\nWHILE[#500GT5]DO1\nG91\nEND1\nG0 X0 Y0 Z0\nG1 X5\nM30\n";
    assert_eq!(evaluated(Dialect::Fanuc, text).1.moves[2].shiftable, Shiftable::No(Fixed::NotUnderstood));
    // So does an assignment to an offset.
    let text = "G21 G90 G0 X0 Y0 Z0 F100\n#5221=10\nG0 X0 Y0 Z0\nG1 X5\nM30\n";
    assert_eq!(evaluated(Dialect::Fanuc, text).1.moves[2].shiftable, Shiftable::No(Fixed::NotUnderstood));
}

#[test]
fn saved_modes_come_back_at_the_return() {
    let text = "G21 G90 G0 X0 Y0 Z0 F100\no1 sub\nM73\nG91\no1 endsub\no1 call\nG0 X0 Y0 Z0\nG1 X5\nM2\n";
    let (_, toolpath) = evaluated(Dialect::LinuxCnc, text);
    assert_eq!(toolpath.moves[2].shiftable, Shiftable::No(Fixed::NotUnderstood));
}

#[test]
fn the_flat_program_names_the_origin_of_its_blocks() {
    let text = "%\nO1 (PART)\nN10 G21 G90 G0 X0 Y0 Z0\n#1=1\nWHILE[#1LE2]DO1 (TWICE)\nN20 G1 X[#1*10] F100 (PASS)\nM98 P2\n#1=#1+1\nEND1\n\
                N30 G0 Z5.\nM30\nO2\nN10 G1 Y#1\nM99\n%\n";
    let expected = "%\nO1 (PART)\nN10 G21 G90 G0 X0 Y0 Z0\nG1 X10. F100 (PASS)\n(from sub 2, line 13, run 1)\nG1 Y1.\n\
                    (from line 6, run 2)\nG1 X20. F100 (PASS)\n(from sub 2, line 13, run 2)\nG1 Y2.\n(from line 10)\nN30 G0 Z5.\nM30\n%\n";
    assert_eq!(flat(Dialect::Fanuc, text), expected);
    let text = "G21 G0 X0 Y0 Z0\no<cut> call [4]\nM2\n";
    assert_eq!(flat(Dialect::LinuxCnc, text), "G21 G0 X0 Y0 Z0\n(from sub cut, line 3)\nG1 X4. F100\n(from line 3)\nM2\n");
    let plain = "G21 G0 X0 Y0\r\nG1 X1 F100\r\nM30";
    assert_eq!(flat(Dialect::Fanuc, plain), plain);
}

#[test]
fn what_run_time_decides_cannot_be_written_flat() {
    let text = error_of(Dialect::LinuxCnc, "G21\nG1 X#5061 F100\nM2\n");
    assert!(text.contains("known only when the program runs") && text.contains("2 | G1 X#5061 F100\n  |    ^^^^^^\n"), "{text}");
    let text = error_of(Dialect::Fanuc, "IF[#500EQ1]GOTO2\nG0 X1\nN2 G0 X2\nM30\n");
    assert!(text.contains("cannot be written without branches") && text.contains(" --> part.nc:1:1"), "{text}");
    let text = error_of(Dialect::LinuxCnc, "o<nowhere> call\nM2\n");
    assert!(text.contains("this subprogram is not found"), "{text}");
    let text = error_of(Dialect::LinuxCnc, "o<spot> call [1] [1/0]\nM2\n");
    assert!(text.contains("a division by zero"), "{text}");
}

#[test]
fn what_acts_on_the_control_or_outlives_the_program_is_not_lost_in_a_flat_one() {
    for acts in ["#3006=1(CLAMP)", "#1132=255", "#3003=1", "#500=7.", "#1=7.\nIF[#1EQ7.]THEN#3006=1", "#3000=1(ALARM)"] {
        let text = format!("G21 G90\n#101=7.\nG0 X#101\n{acts}\nG1 X0 F100\nM30\n");
        let error = error_of(Dialect::Fanuc, &text);
        assert!(error.contains("acts on the control or outlives the program") && error.contains("do not expand it"), "{error}");
        let line = 3 + acts.lines().count();
        assert!(error.contains(&format!(" --> part.nc:{line}:")), "{error}");
    }
    assert!(error_of(Dialect::LinuxCnc, "#5161=0\nG28\nM2\n").contains("acts on the control"));
    // Clocks are not read by anything that is left, and common variables end with the program that uses them.
    assert_eq!(flat(Dialect::Fanuc, "#3002=0\n#101=7.\nG0 X#101\nM30\n"), "G0 X7.\nM30\n");
    // A macro that is not there may read them.
    let error = error_of(Dialect::Fanuc, "#101=7.\nG1 X20. F600.\nM98 P9001\nM30\n");
    assert!(error.contains("may read what was assigned before") && error.contains(" --> part.nc:3:"), "{error}");
    assert!(flat(Dialect::Fanuc, "G1 X20. F600.\nM98 P9001\nM30\n").contains("M98 P9001"));
}

#[test]
fn an_endless_program_is_refused_with_its_line() {
    let repeats = "nothing that it depends on changes";
    for text in [
        "o1 while [1]\no1 endwhile\n",
        "#1=2\no1 while [#1 GT 0]\n#1=[1+1]\nG0 X1\no1 endwhile\n",
        "o1 sub\no2 do\nG0 X1\no2 while [1]\no1 endsub\no1 call\n",
        // What a call assigns to its own parameters does not outlast it.
        "o9 sub\n#5=1\n#5=2\nG0 X1\no9 endsub\no1 while [1]\no9 call\no1 endwhile\n",
    ] {
        assert!(error_of(Dialect::LinuxCnc, text).contains(repeats), "{text}");
    }
    assert!(error_of(Dialect::Fanuc, "G0 X1\nM99 P1\n").contains("no block N1"));
    assert!(error_of(Dialect::Fanuc, "N1 G0 X1\nGOTO1\n").contains(repeats));
    // Each pass changes something.
    let most = "more than 4000000 blocks are repeated";
    assert!(error_of(Dialect::LinuxCnc, "#1=1\no1 while [#1 GT 0]\n#1=[#1+1]\no1 endwhile\n").contains(most));
    assert!(error_of(Dialect::LinuxCnc, "o1 while [1]\no2 repeat [2]\nG0 X1\no2 endrepeat\no1 endwhile\n").contains(most));
    assert!(error_of(Dialect::LinuxCnc, "o9 sub\no9 call\no9 endsub\no9 call\n").contains("calls nested deeper than 100"));
}

#[test]
fn loops_that_end_are_no_endless_ones() {
    let ends = [
        "#1=1\no1 while [#1 LT 5000]\nG0 X1\n#1=[#1+1]\no1 endwhile\nM2\n",
        "o1 repeat [5000]\no2 repeat [2]\nG0 X1\no2 endrepeat\no1 endrepeat\nM2\n",
        "o9 sub\nG0 X1\no9 endsub\no1 repeat [5000]\no9 call\no1 endrepeat\nM2\n",
        "#<a>=0\no1 do\no2 if [#<a> EQ 5000]\no1 break\no2 endif\n#<a>=[#<a>+1]\no1 while [1]\nM2\n",
    ];
    for text in ends {
        assert!(!flat(Dialect::LinuxCnc, text).contains("while"), "{text}");
    }
    for text in ["#1=0\nN1 #1=#1+1\nIF[#1LT5000]GOTO1\nM30\n", "M98 P2 L5000\nM30\nO2\nG0 X1\nM99\n"] {
        assert!(!flat(Dialect::Fanuc, text).is_empty(), "{text}");
    }
}

#[test]
fn subprograms_that_may_call_themselves_are_read_once() {
    let calls = "o9 call\n".repeat(20);
    let text = format!(
        "G21 G90 G0 X0 Y0 Z0 F100\n#101=1\no9 sub\no1 if [#5399 GT 0]\nG0 X1\n#101=2\n{calls}o1 endif\no9 endsub\no9 call\nG1 X#101\nM2\n"
    );
    let (_, toolpath) = evaluated(Dialect::LinuxCnc, &text);
    let last = toolpath.moves.last().expect("there are moves");
    assert!(matches!(last.shiftable, Shiftable::No(_)), "{last:?}");
}

/// A program of rapids in loops, branches and calls, and feed moves that run once.
fn flows() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        (1..30_u32, -9..9_i32).prop_map(|(n, v)| format!("#{n}=[#{}+{v}]\n", n % 7 + 1)),
        (1..8_u32).prop_map(|n| format!("G0 X#{n} Y[#{n}*2 MOD 7]\n")),
        Just("G0 Z[#1 LT #2]\n".to_owned()),
    ];
    let body = prop::collection::vec(leaf, 1..4).prop_map(|lines| lines.concat());
    let part = (0..6_u32, 1..4_u32, body).prop_map(|(kind, count, body)| match kind {
        0 => format!("oL repeat [{count}]\n{body}oL endrepeat\n"),
        1 => format!("oL if [#{count} GT 0]\n{body}oL else\nG0 X-1\noL endif\n"),
        2 => format!("oL sub\n{body}oL endsub\noL call [{count}] [#3]\noL call\n"),
        3 => format!("#31=0\noL while [#31 LT {count}]\n{body}#31=[#31+1]\noL endwhile\n"),
        4 => format!(
            "#31=0\noL while [#31 LT {count}]\n#31=[#31+1]\noLL if [#31 EQ 2]\noL continue\noLL endif\n{body}oL endwhile\n"
        ),
        _ => format!("#31=0\noL do\n{body}#31=[#31+1]\noL while [#31 LT {count}]\n"),
    });
    prop::collection::vec(part, 0..5).prop_map(|parts| {
        let mut text = "G21 G90 G0 X0 Y0 Z0 F100\n".to_owned();
        (1..31).for_each(|n| text.push_str(&format!("#{n}={}\n", n % 5)));
        for (k, part) in parts.iter().enumerate() {
            text.push_str(&part.replace("oLL", &format!("o{}", 200 + k)).replace("oL", &format!("o{}", 100 + k)));
            text.push_str(&format!("G1 X[#1+{k}] Y#2\n"));
        }
        text + "M2\n"
    })
}

proptest! {
    #[test]
    fn the_flat_program_makes_the_moves_of_the_evaluated_one(text in flows()) {
        let (program, toolpath) = evaluated(Dialect::LinuxCnc, &text);
        prop_assert_eq!(edit(&program, &Edits::new()).expect("no edits"), text.as_bytes());
        let (_, of_flat) = evaluated(Dialect::LinuxCnc, &flat(Dialect::LinuxCnc, &text));
        prop_assert_eq!(toolpath.moves.len(), of_flat.moves.len());
        for (a, b) in toolpath.moves.iter().zip(&of_flat.moves) {
            prop_assert_eq!((a.start, a.end, a.kind), (b.start, b.end, b.kind));
            prop_assert_eq!(a.shiftable, b.shiftable);
        }
    }

    /// Lines of flow in any order, in both dialects.
    #[test]
    fn no_flow_panics(
        lines in prop::collection::vec(
            prop_oneof![
                Just("o1 if [#1 GT #500]"), Just("o1 elseif [#5061]"), Just("o1 else"), Just("o1 endif"), Just("o2 while [#1 LT 3]"),
                Just("o2 endwhile"), Just("o3 do"), Just("o3 while [#31]"), Just("o4 repeat [2]"), Just("o4 endrepeat"), Just("o2 break"),
                Just("o3 continue"), Just("o5 sub"), Just("o5 return [#1]"), Just("o5 endsub"), Just("o5 call [1]"), Just("o<spot> call [2]"),
                Just("#1=[#1+1]"), Just("#500=1"), Just("#[#31]=2"), Just("G1 X#1 F100"), Just("G0 X#500"), Just("/G1 Y#1"), Just("/#1=2"),
                Just("N1 G0 X1"), Just("IF[#1LT2]GOTO1"), Just("IF[#500LT2]GOTO1"), Just("GOTO1"), Just("WHILE[#500LT2]DO1"),
                Just("WHILE[#1LT2]DO1"), Just("END1"), Just("M98 P1"), Just("M98 P500"), Just("O500"), Just("M99"), Just("M99 P1"),
                Just("G65 P500 A1"), Just("M97 P1"), Just("%"), Just("M2"), Just("#1=#1+1"), Just("M73"), Just("IF[#500EQ1]THEN#1=2"),
            ],
            0..20,
        ),
        fanuc in any::<bool>(),
    ) {
        let text = lines.join("\n");
        let options: Options = if fanuc { Dialect::Fanuc.into() } else { Dialect::LinuxCnc.into() };
        let mut program = parse(text.as_str());
        if evaluate(&mut program, &options, &files).is_ok() {
            let _ = interpret(&program, &options);
        }
        prop_assert_eq!(program.bytes(), text.as_bytes());
        let _ = expand(&parse(text), &options, &files);
    }
}

#[test]
fn rapids_in_loops_stay_rapids() {
    let (_, toolpath) = evaluated(Dialect::LinuxCnc, "G21 G0 X0 Y0 Z0\no1 repeat [3]\nG0 X1\no1 endrepeat\nM2\n");
    assert_eq!(toolpath.moves.iter().filter(|of| of.kind == MoveKind::Rapid).count(), 4);
}
