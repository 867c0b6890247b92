//! SINUMERIK poles and polar coordinates: G110, G111, G112, AP, RP. The blocks are left alone, the position after them is known.

use gcode::{Dialect, Fixed, MoveKind, Options, Shiftable, Toolpath, evaluate, interpret, parse};

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

fn assert_near(at: Option<[f64; 3]>, wanted: [f64; 3], text: &str) {
    let at = at.unwrap_or_else(|| panic!("{text}: the position is not known"));
    let apart = at.iter().zip(wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart < 1e-9, "{text}: {at:?} instead of {wanted:?}");
}

#[test]
fn ends_of_polar_moves_are_known_and_the_moves_after_them_compensated() {
    let half = 3.0_f64.sqrt() / 2.0;
    for (text, end) in [
        ("G1 AP=30 RP=10", [10.0 * half, 5.0, 0.0]),
        ("G1 RP=10 AP=-90 Z-2", [0.0, -10.0, -2.0]),
        ("G111 X20 Y10\nG1 RP=50 AP=30", [20.0 + 50.0 * half, 35.0, 0.0]),
        ("G111 X20 Y10\nG0 RP=50 AP=30 Z3", [20.0 + 50.0 * half, 35.0, 3.0]),
        ("G111 X20 Y10\nG1 RP=50 AP=30 F1000\nG110 X-10 Y20\nG1 RP=30 AP=0", [40.0 + 50.0 * half, 55.0, 0.0]),
        ("G111 X20 Y10\nG112 X40 Y20\nG1 RP=30 AP=90", [60.0, 60.0, 0.0]),
        ("G111 AP=90 RP=10\nG1 AP=0 RP=5", [5.0, 10.0, 0.0]),
        ("G111 X10 Y0\nG112 AP=90 RP=10\nG1 AP=0 RP=5", [15.0, 10.0, 0.0]),
        // G91 does not concern poles.
        ("G91 G111 X20 Y10\nG90 G1 RP=5 AP=0", [25.0, 10.0, 0.0]),
        ("G111 X20 Y10\nG91 G1 RP=5 AP=AC(90) Z1", [20.0, 15.0, 1.0]),
        // Stored coordinates.
        ("G1 AP=0 RP=10\nAP=90", [0.0, 10.0, 0.0]),
        ("G1 AP=90 RP=10\nRP=20", [0.0, 20.0, 0.0]),
        ("G1 AP=30 RP=10\nAP=IC(60)\nAP=IC(90)", [-10.0, 0.0, 0.0]),
        ("R1=90 R2=7\nG1 AP=R1 RP=R2", [0.0, 7.0, 0.0]),
        ("R1=30\nG1 AP=60 RP=7\nAP=IC(R1)", [0.0, 7.0, 0.0]),
        ("TRANS X100\nG111 X20 Y10\nG1 RP=5 AP=0", [125.0, 10.0, 0.0]),
        ("G70 G111 X1 Y0\nG1 RP=1 AP=0", [50.8, 0.0, 0.0]),
        ("G18 G111 Z20 X10\nG1 RP=5 AP=90", [15.0, 0.0, 20.0]),
        ("G19 G111 Y20 Z10\nG1 RP=5 AP=0", [0.0, 25.0, 10.0]),
        // The end is that of the program where the start is not known.
        ("G55 G0 Z3\nG111 X1 Y1\nG0 AP=0 RP=5", [6.0, 1.0, 3.0]),
    ] {
        let path = read(&format!("{text}\nG71 G1 X=IC(1) F600"));
        let [.., step, after] = path.moves.as_slice() else { panic!("{text}") };
        assert_near(step.end.xyz_mm(), end, text);
        let is_rapid = step.kind == MoveKind::Rapid;
        assert_eq!(step.shiftable, if is_rapid { Shiftable::No(Fixed::Rapid) } else { ADJOINING }, "{text}");
        assert_eq!(after.shiftable, Shiftable::Yes, "{text}");
        assert_near(after.end.xyz_mm(), [end[0] + 1.0, end[1], end[2]], text);
        assert!(path.warnings.is_empty(), "{text}: {:?}", path.warnings);
    }
}

#[test]
fn the_pole_is_the_centre_of_a_polar_circle() {
    for (text, same) in [
        // The example of the manual.
        ("G0 X30 Y40\nG111 X40 Y33\nG2 RP=12.207 AP=21", "G0 X30 Y40\nG2 X=40+12.207*COS(21) Y=33+12.207*SIN(21) I10 J-7"),
        ("G0 X10\nG3 AP=90 RP=10", "G0 X10\nG3 X0 Y10 I-10 J0"),
        ("G0 X10\nG3 AP=90 RP=10\nAP=IC(90)", "G0 Y10\nG3 X-10 Y0 I0 J-10"),
        ("G0 X10\nG2 AP=90 RP=10 Z-5", "G0 X10\nG2 X0 Y10 Z-5 I-10 J0"),
    ] {
        let (path, like) = (read(text), read(same));
        let (step, wanted) = (path.moves.last().expect("a move"), like.moves.last().expect("a move"));
        assert!(matches!(step.kind, MoveKind::Arc(_)) && step.shiftable == ADJOINING, "{text}: {step:?}");
        for part in 0..=10 {
            let fraction = f64::from(part) / 10.0;
            assert_near(Some(step.point_mm(fraction)), wanted.point_mm(fraction), text);
        }
        assert_eq!(step.feed, wanted.feed, "{text}");
    }
}

