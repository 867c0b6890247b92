//! Blocks whose path is not interpreted, and codes that other controls than Fanuc use in another way: they are left alone, with what depends on them.

use gcode::{Dialect, Fixed, Shiftable, Toolpath, WorkOffset, interpret, parse};

const HEAD: &str = "G21 G90 G17 G54\nG0 X0 Y0 Z5.\nG1 Z-1. F600\nX10.\n";
const TAIL: &str = "G1 X3. F600\nG0 X0 Y0 Z5.\nG1 Z-1.\nX5.\nM30\n";

const YES: Shiftable = Shiftable::Yes;
const LEFT: Shiftable = Shiftable::No(Fixed::NotUnderstood);
const UNKNOWN: Shiftable = Shiftable::No(Fixed::UnknownStart);
const ADJOINING: Shiftable = Shiftable::No(Fixed::Adjoining);

fn read(dialect: Dialect, body: &str) -> Toolpath {
    let text = format!("{HEAD}{body}\n{TAIL}");
    interpret(&parse(text), &dialect.into()).unwrap_or_else(|error| panic!("{error}\n{body}"))
}

fn feeds(dialect: Dialect, body: &str) -> Vec<Shiftable> {
    read(dialect, body).moves.iter().filter(|step| step.is_feed()).map(|step| step.shiftable).collect()
}

/// Whether the first warning that names `code` is of the line after the head.
fn warns(path: &Toolpath, code: &str) -> bool {
    path.warnings.iter().any(|warning| warning.line == 5 && warning.message.contains(code))
}

#[test]
fn a_path_that_is_not_interpreted_is_left_alone_with_the_move_before_it() {
    for block in [
        "G60 X5. Y5.",
        "G34 X0 Y0 I10. J0 K6",
        "G37 X5. R3.",
        "G47 P0 X1. Y1. I0. J0.08 R0.05 Z-0.005 F15. E10.",
        "G2.2 X5. Y5. I1. J1. R2.",
        "G6.2 P4 X5. Y5. K0 R1.",
    ] {
        let code = block.split(' ').next().unwrap();
        assert_eq!(feeds(Dialect::Fanuc, block), [YES, ADJOINING, LEFT, UNKNOWN, YES, YES], "{block}");
        // A block without a motion code may go on with that path.
        assert_eq!(
            feeds(Dialect::Fanuc, &format!("{block}\nX1. Y1. Z1.")),
            [YES, ADJOINING, LEFT, LEFT, UNKNOWN, YES, YES],
            "{block}"
        );
        let path = read(Dialect::Fanuc, block);
        assert!(warns(&path, code) || warns(&path, "a path that is not interpreted"), "{block}: {:?}", path.warnings);
    }
}

#[test]
fn a_code_that_is_not_known_leaves_all_alone_after_it() {
    for (dialect, block) in [
        (Dialect::Fanuc, "G123 X1."),
        (Dialect::Fanuc, "G7 X0"),
        (Dialect::Fanuc, "G45 G1 X20. D1"),
        (Dialect::LinuxCnc, "G68 X0 Y0 R30"),
        (Dialect::LinuxCnc, "G51 X2 Y2"),
    ] {
        let (of, path) = (feeds(dialect, block), read(dialect, block));
        assert_eq!(of[..2], [YES, ADJOINING], "{block}");
        assert!(of[2..].iter().all(|shiftable| *shiftable == LEFT), "{block}: {of:?}");
        assert!(warns(&path, block.split(' ').next().unwrap()), "{block}: {:?}", path.warnings);
    }
}

#[test]
fn splines_of_linuxcnc_end_where_they_say() {
    let path = |block: &str| read(Dialect::LinuxCnc, block).moves.iter().map(|step| step.end.xyz_mm()).nth(3).unwrap();
    for block in ["G5.1 X12. Y3. I1. J0", "G5 X12. Y3. I1. J0 P-1. Q0"] {
        assert_eq!(feeds(Dialect::LinuxCnc, block), [YES, ADJOINING, LEFT, YES, YES, YES], "{block}");
        assert_eq!(path(block), Some([12.0, 3.0, -1.0]), "{block}");
    }
    for block in ["G5.2 X12. Y3. P1 L3\nX0 Y1. P1\nG5.3", "G91 G5.1 X1. Y1. I1. J0\nG90", "G5.1 X1. Y1. Z2. I1. J0"] {
        let of = feeds(Dialect::LinuxCnc, block);
        assert_eq!(of[of.len() - 3..], [UNKNOWN, YES, YES], "{block}: {of:?}");
    }
}

