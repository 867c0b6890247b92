//! Semantics of small programs.

use std::f64::consts::{FRAC_PI_2, TAU};

use gcode::{
    Arc, ArcCentres, Axis, CutterCompensation, Dialect, Feed, FeedMode, Fixed, Move, MoveKind, Options, PathMode, Plane,
    Shiftable, ToolLength, Toolpath, WorkOffset, interpret, parse,
};

fn read_as(dialect: Dialect, text: &str) -> Toolpath {
    match interpret(&parse(text), &dialect.into()) {
        Ok(toolpath) => toolpath,
        Err(error) => panic!("{error}\n{text}"),
    }
}

fn read(text: &str) -> Toolpath {
    read_as(Dialect::Fanuc, text)
}

fn arc(step: &Move) -> Arc {
    match step.kind {
        MoveKind::Arc(arc) => arc,
        other => panic!("no arc: {other:?}"),
    }
}

fn last(toolpath: &Toolpath) -> Move {
    *toolpath.moves.last().expect("there is a move")
}

fn close(a: [f64; 3], b: [f64; 3]) {
    assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9), "{a:?} is not {b:?}");
}

#[test]
fn units_distances_and_feeds() {
    let path = read("G20 G90\nG0 X1 Y1 Z1\nG1 X2 F60\nG91 Y.5\nG21 Z25.4 F120\n");
    assert_eq!(path.moves[1].feed, Some(Feed::Linear { mm_s: 25.4 }));
    close(last(&path).end.xyz_mm().expect("known"), [50.8, 38.1, 50.8]);
    assert_eq!(last(&path).feed, Some(Feed::Linear { mm_s: 2.0 }));
    assert_eq!(last(&path).feed_word, Some(120.0));
    let inverse = read("G21 G93 G0 X0 Y0 Z0\nG1 X1 F30\n");
    assert_eq!(last(&inverse).feed, Some(Feed::Duration { seconds: 2.0 }));
    assert_eq!(inverse.modal(&last(&inverse)).feed_mode, FeedMode::InverseTime);
    let per_turn = read("G21 G95 S600 G0 X0 Y0 Z0\nG1 X1 F.1\n");
    assert_eq!(last(&per_turn).feed, Some(Feed::Linear { mm_s: 1.0 }));
    let turning = read("G20 G0 X0 Y0 Z0 A0\nG1 A90 F180\n");
    assert!(matches!(last(&turning).feed, Some(Feed::Angular { rad_s }) if (rad_s - TAU / 120.0).abs() < 1e-12));
    assert!((last(&turning).end.rotary_rad()[0].expect("known") - FRAC_PI_2).abs() < 1e-12);
}

#[test]
fn arcs_in_all_planes_turn_about_their_normal() {
    // Counter-clockwise quarter about the normal, seen from its tip: XY from X to Y, ZX from Z to X, YZ from Y to Z.
    for (text, plane, end, middle) in [
        ("G17 G3 X0 Y10 I-10", Plane::Xy, [0.0, 10.0, 0.0], [1.0, 1.0, 0.0]),
        ("G19 G3 Y0 Z10 J-10", Plane::Yz, [0.0, 0.0, 10.0], [0.0, 1.0, 1.0]),
        ("G18 G3 Z0 X10 K-10", Plane::Zx, [10.0, 0.0, 0.0], [1.0, 0.0, 1.0]),
    ] {
        let start = ["X10 Y0 Z0", "X0 Y10 Z0", "X0 Y0 Z10"]
            [[Plane::Xy, Plane::Yz, Plane::Zx].iter().position(|p| *p == plane).expect("listed")];
        let path = read(&format!("G21 G0 {start}\n{text} F100\n"));
        let step = last(&path);
        assert_eq!(arc(&step).plane, plane);
        assert!((arc(&step).sweep - FRAC_PI_2).abs() < 1e-12);
        close(step.point_mm(1.0), end);
        close(step.point_mm(0.5), middle.map(|m| m * 10.0 / 2.0_f64.sqrt()));
        let clockwise = read(&format!("G21 G0 {start}\n{} F100\n", text.replace("G3", "G2")));
        assert!((arc(&last(&clockwise)).sweep + 0.75 * TAU).abs() < 1e-12);
    }
}

