//! SINUMERIK circles that the control computes: CIP and CT. The blocks are left alone, their ends and paths are known.

use gcode::{Dialect, Fixed, MoveKind, Options, Shiftable, Toolpath, evaluate, expand, interpret, parse};

/// Start of a program at a known place.
const START: &str = "G17 G54 G90 G71 G94\nG0 X0 Y0 Z0\nF600\n";
const ADJOINING: Shiftable = Shiftable::No(Fixed::Adjoining);

fn read(text: &str) -> Toolpath {
    let text = format!("{START}{text}");
    let mut program = Dialect::Sinumerik.read(parse(text.as_str()));
    let options = Options::from(Dialect::Sinumerik);
    evaluate(&mut program, &options, &|_| None).unwrap_or_else(|error| panic!("{text}\n{error}"));
    interpret(&program, &options).unwrap_or_else(|error| panic!("{text}\n{error}"))
}

/// Checks that the last moves of two programs have the same path, to 1e-9 mm, and the same feed.
fn assert_alike(text: &str, other: &str) {
    let (path, like) = (read(text), read(other));
    let (step, same) = (path.moves.last().expect("a move"), like.moves.last().expect("a move"));
    assert!(matches!(step.kind, MoveKind::Arc(_)), "{text}: {step:?}");
    for part in 0..=10 {
        let (at, wanted) = (step.point_mm(f64::from(part) / 10.0), same.point_mm(f64::from(part) / 10.0));
        let apart = at.iter().zip(wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-9, "{text}: {at:?} instead of {wanted:?}");
    }
    assert_eq!(step.shiftable, ADJOINING, "{text}");
    assert_eq!(step.feed, same.feed, "{text}");
}

#[test]
fn a_circle_through_a_point_is_that_about_its_centre() {
    for (text, same) in [
        // The example of the manual: from (30, 40).
        ("G0 X30 Y40\nCIP X50 Y40 I1=40 J1=45", "G0 X30 Y40\nG2 X50 Y40 I10 J-7.5"),
        ("G0 X30 Y40 Z-5\nCIP X50 Y40 I1=40 J1=45", "G0 X30 Y40 Z-5\nG2 X50 Y40 I10 J-7.5"),
        ("G0 X30 Y40 Z-5\nCIP X50 Y40 Z-5 I1=40 J1=45 K1=-5", "G0 X30 Y40 Z-5\nG2 X50 Y40 I10 J-7.5"),
        ("G0 X30 Y40\nG91 CIP X20 Y0 I1=10 J1=5", "G0 X30 Y40\nG2 X50 Y40 I10 J-7.5"),
        ("G0 X30 Y40\nG91 CIP X20 Y0 I1=AC(40) J1=5", "G0 X30 Y40\nG2 X50 Y40 I10 J-7.5"),
        ("G0 X30 Y40\nCIP X=IC(20) Y40 I1=IC(10) J1=IC(5)", "G0 X30 Y40\nG2 X50 Y40 I10 J-7.5"),
        ("G0 X30 Y40\nR1=40 R2=45\nCIP X50 Y=R1 I1=R1 J1=R2", "G0 X30 Y40\nG2 X50 Y40 I10 J-7.5"),
        // The direction follows from the intermediate point.
        ("G0 X10\nCIP X-10 Y0 I1=0 J1=10", "G0 X10\nG3 X-10 Y0 I-10 J0"),
        ("G0 X10\nCIP X0 Y10 I1=-10 J1=0", "G0 X10\nG2 X0 Y10 I-10 J0"),
        // Modal, and not shifted by the frame twice.
        ("CIP X10 Y0 I1=5 J1=5\nX20 Y0 I1=15 J1=-5", "G0 X10\nG3 X20 Y0 I5 J0"),
        ("TRANS X100\nG0 X0 Y0\nCIP X10 Y0 I1=5 J1=5", "TRANS X100\nG0 X0 Y0\nG2 X10 Y0 I5 J0"),
        // Other planes, active or not.
        ("G18 CIP X10 Z0 I1=5 K1=5", "G18 G3 X10 Z0 I5 K0"),
        ("CIP X10 Y0 Z0 I1=5 J1=0 K1=5", "G18 G3 X10 Z0 I5 K0"),
        ("G19 CIP Y10 Z0 J1=5 K1=5", "G19 G2 Y10 Z0 J5 K0"),
        ("G70 CIP X1 Y0 I1=0.5 J1=0.5", "G70 G2 X1 Y0 I0.5 J0"),
    ] {
        assert_alike(text, same);
    }
}