#[test]
fn an_arc_from_an_unknown_start_is_left_alone_and_its_end_is_known() {
    for dialect in [Dialect::Fanuc, Dialect::LinuxCnc] {
        for arc in ["G2 X20. Y0 R8.", "G3 X20. Y0 I5. J0"] {
            let body = format!("G28 X0 Y0\n{arc}\nG1 X15.");
            assert_eq!(feeds(dialect, &body), [YES, YES, UNKNOWN, YES, YES, YES, YES], "{arc}");
            assert!(read(dialect, &body).warnings.iter().any(|warning| warning.line == 6), "{arc}");
        }
    }
}

#[test]
fn codes_that_turn_or_mirror_on_another_control_open_a_section() {
    // Okuma G11, Fagor G11 to G13, until G10.
    for (on, off) in [("G11 P45.", "G10"), ("G11 X5. Y5. P30.", "G10"), ("G11", "G10"), ("G12", "G10"), ("G13", "G10")] {
        let of = feeds(Dialect::Fanuc, &format!("{on}\nG1 X7. Y7.\nG10 L2 P3 X1.\nX8.\n{off}"));
        let inside: Vec<_> = of[2..of.len() - 3].to_vec();
        assert!(inside.iter().all(|shiftable| *shiftable == LEFT) && inside.len() > 1, "{on}: {of:?}");
        assert_eq!(of[of.len() - 3..], [UNKNOWN, YES, YES], "{on}: {of:?}");
    }
    // Okuma's mirror image; Fanuc's corner override is no such thing.
    let of = feeds(Dialect::Fanuc, "G62 X1\nG1 X7. Y7. F600\nG62 X0");
    assert!(of[2..].iter().all(|shiftable| *shiftable != YES), "{of:?}");
    // Fagor G73 and G93, NUM G52, Okuma G71 in a program in inches.
    for on in ["G73 Q45.", "G93 I5. J5.", "G0 G52 X5.", "G70\nG0 X0 Y0 Z0.2\nG71 Z50."] {
        let of = feeds(Dialect::Fanuc, &format!("{on}\nG94 G1 X7. Y7. F600"));
        assert!(of[2..].iter().all(|shiftable| *shiftable != YES), "{on}: {of:?}");
    }
}

#[test]
fn the_same_codes_in_their_usual_form_open_nothing() {
    for block in ["G10 L3 P1\nG11", "G15 H1", "G71 Z5.", "G0 G52 Z0", "G12 I5. D1 F300"] {
        let of = feeds(Dialect::Fanuc, block);
        assert_eq!(of[of.len() - 2..], [YES, YES], "{block}: {of:?}");
    }
    for block in ["G11", "G52 X5. Y0", "G93 G1 X20. F5.\nG94"] {
        let body = format!("G10 L3\n{block}");
        let of = feeds(Dialect::Fanuc, &body);
        assert_eq!(of[of.len() - 2..], [YES, YES], "{block}: {of:?}");
    }
}

#[test]
fn the_work_offsets_of_haas_are_those_of_g54_1() {
    let path = read(Dialect::Fanuc, "G154 P12\nG0 X0 Y0 Z5.\nG1 X5. F600");
    let last = path.moves.last().unwrap();
    assert_eq!((path.modal(last).work_offset, last.shiftable), (WorkOffset::Extended(12), YES));
    assert!(path.warnings.is_empty(), "{:?}", path.warnings);
}

#[test]
fn questions_to_grbl_and_program_numbers_change_nothing() {
    for block in ["$$", "$G ; state", "$I", "$#", "?", "~", ":0815 (PART)"] {
        assert_eq!(feeds(Dialect::Fanuc, block), [YES; 5], "{block}");
        assert!(read(Dialect::Fanuc, block).warnings.is_empty(), "{block}");
    }
}

#[test]
fn a_statement_without_coordinates_is_no_feed_move() {
    for block in ["VC1=VC1+1", "CALL O1000 Q2", "NOEX V1=5"] {
        let of = feeds(Dialect::Fanuc, block);
        assert_eq!(of[..2], [YES, YES], "{block}");
        assert!(of[2..].iter().all(|shiftable| *shiftable == LEFT), "{block}: {of:?}");
    }
}

#[test]
fn data_that_may_change_anything_leave_what_follows_alone() {
    // Parameters of the control, among them work offsets (N1221).
    let of = feeds(Dialect::Fanuc, "G10 L52\nN1221 P2 R5.\nG11\nG1 X7. Y7. F600\nX8.");
    assert!(of[2..].iter().all(|shiftable| *shiftable != YES), "{of:?}");
    // Lengths of tools: until the position is stated.
    for data in ["G10 L10 P1 R5.", "G10 P1 R5.", "G10 L12 P1 R3."] {
        let of = feeds(Dialect::Fanuc, &format!("{data}\nG1 X7. Y7. F600\nX8. Y8. Z-1.\nX9."));
        assert!(of[2] != YES && of[3] != YES && of[4] == YES, "{data}: {of:?}");
    }
    // Subprograms and jumps of Fagor, chamfers and corners of Heidenhain's DIN/ISO.
    for block in ["G25 N100", "G20 N1.1", "G22 N1", "G25 R5."] {
        let of = feeds(Dialect::Fanuc, &format!("{block}\nG1 X7. Y7. F600\nX8."));
        assert!(of[2..].iter().all(|shiftable| *shiftable != YES), "{block}: {of:?}");
    }
}