#[test]
fn radius_and_centre_and_absolute_centre_agree() {
    let texts = [
        "G2 X20 Y10 I0 J-10",
        "G2 X20 Y10 R10",
        "G91.1 G2 X20 Y10 J-10",
        "G90.1 G2 X20 Y10 I10 J10",
        "G91 G2 X10 Y-10 R10",
        "G20 G2 X[] Y[] R[]",
    ];
    for text in texts {
        let text = text.replace("X[] Y[] R[]", "X.78740157480315 Y.39370078740157 R.39370078740157");
        let path = read(&format!("G21 G0 X10 Y20 Z0\n{text} F100\n"));
        let arc = arc(&last(&path));
        assert!((arc.sweep + FRAC_PI_2).abs() < 1e-9, "{text}: {}", arc.sweep);
        assert!((arc.centre_mm[0] - 10.0).abs() < 1e-9 && (arc.centre_mm[1] - 10.0).abs() < 1e-9, "{text}");
    }
    let long = read("G21 G0 X10 Y20 Z0\nG2 X20 Y10 R-10 F100\n");
    assert!((arc(&last(&long)).sweep + 1.5 * std::f64::consts::PI).abs() < 1e-9);
    assert!((arc(&last(&long)).centre_mm[0] - 20.0).abs() < 1e-9);
}

#[test]
fn circles_and_helices() {
    let circle = read("G21 G0 X10 Y0 Z5\nG3 I-10 Z0 F100\n");
    let step = last(&circle);
    assert_eq!(arc(&step).sweep, TAU);
    close(step.point_mm(0.25), [0.0, 10.0, 3.75]);
    assert!((step.length_mm().expect("an arc has a length") - (TAU * 10.0).hypot(5.0)).abs() < 1e-9);
    let turns = read_as(Dialect::LinuxCnc, "G21 G0 X10 Y0 Z5\nG2 X-10 I-10 Z0 P3 F100\n");
    assert!((arc(&last(&turns)).sweep + 2.5 * TAU).abs() < 1e-12);
}

#[test]
fn absolute_centres_are_recognised_only_where_nothing_else_fits() {
    let text = "G21 G0 X10 Y20 Z0\nG2 X20 Y10 I10 J10 F100\nG2 X10 Y0 I10 J10\n";
    let path = read(text);
    assert!(path.warnings.iter().any(|w| w.message.contains("absolute")));
    assert_eq!(arc(&path.moves[1]).centre_mm, [10.0, 10.0]);
    let strict = Options { arc_centres: ArcCentres::Incremental, ..Options::default() };
    assert!(interpret(&parse(text), &strict).is_err());
    assert!(interpret(&parse(format!("G91.1\n{text}")), &Options::default()).is_err());
    let stated = Options { arc_centres: ArcCentres::Absolute, ..Options::default() };
    assert!(interpret(&parse(text), &stated).is_ok_and(|path| path.warnings.is_empty()));
}

#[test]
fn shifts_leave_no_jump() {
    for shift in ["G92 X0 Y0", "G52 X10 Y5"] {
        let path = read(&format!("G21 G0 X10 Y5 Z0\nG1 X20 F100\nG0 X10 Y5\n{shift}\nG1 X10 Y0\n"));
        let step = last(&path);
        close(step.start.xyz_mm().expect("known"), [10.0, 5.0, 0.0]);
        close(step.end.xyz_mm().expect("known"), [20.0, 5.0, 0.0]);
        assert_eq!(path.modal(&step).shift[..2], [10.0, 5.0]);
        assert_eq!(path.programmed(&step, [10.0; 6], [20.0; 6])[0], 10.0);
    }
    let back = read("G21 G0 X10 Y5 Z0\nG92 X0\nG92.2\nG1 X12 F100\nG92.3\nX3\nG92.1\nX10\n");
    let ends: Vec<_> = back.moves[1..].iter().map(|m| m.end.axis(Axis::X)).collect();
    assert_eq!(ends, [Some(12.0), Some(13.0), Some(10.0)]);
    let fresh = read("G21 G92 X0 Y0 Z0\nG1 X1 F100\n");
    assert_eq!(last(&fresh).shiftable, Shiftable::Yes);
    // G52 of LinuxCNC replaces the offset of that G92, which is not known.
    let replaced = "G21 G92 X0 Y0 Z0\nG1 X1 F100\nG52 X2\nG1 Y1\nG1 X1\nG1 Y2\n";
    for (dialect, expected) in [(Dialect::LinuxCnc, [true, false, false, true]), (Dialect::Fanuc, [true; 4])] {
        let feeds = read_as(dialect, replaced).moves;
        assert_eq!(feeds.iter().map(|m| m.shiftable == Shiftable::Yes).collect::<Vec<_>>(), expected, "{dialect:?}");
    }
}

