//! Units, distances, feeds, arcs, cycles, and the modal state of moves.

use std::f64::consts::{FRAC_PI_2, TAU};

use gcode::{
    ArcCentres, Dialect, Feed, FeedMode, Move, MoveKind, Options, PathMode, Plane, Shiftable, ToolLength, WorkOffset, interpret,
    parse,
};

use crate::{arc, close, last, read, read_as};

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
    // A linear word that restates the position is no motion.
    for (words, angular) in [("X0 A90", true), ("X0 Y0. Z0 A90", true), ("X1 A90", false)] {
        let found = last(&read(&format!("G21 G90 G0 X0 Y0 Z0 A0\nG1 {words} F180\n"))).feed;
        assert_eq!(matches!(found, Some(Feed::Angular { .. })), angular, "{words}: {found:?}");
    }
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
fn circles_that_begin_beside_a_centre_given_as_a_position_leave_its_reading_open() {
    // Holes about X50 Y20 and X90 Y60, as controls with absolute centres mill them.
    let holes = "G21 G90 G0 X55 Y20 Z0\nG3 X55 Y20 I50 J20 F100\nG0 X95 Y60\nG3 X95 Y60 I90 J60\n";
    let refused = |text: &str| interpret(&parse(text), &Options::default()).err().map(|error| error.to_string());
    assert!(refused(holes).is_some_and(|text| text.contains("which they are is not known")));
    for (arc_centres, centre) in [(ArcCentres::Incremental, [105.0, 40.0]), (ArcCentres::Absolute, [50.0, 20.0])] {
        let path = interpret(&parse(holes), &Options { arc_centres, ..Options::default() }).unwrap();
        assert_eq!(arc(&path.moves[1]).centre_mm, centre);
    }
    // A half circle about X40 Y10, which is also most of a circle about X80 Y10.
    let slot = "G21 G90 G0 X40 Y0 Z0\nG3 X40 Y20 I40 J10 F100\nG1 X0\n";
    assert!(refused(slot).is_some_and(|text| text.contains("which they are is not known")));
    assert_eq!(refused("G21 G90 G0 X40 Y0 Z0\nG3 X40 Y20 I0 J10 F100\nG1 X0\n"), None);
    // An arc that fits distances alone decides, as do circles that begin beside them, statements, and controls.
    for decided in [
        &format!("{holes}G0 X0 Y0\nG2 X10 Y10 I10 J0\n"),
        &format!("{holes}G0 X0 Y0\nG2 X0 Y0 I5 J0\n"),
        &format!("{holes}G0 X0 Y0\nG2 I5\n"),
        &format!("G91.1\n{holes}"),
        "G21 G90 G0 X10 Y5 Z0\nG2 X10 Y5 I-3 J-4 F100\n",
        "G21 G90 G0 X5 Y0 Z0\nG2 X5 Y0 I-5 J0 F100\n",
    ] {
        assert_eq!(refused(decided), None, "{decided}");
    }
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

#[test]
fn an_exact_stop_for_one_block_is_one_of_that_block() {
    let path = read("G21 G90\nG0 X0 Y0 Z0\nG1 X10 F600\nG9 X20\nX30\n");
    let modes: Vec<PathMode> = path.moves.iter().map(|step| path.modal(step).path).collect();
    assert_eq!(modes, [PathMode::Default, PathMode::Default, PathMode::ExactStop, PathMode::Default]);
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
fn two_slashes_begin_a_comment_unless_they_hide_a_block() {
    let path = read("// Part 1\nG21 G17 G90 G0 X0 Y0 Z0 // start X5\nG1 X10 F100 // cut\nN5 // next\nY10\nM30\n");
    assert_eq!(path.moves.iter().filter(|m| m.shiftable == Shiftable::Yes).count(), 2);
    assert!(path.warnings.is_empty(), "{:?}", path.warnings);
    let hidden = read("G21 G17 G90 G0 X0 Y0 Z0\n//G1 X10 F100\nG1 Y10 F100\n");
    assert!(hidden.moves.iter().all(|step| step.shiftable != Shiftable::Yes) && !hidden.warnings.is_empty());
}