#[test]
fn words_of_another_geometry_leave_the_position_unknown() {
    for block in ["G1 R10. Q45.", "R5.", "Q90.", "I5.", "K5."] {
        for dialect in [Dialect::Fanuc, Dialect::LinuxCnc] {
            let body = format!("G1 X1. F600\n{block}\nX7.\nX8. Y8. Z-1.\nX9.");
            let of = feeds(dialect, &body);
            let [.., cut, stated, next, _, _, _] = of[..] else { panic!("{block}: {of:?}") };
            assert!(cut != YES && stated != YES && next == YES, "{block}: {of:?}");
            assert!(read(dialect, &body).warnings.iter().any(|warning| warning.message.contains("another control's geometry")));
        }
    }
    // Arcs, cycles and codes have these words.
    for body in ["G2 I-5.\nG1 X7.\nX8.", "G81 X5. Y5. Z-2. R1. F100\nR2.\nG80\nX0 Y0 Z0\nG1 X7. F600\nX8.", "G4 P1\nG1 X7.\nX8."]
    {
        let of = feeds(Dialect::Fanuc, body);
        assert_eq!(of[of.len() - 4], YES, "{body}: {of:?}");
    }
}

#[test]
fn words_of_axes_that_the_machine_lacks_are_no_positions() {
    let fixed = |block: &str, rotary_axes: [bool; 3]| {
        let options = gcode::Options { rotary_axes, ..Dialect::Fanuc.into() };
        let text = format!("{HEAD}{block}\nX7.\nX8. Y8. Z-1.\nX9.\n{TAIL}");
        let path = interpret(&parse(text), &options).unwrap();
        path.moves.iter().filter(|step| step.is_feed()).map(|step| step.shiftable).collect::<Vec<_>>()
    };
    // The angle of a line, a chamfer.
    for block in ["X30. A45.", "G1 Y20. C2."] {
        let of = fixed(block, [false; 3]);
        assert!(of[2..5].iter().all(|shiftable| *shiftable != YES) && of[5] == YES, "{block}: {of:?}");
        let of = fixed(block, [true; 3]);
        assert_eq!(of[3..6], [YES; 3], "{block}");
    }
}

#[test]
fn further_offsets_beside_g54_and_stored_moves_are_not_passed_over() {
    // G54 J2, L3: an additional offset on controls that know it; on the others the word is an error.
    for block in ["G54 J2", "G55 L3", "G54 K1", "G59 Q4"] {
        let path = read(Dialect::Fanuc, &format!("{block}\nG1 Y2."));
        let after = path.moves.iter().filter(|step| step.is_feed()).nth(2).unwrap();
        assert_eq!(after.shiftable, UNKNOWN, "{block}");
        assert_eq!(path.modal(after).work_offset, WorkOffset::Unpredictable, "{block}");
    }
    // Words of other codes are none of the offset.
    for block in ["G54 G2 X12. Y0 I1. J0", "G54 G5.1 Q1", "G54 G83 X1. Y1. Z-3. R2. Q1. K1\nG80"] {
        let path = read(Dialect::Fanuc, block);
        assert!(path.moves.iter().all(|step| path.modal(step).work_offset == WorkOffset::Standard(1)), "{block}");
    }
    // High-speed cycle machining runs stored moves; look-ahead does not.
    for block in ["G05 P10001 L2", "G05 P10999"] {
        let of = feeds(Dialect::Fanuc, &format!("{block}\nG1 X0\nY0"));
        assert!(of[2..4].iter().all(|shiftable| *shiftable != YES), "{block}: {of:?}");
        assert!(warns(&read(Dialect::Fanuc, block), "G05"), "{block}");
    }
    for block in ["G05 P10000", "G05 P0", "G05 P2", "G05 P20000", "G05.3 P35", "G05.2 Q1 P5.", "G54.2 P0\nG0 X10. Y0 Z-1."] {
        let of = feeds(Dialect::Fanuc, &format!("{block}\nG1 X0\nY0"));
        assert_eq!(of[2..4], [YES, YES], "{block}: {of:?}");
    }
}

