//! Words that only some controls read as a move, and what is taken where the control is not known.

use gcode::{DecimalPoint, Dialect, Fixed, GcodeError, MoveKind, Options, Shiftable, Toolpath, WorkOffset, interpret, parse};

const HEAD: &str = "G21 G90 G17 G54\nG0 X10. Y20. Z5.\nG1 Z4. F600\n";

fn read(dialect: Dialect, body: &str) -> Toolpath {
    interpret(&parse(format!("{HEAD}{body}")), &dialect.into()).unwrap_or_else(|error| panic!("{body}: {error}"))
}

/// Whether each move after those of the head may be changed.
fn shiftable(dialect: Dialect, body: &str) -> Vec<Shiftable> {
    read(dialect, body).moves[2..].iter().filter(|step| step.is_feed()).map(|step| step.shiftable).collect()
}

const YES: Shiftable = Shiftable::Yes;
const UNKNOWN: Shiftable = Shiftable::No(Fixed::UnknownStart);
const LEFT: Shiftable = Shiftable::No(Fixed::NotUnderstood);

#[test]
fn axis_words_that_are_data_move_nothing() {
    for block in ["G22 X200. Y150. Z100. I-50. J-50. K-80.", "G5.1 Q3 X0 Y0 Z0", "G05.1 Q2 X0 Y0 Z0"] {
        let path = read(Dialect::Fanuc, &format!("{block}\nG1 Z-1.\n"));
        let step = path.moves.last().expect("there are moves");
        assert_eq!((step.start.xyz_mm(), step.end.xyz_mm()), (Some([10.0, 20.0, 4.0]), Some([10.0, 20.0, -1.0])), "{block}");
        assert_eq!(path.moves.len(), 3, "{block}");
    }
}

#[test]
fn axis_words_with_an_unknown_effect_leave_the_position_unknown() {
    let codes =
        ["G5.1 I1", "G92.1", "G50.1", "G69", "G25", "G8", "G63", "G187", "G103", "G15", "G13.1", "G91.1", "G67", "G4 P500"];
    for code in codes {
        let body = format!("{code} X0 Y0\nG1 Z-1.\nX30.\nY30.\nX40.\n");
        let of = shiftable(Dialect::Fanuc, &body);
        let moves: Vec<_> = of.iter().filter(|shiftable| **shiftable != LEFT).collect();
        // X and Y are unknown until a move states them; then so is nothing.
        assert_eq!(moves.last(), Some(&&YES), "{code}: {of:?}");
        assert_eq!(moves.iter().filter(|shiftable| **shiftable == &UNKNOWN).count(), 3, "{code}: {of:?}");
    }
}

#[test]
fn a_motion_code_beside_a_code_with_axis_words_stays_in_force() {
    let path = read(Dialect::Fanuc, "G0 G28 X0 Y0\nX10. Y20. Z4.\n");
    assert_eq!(path.moves.last().map(|step| step.kind), Some(MoveKind::Rapid));
}

#[test]
fn ordinary_codes_keep_their_moves() {
    for code in ["G17", "G21", "G40", "G54", "G90", "G94", "G61", "G64", "G98", "G80", "G9", "G91.1 G1"] {
        let path = read(Dialect::Fanuc, &format!("{code} X30.\n"));
        assert_eq!(path.moves.last().and_then(|step| step.end.xyz_mm()), Some([30.0, 20.0, 4.0]), "{code}");
    }
}

#[test]
fn a_numbered_offset_may_follow_g54() {
    let path = read(Dialect::Fanuc, "G54 P2\nX50. Y20.\nG1 X10.\n");
    let last = path.moves.last().expect("there are moves");
    assert_eq!(path.modal(last).work_offset, WorkOffset::Extended(2));
    assert_eq!(last.shiftable, UNKNOWN);
    let other = read(Dialect::Fanuc, "G55 P2\nG1 X10.\n");
    assert_eq!(other.modal(other.moves.last().expect("there are moves")).work_offset, WorkOffset::Unpredictable);
}

#[test]
fn a_pattern_of_holes_changes_no_units() {
    for block in ["G71 I1. J0. K30. L6", "G70 I5. J15. L12", "G72 I5. J15. L3"] {
        let path = read(Dialect::Fanuc, &format!("G81 G99 X5. Y5. Z-2. R1. L0\n{block}\nG80\nG1 X20. Y5. Z4.\nX30.\n"));
        let last = path.moves.last().expect("there are moves");
        assert_eq!((path.modal(last).units.mm(), last.shiftable), (1.0, YES), "{block}");
        assert_eq!(path.moves[path.moves.len() - 2].shiftable, UNKNOWN, "{block}");
    }
}