#[test]
fn what_makes_a_start_unknown() {
    for (between, known) in [
        ("", true),
        ("G28 G91 Z0\nG90", false),
        ("G55", false),
        ("G54", true),
        ("G10 L2 P1 X1", false),
        ("G10 L2 P2 X1", true),
        ("G10 L2 P2 R0", true),
        ("G1 U5 F100", false),
        ("G1 W-5 F100", false),
        ("G4 U1.", true),
        ("G10 L2 P#1 X#2", false),
        ("G53 G0 X1", false),
        ("G0 X#1", false),
        ("M6 T1", true),
        ("G43 H1", true),
        ("G31 Z-1 F10", false),
        ("G4 P100", true),
        ("G68 X0 Y0 R30\nG0 X1\nG69", false),
        ("G54.1 P1", false),
        ("G92.1", true),
        ("G80", true),
    ] {
        let path = read(&format!("G21 G90 G54 G0 X0 Y0 Z0\n{between}\nG1 X1 Y1 F100\n"));
        let expected = if known { Shiftable::Yes } else { Shiftable::No(Fixed::UnknownStart) };
        assert_eq!(last(&path).shiftable, expected, "{between}");
    }
    let linux = read_as(Dialect::LinuxCnc, "G21 G90 G0 X0 Y0 Z0\nG43 H1\nG1 X1 F100\nZ1\nX2\n");
    let starts: Vec<_> = linux.moves[1..].iter().map(|m| m.shiftable == Shiftable::Yes).collect();
    assert_eq!(starts, [false, false, true]);
    // An offset that the program states may concern any axis, until the next code.
    let stated = read_as(
        Dialect::LinuxCnc,
        "G21 G90 G0 X0 Y0 Z0\nG43.1 Y1 Z-2\nG0 X0 Z0\nG1 X1 F100\nG0 X0 Y0\nG1 X1\nG49\nG0 X0 Z0\nG1 X2\nG0 Y0\nG1 X3\n",
    );
    let feeds: Vec<_> = stated.moves.iter().filter(|m| m.is_feed()).map(|m| m.shiftable == Shiftable::Yes).collect();
    assert_eq!(feeds, [false, true, false, true]);
    let flat = read("G21 G0 X0 Y0\nG1 X1 F100\n");
    assert_eq!(last(&flat).shiftable, Shiftable::Yes, "Z is never named");
}

#[test]
fn moves_that_are_not_changed() {
    let path = read(
        "G21 G0 X0 Y0 Z0\nG1 X1 F100\n/G1 X2\nM6 T2 X3\nG41 D1 X4\nX5\nG40 X6\nX7\nG53 X0\nG0 X0 Y0\nG33 Z-1 F1\nG4 P1500\n",
    );
    use Fixed::{CutterCompensation as Cutter, Dwell, MachineCoordinates, OptionalBlock, Rapid, Threading, ToolChange};
    let reasons: Vec<_> = path.moves.iter().map(|m| m.shiftable).collect();
    let no = Shiftable::No;
    assert_eq!(
        reasons,
        [
            no(Rapid),
            Shiftable::Yes,
            no(OptionalBlock),
            no(ToolChange),
            no(Cutter),
            no(Cutter),
            no(Cutter),
            Shiftable::Yes,
            no(MachineCoordinates),
            no(Rapid),
            no(Threading),
            no(Dwell),
        ]
    );
    assert_eq!(path.modal(&path.moves[5]).cutter, CutterCompensation::Left);
    assert_eq!(last(&path).kind, MoveKind::Dwell { seconds: Some(1.5) });
    let dwell = read_as(Dialect::LinuxCnc, "G4 P1.5\n");
    assert_eq!(last(&dwell).kind, MoveKind::Dwell { seconds: Some(1.5) });
    let skipped = Options { block_delete: Some(true), ..Options::default() };
    let text = parse("G21 G0 X0 Y0 Z0\n/G1 X2 F1\nG1 X1 F100\n");
    assert_eq!(interpret(&text, &skipped).expect("valid").moves.len(), 2);
}