#[test]
fn g92_takes_the_place_of_g52() {
    // On Fanuc controls the second G52 changes nothing; where G52 is kept it moves program zero. Neither is taken for granted.
    let path = read(Dialect::Fanuc, "G52 X5. Y5.\nG92 X0 Y0\nG1 Y1.\nG52 X0 Y0\nG1 X20.\nY20.\nX0");
    let of: Vec<_> = path.moves.iter().filter(|step| step.is_feed()).skip(2).map(|step| step.shiftable).collect();
    assert_eq!(of[..4], [YES, UNKNOWN, UNKNOWN, YES], "{of:?}");
    // Without a G52 before it, nothing is doubted where the dialect is stated. LinuxCNC and Grbl have one store for both: a guess is left alone.
    let text = format!("{HEAD}G92 X0 Y0\nG52 X1.\nG1 X20.\nY20.\n{TAIL}");
    for (is_dialect_stated, expected) in [(true, [YES, YES]), (false, [UNKNOWN, YES])] {
        let path = interpret(&parse(text.as_str()), &gcode::Options { is_dialect_stated, ..Dialect::Fanuc.into() }).unwrap();
        let of: Vec<_> = path.moves.iter().filter(|step| step.is_feed()).skip(2).map(|step| step.shiftable).collect();
        assert_eq!(of[..2], expected, "{of:?}");
    }
}

#[test]
fn a_guessed_control_may_stay_at_either_level_behind_a_cycle() {
    // From Z-1 to R3: Fanuc's controls return to Z-1, LinuxCNC stays at 3.
    let text = format!("{HEAD}G81 X20. Y5. Z-5. R3. F100\nG80\nG1 X40. F500\nY40.\n{TAIL}");
    for (is_dialect_stated, expected) in [(true, YES), (false, UNKNOWN)] {
        let path = interpret(&parse(text.as_str()), &gcode::Options { is_dialect_stated, ..Dialect::Fanuc.into() }).unwrap();
        let of: Vec<_> = path.moves.iter().filter(|step| step.is_feed()).skip(2).map(|step| step.shiftable).collect();
        assert_eq!(of[0], expected, "{of:?}");
    }
}

#[test]
fn dimensions_of_a_drawing_leave_their_line_and_its_neighbours_alone() {
    for block in ["X20. ,A45.", "X20. Y5. ,I3.", "X20. ,A45. M8", "X20. ,A45. ,R2."] {
        let of = feeds(Dialect::Fanuc, &format!("{block}\nG1 Y20.\nX3."));
        assert_eq!(of[..2], [YES, YES], "{block}: {of:?}");
        assert!(of[2..5].iter().all(|shiftable| *shiftable != YES), "{block}: {of:?}");
        assert!(warns(&read(Dialect::Fanuc, block), "dimension of the drawing"), "{block}");
    }
    // An angle of an axis that the machine lacks, whatever else stands in its block.
    let options = gcode::Options { rotary_axes: [false; 3], ..Dialect::Fanuc.into() };
    let left = |block: &str| {
        let text = format!("{HEAD}{block}\nG1 Y20.\nG0 X0 Y0 Z5.\nM30\n");
        let path = interpret(&parse(text), &options).unwrap();
        path.moves.iter().filter(|step| step.is_feed()).skip(2).all(|step| step.shiftable != YES)
    };
    assert!(left("X20. A45.") && left("X20. A45. M8"));
    // Words of a code are none.
    assert!(!left("G5.1 Q1 B0 C0"));
}

#[test]
fn feeds_a_turn_of_an_unknown_spindle_speed_leave_their_moves_alone() {
    let run_time = Shiftable::No(Fixed::RunTime);
    for on in ["G95 F0.1", "G96 S200 G95 F0.1"] {
        let of = feeds(Dialect::Fanuc, &format!("{on}\nG1 X20.\nG2 X24. Y0 I2. J0\nG97 S1000 G1 X20.\nG94 F600"));
        assert_eq!(of[2..5], [run_time, run_time, YES], "{on}: {of:?}");
    }
}

#[test]
fn two_codes_of_one_group_alone_in_a_block_leave_moves_alone_or_are_refused() {
    let of = feeds(Dialect::Fanuc, "G90 G91\nX10.\nY10.\nG90\nG1 X20. Y20.\nY30.");
    assert!(of[2..4].iter().all(|shiftable| *shiftable != YES) && of[7] == YES, "{of:?}");
    assert!(warns(&read(Dialect::Fanuc, "G90 G91"), "G91"));
    for (dialect, block) in [(Dialect::Fanuc, "G20 G21"), (Dialect::LinuxCnc, "G90 G91"), (Dialect::LinuxCnc, "G21 G20")] {
        assert!(interpret(&parse(format!("{HEAD}{block}\n{TAIL}")), &dialect.into()).is_err(), "{block}");
    }
}