#[test]
fn a_tangential_circle_continues_lines_and_circles() {
    for (text, same) in [
        ("G1 X10\nCT X20 Y10", "G0 X10\nG3 X20 Y10 I0 J10"),
        ("G1 X10\nG4 F1\nCT X20 Y-10", "G0 X10\nG2 X20 Y-10 I0 J-10"),
        ("G1 X10 Z-5\nCT X20 Y10", "G0 X10 Z-5\nG3 X20 Y10 I0 J10"),
        ("G1 X10\nCT X20 Y10\nX10 Y20", "G0 X20 Y10\nG3 X10 Y20 I-10 J0"),
        ("G3 X10 Y10 I0 J10\nCT X0 Y20", "G0 X10 Y10\nG3 X0 Y20 I-10 J0"),
        ("CIP X10 Y0 I1=5 J1=5\nCT X20 Y0", "G0 X10\nG3 X20 Y0 I5 J0"),
        ("G18 G1 X10\nCT X20 Z10", "G18 G0 X10\nG2 X20 Z10 I0 K10"),
        ("G91 G1 X10\nCT X10 Y10", "G0 X10\nG3 X20 Y10 I0 J10"),
    ] {
        assert_alike(text, same);
    }
    // The extension of the tangent runs through the end.
    let line = read("G1 X10\nCT X20");
    assert_eq!((line.moves[2].kind, line.moves[2].shiftable), (MoveKind::Line, ADJOINING));
    assert!(line.warnings.is_empty(), "{:?}", line.warnings);
}

#[test]
fn the_moves_around_a_computed_circle_are_compensated() {
    let path = read("G1 X10\nX20\nCIP X40 Y0 I1=30 J1=10\nG1 X50\nX60\nCT X70 Y10\nG1 Y20\nG91 Y5");
    let (yes, no) = (Shiftable::Yes, ADJOINING);
    // CT needs the direction of the move before it.
    let shiftable: Vec<_> = path.moves[1..].iter().map(|step| step.shiftable).collect();
    assert_eq!(shiftable, [yes, yes, no, yes, no, no, yes, yes]);
    assert_eq!(path.moves.last().and_then(|step| step.end.xyz_mm()), Some([70.0, 25.0, 0.0]));
    assert!(path.warnings.is_empty(), "{:?}", path.warnings);
}

#[test]
fn circles_that_are_not_determined_are_reported_and_end_where_they_state() {
    for (text, what) in [
        ("CIP X10 Y10 I1=5 J1=5", "lie on a line"),
        ("CIP X0 Y0 I1=5 J1=5", "two of them coincide"),
        ("CIP X10 Y0 I1=10 J1=0", "two of them coincide"),
        ("CIP X10 Y0 I1=5", "not stated whole"),
        ("CIP X10 Y0 Z5 I1=5 J1=5 K1=5", "no main plane"),
        ("CIP X10 Y0 I1=5 J1=5 TURN=1", "TURN"),
        ("CIP X10 Y0 I1=R9 J1=5", "only when the program runs"),
        ("CT X10 Y10", "no line or circle before"),
        ("G1 Z5\nCT X10 Y10", "no line or circle before"),
        ("G33 Z5 K1\nCT X10 Y10", "no line or circle before"),
        ("G1 X5\nCSPLINE X7 Y3\nX9\nCT X10 Y10", "no line or circle before"),
        ("G1 X5\nCT X-10", "no circle continues"),
        ("G1 X5\nCT X5", "no circle continues"),
    ] {
        let path = read(&format!("{text}\nG1 X50 F600"));
        let [.., step, after] = path.moves.as_slice() else { panic!("{text}") };
        assert_eq!(step.kind, MoveKind::Line, "{text}");
        let reason = if text.contains("R9") { Fixed::RunTime } else { Fixed::NotUnderstood };
        assert_eq!(step.shiftable, Shiftable::No(reason), "{text}");
        assert!(after.start.xyz_mm().is_some() && after.shiftable == Shiftable::Yes, "{text}: {after:?}");
        let line = START.lines().count() + text.lines().count();
        let warning = path.warnings.iter().find(|warning| warning.message.contains(what));
        assert_eq!(warning.map(|warning| warning.line), Some(line), "{text}: {:?}", path.warnings);
    }
}