#[test]
fn a_cancelled_cycle_leaves_the_motion_beside_it_active() {
    for dialect in [Dialect::Fanuc, Dialect::LinuxCnc] {
        let path = read_as(dialect, "G21 G90 G1 X1 F100\nG80 G0 X2\nX3\nG1 G80 X4\nX5\n");
        let feeds: Vec<bool> = path.moves.iter().map(|step| step.is_feed()).collect();
        assert_eq!(feeds, [true, false, false, true, true], "{dialect:?}");
    }
}

#[test]
fn cycles_repeat_until_they_are_cancelled() {
    let path = read("G21 G90 G0 X0 Y0 Z10\nG98 G81 X1 Z-5 R2 F100\nX2\nM8\nG99 X3\nG91 X1 K3\nG90 G80\nX9\nG1 Z0 F1\n");
    let kinds: Vec<_> = path.moves.iter().map(|m| matches!(m.kind, MoveKind::Cycle(_))).collect();
    assert_eq!(kinds, [false, true, true, true, true, false, false]);
    let ends: Vec<_> = path.moves.iter().map(|m| m.end.xyz_mm().expect("known")).collect();
    close(ends[2], [2.0, 0.0, 10.0]);
    close(ends[3], [3.0, 0.0, 2.0]);
    close(ends[4], [6.0, 0.0, 2.0]);
    close(ends[5], [9.0, 0.0, 2.0]);
    assert_eq!(path.moves[5].kind, MoveKind::Rapid);
    let MoveKind::Cycle(cycle) = path.moves[1].kind else { panic!("no cycle") };
    assert_eq!((cycle.code, cycle.bottom_mm, cycle.retract_mm, cycle.repeats), (81, Some(-5.0), Some(2.0), 1));
    let incremental = read("G21 G90 G0 X0 Y0 Z10\nG91 G99 G83 X1 Z-7 R-8 Q1 F100\n");
    let MoveKind::Cycle(cycle) = last(&incremental).kind else { panic!("no cycle") };
    assert_eq!((cycle.bottom_mm, cycle.retract_mm), (Some(-5.0), Some(2.0)));
    let higher = read_as(Dialect::LinuxCnc, "G21 G90 G0 X0 Y0 Z1\nG98 G81 X1 Z-5 R2 F100\n");
    close(last(&higher).end.xyz_mm().expect("known"), [1.0, 0.0, 2.0]);
}

#[test]
fn modal_state_travels_with_the_move() {
    let path = read_as(Dialect::LinuxCnc, "G21 G64 P0.01 Q0 G59.1 G43.4 H2 T5 S900 G18 G0 X0 Y0 Z0\nG1 X1 B30 F100\nG61.1 X2\n");
    let modal = path.modal(&path.moves[1]);
    assert_eq!(modal.path, PathMode::Continuous { tolerance_mm: Some(0.01), merge_mm: Some(0.0) });
    assert_eq!(modal.work_offset, WorkOffset::Standard(7));
    assert_eq!(modal.tool_length, ToolLength::TipControl);
    assert_eq!((modal.tool, modal.spindle_rpm, modal.plane), (Some(5), Some(900.0), Plane::Zx));
    assert!(path.moves[1].explicit_motion && !path.moves[2].explicit_motion);
    assert_eq!(path.modal(&path.moves[2]).path, PathMode::ExactStop);
    let program = parse("N1 G1 X1 Y2 F3 I#1");
    let words = Move { block: 0, ..path.moves[1] }.words(&program);
    assert_eq!((words.axes[0], words.axes[1], words.feed, words.centre[0]), (Some(2), Some(3), Some(4), None));
}