#[test]
fn a_feed_beside_a_dwell_is_not_taken() {
    assert_eq!(shiftable(Dialect::Fanuc, "G4 F60\nG1 X20.\nX30. F600\n"), [LEFT, YES]);
    assert_eq!(shiftable(Dialect::LinuxCnc, "G4 P1 F60\nG1 X20.\n"), [YES]);
}

#[test]
fn a_lone_l_calls_a_subprogram() {
    assert_eq!(shiftable(Dialect::Fanuc, "L100\nG1 X20.\n"), [LEFT]);
}

#[test]
fn a_spindle_stop_splits_a_move_only_where_the_control_is_known() {
    let of = |head: &str, dialect: Dialect| {
        let text = format!("{head}{HEAD}G1 X60. M5\n");
        interpret(&parse(text), &dialect.into()).expect("accepted").moves.last().map(|step| step.shiftable)
    };
    assert_eq!(of("%\nO01234\n", Dialect::Fanuc), Some(YES));
    assert_eq!(of("", Dialect::Fanuc), Some(Shiftable::No(Fixed::Unsplittable)));
    assert_eq!(of("", Dialect::LinuxCnc), Some(YES), "stated, since the program looks like Fanuc");
}

#[test]
fn an_arc_about_its_own_start_is_left_alone() {
    let path = read(Dialect::Fanuc, "G1 X30. Y0.\nG2 X30. Y0. I0. J0.\nG1 X10.\n");
    let feeds: Vec<_> = path.moves[2..].iter().map(|step| step.shiftable).collect();
    assert_eq!(feeds, [YES, LEFT, YES]);
}

#[test]
fn absolute_centres_are_not_guessed_in_a_fanuc_program() {
    let arcs = "G0 X10. Y20.\nG2 X20. Y10. I10. J10. F100\nG2 X10. Y0. I10. J10.\n";
    let program = |head: &str| parse(format!("{head}{HEAD}{arcs}"));
    assert!(interpret(&program(""), &Dialect::Fanuc.into()).is_ok());
    assert!(matches!(interpret(&program("%\nO1\n"), &Dialect::Fanuc.into()), Err(GcodeError::Refused { .. })));
}

#[test]
fn a_repeated_arc_is_left_alone() {
    let body = "G2 X20. Y30. I10. J0. L3\nG1 X50.\nX0. Y0.\nX5.\n";
    assert_eq!(shiftable(Dialect::Fanuc, body), [LEFT, UNKNOWN, UNKNOWN, YES]);
    // Its end is not known, so no arc leads there.
    assert_eq!(read(Dialect::Fanuc, body).moves[2].kind, MoveKind::Line);
}

#[test]
fn the_turns_of_an_arc_are_read_on_linuxcnc_and_left_alone_elsewhere() {
    let body = "G2 X20. Y30. I10. J0 P2\nG1 X50.\nG3 X40. Y20. R10. P1\n";
    assert_eq!(shiftable(Dialect::Fanuc, body), [LEFT, YES, YES]);
    assert_eq!(shiftable(Dialect::LinuxCnc, body), [YES; 3]);
    let path = read(Dialect::Fanuc, body);
    assert_eq!(path.moves[2].end.xyz_mm(), Some([20.0, 30.0, 4.0]), "its end does not depend on the turns");
    assert_eq!((path.warnings.len(), path.warnings[0].line), (1, 4), "{:?}", path.warnings);
    // A line takes no P.
    assert_eq!(shiftable(Dialect::Fanuc, "G1 X20. P2\nX30. Y5. Z4.\nX40.\n"), [LEFT, UNKNOWN, YES]);
}

#[test]
fn two_signs_are_understood_on_linuxcnc_alone() {
    let program = parse(format!("{HEAD}G1 X--1.\n"));
    assert!(interpret(&program, &Dialect::LinuxCnc.into()).is_ok());
    assert_eq!(shiftable(Dialect::Fanuc, "G1 X--1.\nX30. Y5. Z4.\nX40.\n"), [LEFT, UNKNOWN, YES]);
}