#[test]
fn nothing_is_known_after_a_circle_that_is_not_read() {
    for text in [
        "CIP X10 Y0 I1=5 J1=5 I1=6",
        "CIP X10 Y0 CR=5",
        "CIP AP=30 RP=10 I1=5 J1=5",
        "CIP X10 Y0 I2=5 J1=5",
        "G1 X5\nCT X10 Y0 I1=5",
        "SUPA CIP X10 Y0 I1=5 J1=5",
        "G1 X5\nCT X=DC(10)",
    ] {
        let path = read(&format!("{text}\nG1 Y50"));
        let [.., step, after] = path.moves.as_slice() else { panic!("{text}") };
        assert!(matches!((step.kind, step.shiftable), (MoveKind::Line, Shiftable::No(_))), "{text}: {step:?}");
        assert_eq!(after.shiftable, Shiftable::No(Fixed::UnknownStart), "{text}");
    }
}

#[test]
fn an_unknown_start_leaves_the_path_open_and_the_end_known() {
    let path = read("G55\nCIP X10 Y0 Z0 I1=5 J1=5\nG1 X20");
    assert_eq!((path.moves[1].kind, path.moves[1].shiftable), (MoveKind::Line, Shiftable::No(Fixed::UnknownStart)));
    assert_eq!(path.moves[2].shiftable, Shiftable::Yes);
    // Incremental words lead nowhere from there.
    let path = read("G55\nG91 CIP X10 Y0 I1=5 J1=5\nG90 G1 X20");
    assert_eq!(path.moves[2].shiftable, Shiftable::No(Fixed::UnknownStart));
}

#[test]
fn a_flat_program_keeps_how_values_are_meant() {
    let text = "R1=5\nFOR R2=1 TO 2\nG1 X0 Y0 F100\nCIP X=IC(R1*2) I1=IC(R1) J1=AC(R1)\nENDFOR\nG1 AP=IC(R1)\n";
    let program = Dialect::Sinumerik.read(parse(text));
    let flat = expand(&program, &Options::from(Dialect::Sinumerik), &|_| None).unwrap_or_else(|error| panic!("{error}"));
    let flat = String::from_utf8(flat).expect("text");
    assert_eq!(flat.matches("I1=IC(5.) J1=AC(5.)").count(), 2, "{flat}");
    assert!(flat.contains("AP=IC(5.)"), "{flat}");
}

#[test]
fn two_paths_in_one_block_contradict_each_other() {
    let refused = |block: &str| {
        let text = format!("{START}{block}");
        let error = interpret(&Dialect::Sinumerik.read(parse(&*text)), &Dialect::Sinumerik.into()).expect_err(&text);
        error.to_string()
    };
    for (block, second) in
        [("CIP CT X5 Y5 I1=1 J1=2", "CT"), ("CT ASPLINE X5", "ASPLINE"), ("BSPLINE CSPLINE X5", "CSPLINE"), ("G1 CIP X5", "CIP")]
    {
        assert!(refused(block).contains(&format!("{second} contradicts")), "{block}: {}", refused(block));
    }
}