#[test]
fn the_program_ends_where_the_control_stops() {
    let path = read("%\nG21 G0 X0 Y0 Z0\nG1 X1 F100\nM30\nG1 X2\n%\nG1 X3\n");
    assert_eq!(path.moves.len(), 2);
    assert!(path.warnings[0].message.contains("ends on line 4"));
    let tape = read("%\nG21 G0 X0 Y0 Z0\n%\nG1 X1 F100\n");
    assert_eq!(tape.moves.len(), 1);
}

/// Whether the last feed move of `text` is shiftable.
fn shifts(dialect: Dialect, text: &str) -> bool {
    last(&read_as(dialect, &format!("G21 G90 G17\nG0 X0 Y0 Z0\n{text}"))).shiftable == Shiftable::Yes
}

#[test]
fn after_a_code_that_is_not_understood_nothing_is_changed_until_it_is_cancelled() {
    let (cut, again) = ("G1 X20 Y0 F600\nY10\n", "G0 X0 Y0 Z0\nG1 X5 F600\n");
    for (on, off) in [
        ("G41.2 D1", Some("G40")),
        ("G141", Some("G40")),
        ("G112", Some("G113")),
        ("G234", Some("G49")),
        ("G168", Some("G169")),
        ("G777", None),
        ("M428", None),
        ("M21", None),
        ("M71", None),
        ("TRAORI", None),
        ("AROT Z45", None),
        ("CYCLE800(1,45)", None),
        ("REPEAT", None),
        ("G10 L2 P1 R45", Some("G10 L2 P1 R0")),
        ("G10 L2 P2 R45\nG55", Some("G10 L2 P2 R0")),
        ("G10 L2 P2 R45\nG10 L2 P1 R0\nG55", Some("G10 L2 P2 R0")),
        ("G10 L2 P1 R45\nG55\nG10 L2 P2 R0\nG54", Some("G10 L2 P1 R0")),
        ("/G91", None),
        ("/G55", None),
        ("/G92 X1", None),
        ("/G10 L2 P1 X5", None),
        ("/G52 Y1", None),
    ] {
        let begun = format!("{on}\n{again}");
        assert!(!shifts(Dialect::Fanuc, &begun), "{on}");
        let path = read(&format!("G21 G90\nG0 X0 Y0 Z0\n{begun}"));
        assert!(path.warnings.iter().any(|warning| warning.message.contains("left alone")), "{on}: {:?}", path.warnings);
        if let Some(off) = off {
            assert!(!shifts(Dialect::Fanuc, &format!("{begun}{off}\n{cut}")), "{on} {off}: the place is not known yet");
            assert!(shifts(Dialect::Fanuc, &format!("{begun}{off}\n{again}")), "{on} {off}");
        }
    }
    // Messages, switches and codes declared passive open no section.
    for silent in ["MSG(\"now\")", "STOPRE", "M8", "M62 P1", "M19", "G187 P3"] {
        assert!(shifts(Dialect::Fanuc, &format!("{silent}\n{again}")), "{silent}");
    }
    assert!(shifts(Dialect::LinuxCnc, &format!("M140\n{again}")) && !shifts(Dialect::Fanuc, &format!("M140\n{again}")));
    let stated = Options { passive: gcode::PassiveCodes::default().with(428), ..Options::default() };
    let text = format!("G21 G90\nG0 X0 Y0 Z0\nM428\n{again}");
    assert_eq!(last(&interpret(&parse(text), &stated).expect("valid")).shiftable, Shiftable::Yes);
}

#[test]
fn what_an_optional_block_moves_is_unknown_until_it_is_stated() {
    let text = "G21 G90\nG0 X0 Y0 Z0\n/G1 X10 F600\nG1 Y5 F600\nX20\nY9\nG91 X5\nG90 X0\n";
    let of = |block_delete: Option<bool>| -> Vec<bool> {
        let options = Options { block_delete, ..Options::default() };
        let path = interpret(&parse(text), &options).expect("valid");
        path.moves.iter().filter(|step| step.is_feed()).map(|step| step.shiftable == Shiftable::Yes).collect()
    };
    assert_eq!(of(None), [false, false, false, true, true, true]);
    assert_eq!(of(Some(false)), [true; 6]);
    assert_eq!(of(Some(true)), [true; 5]);
}