#[test]
fn a_circle_whose_pole_is_not_its_centre_ends_where_it_states() {
    for text in ["G0 X10\nG111 X3 Y3\nG3 AP=0 RP=10", "G0 X10\nG3 AP=0 RP=10", "G0 X10\nG3 AP=90 RP=10 TURN=1"] {
        let path = read(&format!("{text}\nG1 X50"));
        let [.., step, after] = path.moves.as_slice() else { panic!("{text}") };
        assert_eq!((step.kind, step.shiftable), (MoveKind::Line, Shiftable::No(Fixed::NotUnderstood)), "{text}");
        assert!(after.start.xyz_mm().is_some() && after.shiftable == Shiftable::Yes, "{text}");
        assert_eq!(path.warnings[0].line, START.lines().count() + text.lines().count(), "{text}");
    }
}

#[test]
fn nothing_is_known_after_a_polar_move_that_is_not_determined() {
    for text in [
        // The pole.
        "G111 X5\nG1 AP=0 RP=5",
        "G111 X5 Y5 Z5\nG1 AP=0 RP=5",
        "G111 X=IC(5) Y5\nG1 AP=0 RP=5",
        "G110 AP=30 RP=5\nG1 AP=0 RP=5",
        "G111 AP=30\nG1 AP=0 RP=5",
        "G111 AP=IC(30) RP=5\nG1 AP=0 RP=5",
        "G111 X=R9 Y5\nG1 AP=0 RP=5",
        "G111 X5 Y5\nTRANS X1\nG1 AP=0 RP=5",
        "G111 X5 Y5\nG18 G1 AP=0 RP=5",
        "G111 X5 Y5\nG55\nG1 AP=0 RP=5",
        "G55\nG110 X5 Y5\nG1 AP=0 RP=5",
        "T1 M6\nG110 X5 Y5\nG1 AP=0 RP=5",
        "/G111 X5 Y5\nG1 AP=0 RP=5",
        "TRANS G111 X5 Y5\nG0 X0 Y0 Z0\nG1 AP=0 RP=5",
        "G111 G110 X5 Y5\nG1 AP=0 RP=5",
        "G153 G111 X5 Y5\nG1 AP=0 RP=5",
        "G1 G111 X5 Y5\nG1 AP=0 RP=5",
        "G111 X5 Y5 Q5\nG1 AP=0 RP=5",
        "CYCLE81(10,0,2,-5)\nG0 X0 Y0 Z0\nG1 AP=0 RP=5",
        "ROT RPL=30\nG111 X5 Y5\nTRANS\nG0 X0 Y0 Z0\nG1 AP=0 RP=5",
        // Coordinates that are not stated, or not to be understood.
        "G1 AP=0",
        "G1 RP=5",
        "G1 AP=IC(30) RP=5",
        "G1 AP=30 RP=5\nX0\nAP=60",
        "G1 AP=30 RP=5\nX0\nAP=IC(60)",
        "G1 AP=30 RP=5\nG111 X0 Y0\nAP=60",
        "G91 G1 AP=30 RP=5",
        "G1 AP=30 RP=0",
        "G1 AP=30 RP=-5",
        "G1 AP=30 RP=IC(5)",
        "G1 AP=400 RP=5",
        "G1 AP=R9 RP=5",
        "G0 AP=R9 RP=5",
        "G1 AP=DC(30) RP=5",
        // Other words.
        "G1 AP=30 RP=5 X1",
        "G1 AP=30 AP=40 RP=5",
        "G0 AP=30 RP=5 Y1",
        "G0 X5\nG3 AP=30 RP=5 I-5 J0",
        "G0 X5\nG3 AP=30 RP=5 CR=5",
        "G1 AP=30 RP=5 ANG=3",
        "CSPLINE AP=30 RP=5",
        "SUPA G1 AP=30 RP=5",
        "SUPA G0 AP=30 RP=5",
    ] {
        let path = read(&format!("{text}\nG90 G1 X50 F600"));
        let [.., step, after] = path.moves.as_slice() else { panic!("{text}") };
        assert!(matches!(step.shiftable, Shiftable::No(_)), "{text}: {step:?}");
        assert!(after.start.xyz_mm().is_none() && after.shiftable != Shiftable::Yes, "{text}: {after:?}");
    }
}

#[test]
fn a_polar_move_in_a_block_that_may_not_run_ends_what_is_known() {
    for text in
        ["/G1 AP=30 RP=5", "IF $AC_TIMER[1]>0\nG1 AP=30 RP=5\nENDIF", "IF $AC_TIMER[1]>0\nG111 X5 Y5\nENDIF\nG1 AP=0 RP=5"]
    {
        let path = read(&format!("{text}\nG1 X50"));
        assert_ne!(path.moves.last().map(|step| step.shiftable), Some(Shiftable::Yes), "{text}");
    }
}

#[test]
fn a_pole_measured_from_the_position_keeps_the_move_before_it() {
    let path = read("G1 X5\nX10\nG110 X0 Y5\nG1 AP=0 RP=5");
    let shiftable: Vec<_> = path.moves[1..].iter().map(|step| step.shiftable).collect();
    assert_eq!(shiftable, [Shiftable::Yes, ADJOINING, ADJOINING]);
    assert_near(path.moves[3].end.xyz_mm(), [15.0, 5.0, 0.0], "G110");
}