#[test]
fn a_corner_stated_alone_leaves_its_moves_alone() {
    let adjoining = Shiftable::No(Fixed::Adjoining);
    let body = "G1 X20.\nX30.\nRND=5\nY30.\nX40.\nY40.\n";
    let path =
        interpret(&parse(format!("G71 {}{body}", HEAD.replace("G21 ", ""))), &Dialect::Sinumerik.into()).expect("accepted");
    let feeds: Vec<_> = path.moves[2..].iter().map(|step| step.shiftable).collect();
    assert_eq!(feeds, [YES, adjoining, adjoining, adjoining, YES]);
}

#[test]
fn a_statement_of_sinumerik_names_its_remedy() {
    let refused = |text: &str| match interpret(&parse(format!("(PART)\n{HEAD}{text}")), &Dialect::Fanuc.into()) {
        Err(GcodeError::Refused { diagnostics }) => diagnostics[0].help.clone().unwrap_or_default(),
        other => panic!("not refused: {other:?}"),
    };
    for text in ["IF R1==1 GOTOF L1\nG1 X1.\n", "REPEAT LAB1 X=2\nG1 X1.\n"] {
        assert!(refused(text).contains("--dialect sinumerik"), "{text}: {}", refused(text));
    }
}

#[test]
fn a_tool_change_beside_a_move_leaves_the_position_unknown() {
    for (dialect, block) in [
        (Dialect::Fanuc, "G0 Z50. T3 M6"),
        (Dialect::Fanuc, "Z50. M06 T3"),
        (Dialect::Fanuc, "G0 Z50. M60"),
        (Dialect::Fanuc, "G0 X100. Y100. Z50. M50"),
        (Dialect::Sinumerik, "G0 Z50 T3 M6"),
    ] {
        let found = shiftable(dialect, &format!("{block}\nG1 X30. F3000.\nY30."));
        assert!(found[found.len() - 2..].iter().all(|of| *of != Shiftable::Yes), "{block}: {found:?}");
    }
    // LinuxCNC changes the tool before the motion of the block.
    let found = shiftable(Dialect::LinuxCnc, "G0 X0 Y0 Z50 T3 M6\nG1 X30 F3000");
    assert_eq!(found.last(), Some(&Shiftable::Yes), "{found:?}");
}

#[test]
fn codes_that_have_axis_words_of_their_own_leave_a_move_beside_them_unread() {
    for block in ["G0 Z50. G05.1 Q1", "G0 Z50. G22", "G05.1 Q1 G1 X20. F3000."] {
        let found = shiftable(Dialect::Fanuc, &format!("{block}\nG1 X30. F3000.\nY30."));
        assert!(found[found.len() - 2..].iter().all(|of| *of != Shiftable::Yes), "{block}: {found:?}");
    }
}

#[test]
fn blocks_that_others_repeat_by_their_numbers_are_left_alone() {
    for repeat in ["G77 N60 N70", "G25 N60.70.2", "#RPT[N60,N70,2]", "G14 N1=60 N2=70 J2", "RPT 2 N60 N70"] {
        let text = format!("N50 G1 X0 Y0 Z0 F600\nN55 X5.\nN60 X20.\nN70 Y15.\nN80 X0.\nN90 G0 X0 Y0 Z5.\nN120 {repeat}\nM30\n");
        let Ok(path) = interpret(&parse(text), &Dialect::Fanuc.into()) else { panic!("{repeat}") };
        let of: Vec<Shiftable> = path.moves.iter().filter(|step| step.is_feed()).map(|step| step.shiftable).collect();
        let left = Shiftable::No(Fixed::Unsplittable);
        assert_eq!(of[1..5], [Shiftable::Yes, left, left, Shiftable::Yes], "{repeat}: {of:?}");
    }
}

#[test]
fn the_value_of_a_variable_counts_units() {
    let text = "G21 G17 G90 G94\nG0 X0 Y0 Z5000\nG1 Z-1000 F600\n#101=20.\n#102=15\nG1 X#101\nY#102\nX[#102+1]\nM30\n";
    let options = Options { decimal_point: DecimalPoint::LeastIncrement, ..Options::from(Dialect::Fanuc) };
    let mut program = parse(text);
    gcode::evaluate(&mut program, &options, &|_| None).unwrap();
    let ends: Vec<[f64; 3]> = interpret(&program, &options).unwrap().moves.iter().map(|step| step.end.nominal_mm()).collect();
    assert_eq!(ends[2..], [[20.0, 0.0, -1.0], [20.0, 15.0, -1.0], [16.0, 15.0, -1.0]]);
}