#[test]
fn an_exponent_is_no_word_that_may_be_dropped() {
    let (dialects, again) = ([Dialect::Fanuc, Dialect::LinuxCnc], "G0 X0 Y0 Z0\nG1 X5 F600\n");
    for block in ["G4 P1e9", "G4 P1 E9", "G0 X1E3", "G92 X1E1", "S1E3 M3", "F1E3", "G10 L2 P2 X1E1", "T1E1"] {
        for dialect in dialects {
            let path = read_as(dialect, &format!("G21 G90 G17\nG0 X0 Y0 Z0\nG1 X2 F600\n{block}\n{again}"));
            assert_eq!(path.moves[1].shiftable, Shiftable::Yes, "{block}");
            assert_eq!(last(&path).shiftable, Shiftable::No(Fixed::NotUnderstood), "{block}");
            assert!(path.warnings.iter().any(|warning| warning.line == 4 && warning.message.contains("an E ")), "{block}");
        }
    }
    let dwell = read("G4 P1e9\n");
    assert_eq!(last(&dwell).kind, MoveKind::Dwell { seconds: None });
    // These codes have a word E.
    for block in ["G65 P9000 A1 E5\nG90", "M68 E0 Q1", "M67E1Q0.5", "G187 P2 E0.05", "M150 E1"] {
        let options =
            Options { macros: gcode::Macros::Keep, passive: gcode::PassiveCodes::default().with(150), ..Options::default() };
        let text = format!("G21 G90 G17\nG0 X0 Y0 Z0\n{block}\n{again}");
        assert_eq!(last(&interpret(&parse(text), &options).expect("accepted")).shiftable, Shiftable::Yes, "{block}");
    }
}

#[test]
fn an_exact_stop_for_one_block_is_one_of_that_block() {
    let path = read("G21 G90\nG0 X0 Y0 Z0\nG1 X10 F600\nG9 X20\nX30\n");
    let modes: Vec<PathMode> = path.moves.iter().map(|step| path.modal(step).path).collect();
    assert_eq!(modes, [PathMode::Default, PathMode::Default, PathMode::ExactStop, PathMode::Default]);
}

/// The modes of shiftability of the feed moves.
fn feeds(text: &str, dialect: Dialect) -> Vec<Shiftable> {
    let path = interpret(&parse(text), &dialect.into()).expect("accepted");
    path.moves.iter().filter(|m| m.is_feed()).map(|m| m.shiftable).collect()
}

#[test]
fn after_g40_the_tool_is_beside_the_contour() {
    let part = "G21 G90 G17 F600\nG0 X0 Y0 Z0\nG41 D1\nG1 X10\nG40\nG1 X20\nG1 Y5\nX0\n";
    let (beside, comp, yes) = (Shiftable::No(Fixed::UnknownStart), Shiftable::No(Fixed::CutterCompensation), Shiftable::Yes);
    assert_eq!(feeds(part, Dialect::LinuxCnc), [comp, beside, beside, yes]);
    // A Fanuc control takes the radius back in the block with G40 if that moves.
    let part = part.replace("G40\nG1 X20", "G40 G1 X20");
    assert_eq!(feeds(&part, Dialect::Fanuc), [comp, comp, yes, yes]);
    assert_eq!(feeds(&part, Dialect::LinuxCnc), [comp, comp, beside, yes]);
}

#[test]
fn a_restored_g92_is_another_frame() {
    let part = "G21 G90 F600\nG0 X0 Y0 Z0\nG92 X5\nG1 X10\nG92.3\nG1 X20\nG1 Y5 Z1\nX0\n";
    let (unknown, yes) = (Shiftable::No(Fixed::UnknownStart), Shiftable::Yes);
    assert_eq!(feeds(part, Dialect::LinuxCnc), [yes, unknown, unknown, yes]);
}

#[test]
fn a_block_that_changes_an_offset_with_its_motion_is_left_alone_on_fanuc() {
    for word in ["H2", "G43 H1", "G49", "T0101", "D3"] {
        let part = format!("G21 G90 F600\nG0 X0 Y0 Z0\nG1 X10 {word}\nG1 X20\n");
        assert_eq!(feeds(&part, Dialect::Fanuc)[0], Shiftable::No(Fixed::ToolChange), "{word}");
    }
}

#[test]
fn words_that_do_nothing_do_not_refuse_a_program() {
    let part = parse("G21 G90 G17 F600\nG0 X0 Y0 Z0\nG1 X10 L20\nG3 X10 Y10 I0 J5 K0\n");
    let path = interpret(&part, &Dialect::Fanuc.into()).expect("accepted");
    assert_eq!(path.warnings.len(), 1, "{:?}", path.warnings);
    assert!(path.warnings[0].message.starts_with("L has no meaning"));
    assert!(path.moves[1..].iter().all(|step| step.shiftable == Shiftable::Yes));
    assert!(interpret(&part, &Dialect::LinuxCnc.into()).is_err());
}

#[test]
fn a_feed_or_motion_code_that_a_switch_may_skip_leaves_the_moves_after_it_alone() {
    let (optional, yes) = (Shiftable::No(Fixed::OptionalBlock), Shiftable::Yes);
    let head = "G21 G90 F600\nG0 X0 Y0 Z0\n";
    assert_eq!(feeds(&format!("{head}G1 X1\n/F700\nX2\nX3 F500\n"), Dialect::LinuxCnc), [yes, optional, yes]);
    assert_eq!(
        feeds(&format!("{head}G1 X1\n/G0\n/G1\nX2\nG1 X3\nX4\n/G1\nX5\n"), Dialect::LinuxCnc),
        [yes, optional, Shiftable::No(Fixed::UnknownStart), yes, yes]
    );
}

#[test]
fn an_arc_keeps_its_code_for_moves_behind_blocks_that_may_be_skipped() {
    let last_arc_is_left_alone = |after: &str| {
        let path = read(&format!("G21 G17 G90 G0 X0 Y0 Z0\nG2 X10 Y0 I5 J0 F100\nX20 Y0 I5 J0\n{after}\nG1 X0 Y0\n"));
        let [first, second] = [1, 2].map(|index| path.moves[index].shiftable);
        assert_eq!(first, Shiftable::Yes);
        second == Shiftable::No(Fixed::OptionalBlock)
    };
    for after in ["/G3\nX30 Y0 I5 J0", "/G2\nX30 Y0 I5 J0"] {
        assert!(last_arc_is_left_alone(after), "{after}");
    }
    for after in ["/F200\nG2 X30 Y0 I5 J0", "X30 Y0 I5 J0\n/G1 X5", "/M8\nG2 X30 Y0 I5 J0"] {
        assert!(!last_arc_is_left_alone(after), "{after}");
    }
}

#[test]
fn moves_beside_a_corner_that_the_control_rounds_are_left_alone() {
    let path = read("G21 G17 G90 G0 X0 Y0 Z0\nG1 X5 F100\nG1 X10 ,R2.\nY10 ,c1\nX20\nX30\nM30\n");
    let kinds: Vec<_> = path.moves.iter().filter(|m| m.is_feed()).map(|m| m.shiftable).collect();
    let adjoining = Shiftable::No(Fixed::Adjoining);
    assert_eq!(kinds, [Shiftable::Yes, adjoining, adjoining, adjoining, Shiftable::Yes]);
    assert_eq!(last(&path).start.xyz_mm(), Some([20.0, 10.0, 0.0]));
    // An angle moves the end, and LinuxCNC has no such words.
    for (dialect, word) in [(Dialect::Fanuc, ",A45."), (Dialect::Fanuc, ",R"), (Dialect::LinuxCnc, ",R2.")] {
        let text = format!("G21 G17 G90 G0 X0 Y0 Z0\nG1 X10 {word} F100\nY10\n");
        assert!(interpret(&parse(text), &dialect.into()).is_err(), "{word}");
    }
}

#[test]
fn two_slashes_begin_a_comment_unless_they_hide_a_block() {
    let path = read("// Part 1\nG21 G17 G90 G0 X0 Y0 Z0 // start X5\nG1 X10 F100 // cut\nN5 // next\nY10\nM30\n");
    assert_eq!(path.moves.iter().filter(|m| m.shiftable == Shiftable::Yes).count(), 2);
    assert!(path.warnings.is_empty(), "{:?}", path.warnings);
    assert!(interpret(&parse("G21 G17 G90 G0 X0 Y0 Z0\n//G1 X10 F100\nG1 Y10 F100\n"), &Dialect::Fanuc.into()).is_err());
}
