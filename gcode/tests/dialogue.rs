//! Heidenhain dialogue: the same part as in G-code gives the same moves; what is not interpreted is left alone.

use gcode::{Dialect, Feed, Fixed, GcodeError, Move, MoveKind, Shiftable, Toolpath, interpret, parse};

fn read(text: &str) -> Toolpath {
    let program = parse(text);
    match interpret(&program, &Dialect::Fanuc.into()) {
        Ok(path) => path,
        Err(error) => panic!("{error}\n{text}"),
    }
}

/// A program of these lines behind a known start at X0 Y0 Z0 and F600.
fn part(lines: &str) -> Toolpath {
    read(&format!("BEGIN PGM A MM\nTOOL CALL 1 Z S1000\nL X+0 Y+0 Z+0 R0 FMAX M3\n{lines}\nEND PGM A MM\n"))
}

/// Moves behind that start.
fn moves(lines: &str) -> Vec<Move> {
    part(lines).moves.split_off(1)
}

fn ends(moves: &[Move]) -> Vec<[f64; 3]> {
    moves.iter().map(|step| step.end.nominal_mm()).collect()
}

fn close(a: [f64; 3], b: [f64; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9)
}

fn fixed(moves: &[Move]) -> Vec<Option<Fixed>> {
    let why = |step: &Move| match step.shiftable {
        Shiftable::Yes => None,
        Shiftable::No(why) => Some(why),
    };
    moves.iter().map(why).collect()
}

const DIALOGUE: &str = "0 BEGIN PGM PLATE MM\r\n1 BLK FORM 0.1 Z X+0 Y+0 Z-20\r\n2 BLK FORM 0.2 X+100 Y+100 Z+0\r\n3 TOOL CALL 5 Z S3000\r\n\
4 L Z+50 R0 FMAX M3\r\n5 L X-30 Y-20 FMAX\r\n6 L Z-1 F900\r\n7 L X+30,0 F2400 ; first side\r\n8 CC X+30 Y+0\r\n9 C X+30 Y+20 DR+\r\n\
10 L IX-60\r\n11 CC X-30 Y+0\r\n12 CP PA-90 Z-3 DR+\r\n13 CR X-10 Y+0 R+20 DR-\r\n14 CR X-30 Y-20 R-20 DR-\r\n15 L IZ+8 FMAX M2\r\n\
16 END PGM PLATE MM\r\n";
const G_CODE: &str = "G21 G90 G17\nT5 M6\nG0 Z50\nX-30 Y-20\nG1 Z-1 F900\nX30 F2400\nG3 X30 Y20 J20\nG1 X-30\nG3 X-30 Y-20 Z-3 J-20\n\
G2 X-10 Y0 R20\nG2 X-30 Y-20 R-20\nG0 Z5\nM2\n";

#[test]
fn the_same_part_in_both_languages_gives_the_same_moves() {
    let (dialogue, g_code) = (read(DIALOGUE).moves, read(G_CODE).moves);
    assert_eq!(dialogue.len(), g_code.len());
    for (a, b) in dialogue.iter().zip(&g_code).skip(2) {
        let line = a.block + 1;
        assert_eq!(std::mem::discriminant(&a.kind), std::mem::discriminant(&b.kind), "line {line}");
        assert_eq!((a.shiftable, a.feed), (b.shiftable, b.feed), "line {line}");
        for fraction in [0.0, 0.3, 1.0] {
            assert!(close(a.point_mm(fraction), b.point_mm(fraction)), "line {line}");
        }
    }
    assert!(read(DIALOGUE).warnings.is_empty(), "{:?}", read(DIALOGUE).warnings);
}

#[test]
fn polar_moves_and_helices_lie_about_the_pole() {
    let found = moves("L X+10 F600\nCC X+0 Y+0\nLP PR+20 PA+90\nLP IPA+90\nLP IPR-5\nCP IPA-720 IZ-4 DR-\nCP PA+90 DR-");
    let expected =
        [[10.0, 0.0, 0.0], [0.0, 20.0, 0.0], [-20.0, 0.0, 0.0], [-15.0, 0.0, 0.0], [-15.0, 0.0, -4.0], [0.0, 15.0, -4.0]];
    assert!(ends(&found).iter().zip(expected).all(|(a, b)| close(*a, b)), "{:?}", ends(&found));
    let MoveKind::Arc(helix) = found[4].kind else { panic!("no helix") };
    assert!((helix.sweep + 4.0 * std::f64::consts::PI).abs() < 1e-12);
    assert!((found[4].length_mm().unwrap() - (60.0 * std::f64::consts::PI).hypot(4.0)).abs() < 1e-9);
    assert!(fixed(&found).iter().all(Option::is_none));
}

#[test]
fn a_tangential_circle_continues_the_direction() {
    let found = moves("L X+10 F600\nCT X+20 Y+10\nCT X+20 Y+20\nCC X+20 Y+0\nCTP PR+30 PA+90");
    let arc = |index: usize| match found[index].kind {
        MoveKind::Arc(arc) => arc,
        other => panic!("{other:?}"),
    };
    // From (10, 0) along X, a quarter about (10, 10); then the chord goes along the tangent: a line.
    assert!(
        (arc(1).sweep - std::f64::consts::FRAC_PI_2).abs() < 1e-9
            && close([arc(1).centre_mm[0], arc(1).centre_mm[1], 0.0], [10.0, 10.0, 0.0])
    );
    assert!(matches!(found[2].kind, MoveKind::Line));
    assert!(matches!(found[3].kind, MoveKind::Line) && close(found[3].end.nominal_mm(), [20.0, 30.0, 0.0]));
    assert!(fixed(&found).iter().all(Option::is_none));
}

#[test]
fn a_full_circle_needs_no_end() {
    let found = moves("L X+10 F600\nCC X+0 Y+0\nC DR-\nC X+10 Y+0 DR+");
    let sweeps: Vec<f64> =
        found.iter().filter_map(|step| if let MoveKind::Arc(arc) = step.kind { Some(arc.sweep) } else { None }).collect();
    assert_eq!(sweeps, [-std::f64::consts::TAU, std::f64::consts::TAU]);
}

#[test]
fn the_tool_axis_selects_the_plane_and_the_unit_is_that_of_the_program() {
    let path = read("BEGIN PGM A INCH\nTOOL CALL 1 Y\nL X+0 Y+0 Z+0 FMAX\nCC X+1 Z+0\nC X+1 Z+1 DR+ F10\nEND PGM A INCH\n");
    let step = path.moves[1];
    // In the plane ZX counter-clockwise is from Z to X.
    let MoveKind::Arc(arc) = step.kind else { panic!("{step:?}") };
    assert!((arc.sweep.to_degrees() - 90.0).abs() < 1e-9);
    assert!(close(step.end.nominal_mm(), [25.4, 0.0, 25.4]));
    let Some(Feed::Linear { mm_s }) = step.feed else { panic!("{step:?}") };
    assert!((mm_s - 25.4 / 60.0).abs() < 1e-12);
}

#[test]
fn feeds_are_modal_and_fmax_is_not() {
    let path = read(
        "BEGIN PGM A MM\nTOOL CALL 1 Z S1000 F500\nL X+0 Y+0 Z+0 FMAX\nL X+1\nL X+2 F MAX\nL X+3\nL X+4 F900\nL X+5 F AUTO\nL X+6 FU0.1\nEND PGM A MM\n",
    );
    let feeds: Vec<Option<f64>> = path
        .moves
        .iter()
        .map(|step| match step.feed {
            Some(Feed::Linear { mm_s }) => Some((mm_s * 60.0).round()),
            _ => None,
        })
        .collect();
    assert_eq!(feeds, [None, Some(500.0), None, Some(500.0), Some(900.0), Some(500.0), Some(100.0)]);
    assert_eq!(fixed(&path.moves)[6], Some(Fixed::Threading));
}

#[test]
fn constants_are_numbers_and_other_parameters_are_not() {
    let found =
        moves("FN 0: Q1 = +12.5\nQ2 = -3\nL X+Q1 Y-Q2 FQ3\nL X+Q1 Y+Q2 F600\nQ4 = +5\nQ4 = Q4 + 1\nL X+Q4\nL X+0 Y+0\nL X+1");
    assert!(close(found[1].end.nominal_mm(), [12.5, -3.0, 0.0]));
    let other = Some(Fixed::NotUnderstood);
    assert_eq!(fixed(&found), [other, None, other, Some(Fixed::UnknownStart), None]);
}

#[test]
fn a_datum_shift_moves_the_frame_and_places_are_stated_again() {
    let path = part(
        "CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+100\nCYCL DEF 7.2 IY+5\nL X+0 Y+0 Z+0 FMAX\nL X+10 F600\nCYCL DEF 7.0\nCYCL DEF 7.1 #4\nL X+0 Y+0 Z+0 FMAX\nL X+1",
    );
    assert!(close(path.moves[2].end.nominal_mm(), [110.0, 5.0, 0.0]));
    assert_eq!(path.programmed(&path.moves[2], [0.0; 6], [110.0; 6])[0], 10.0);
    assert_eq!(fixed(&path.moves[2..]), [None, Some(Fixed::Rapid), Some(Fixed::NotUnderstood)]);
}

/// What is put between two cuts, and why the second, third and fourth are fixed, or are not.
#[test]
fn what_is_not_interpreted_leaves_the_moves_after_it_alone() {
    let known = "L X+0 Y+0 Z+0 FMAX";
    let unknown = Some(Fixed::NotUnderstood);
    for (between, why) in [
        ("CYCL DEF 8.0 MIRROR IMAGE\nCYCL DEF 8.1 X", None),
        ("CYCL DEF 8.0 MIRROR IMAGE\nCYCL DEF 8.1 Z", unknown),
        ("CYCL DEF 8.0 MIRROR IMAGE\nCYCL DEF 8.1 Z\nCYCL DEF 8.0\nCYCL DEF 8.1", None),
        ("CYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+35", None),
        ("CYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 IROT+35", unknown),
        ("CYCL DEF 10.1 ROT+35\nCYCL DEF 10.1 ROT+0", None),
        ("CYCL DEF 11.1 SCL 0.99", unknown),
        ("CYCL DEF 11.1 SCL0.99", unknown),
        ("CYCL DEF 11.1 SCL0.99\nCYCL DEF 11.1 SCL1", None),
        ("CYCL DEF 12.0 PGM CALL\nCYCL DEF 12.1 OTHER", unknown),
        ("CYCL DEF 19.0 WORKING PLANE\nCYCL DEF 19.1 A+0 B+30", unknown),
        ("CYCL DEF 26.0 AXIS-SPEC. SCALING", unknown),
        ("CYCL DEF 221 CARTESIAN PATTERN", unknown),
        ("CYCL DEF 32.0 TOLERANCE\nCYCL DEF 32.1 T0.05", None),
        ("CYCL DEF 200 DRILLING ~\n  Q200=+2 ;SET-UP CLEARANCE ~\n  Q201=-20 ;DEPTH\nCYCL CALL", None),
        ("CYCL DEF 247 DATUM SETTING ~\n  Q339=+2 ;DATUM NUMBER", None),
        ("PLANE SPATIAL SPA+0 SPB+30 SPC+0 STAY", unknown),
        ("PLANE SPATIAL SPA+0 SPB+30 SPC+0 STAY\nPLANE RESET STAY", None),
        ("FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS", unknown),
        ("FUNCTION TCPM F TCP AXIS POS\nFUNCTION RESET TCPM", None),
        ("TRANS DATUM AXIS X+5", None),
        ("TRANS ROTATION ROT+5", unknown),
        ("L M128", unknown),
        ("L M128 F1000\nL M129", None),
        ("L M120 LA5", None),
        ("L M143", None),
        ("L M777", unknown),
        ("M8", None),
        ("M3 S500", None),
        ("M128", unknown),
        ("M128 F1000\nM129", None),
        ("M140 MB MAX", None),
        ("M777", unknown),
        ("STOP M128", unknown),
        ("STOP M6", None),
        ("CC X+5 Y+5 M136", unknown),
        ("TOOL CALL Z S900 M6", None),
        ("FN 0: Q1 = +5", None),
        ("TCH PROBE 0.0 REF. PLANE Q5 X-", unknown),
        ("FN 17: SYSWRITE ID 210 NR1 = +0", unknown),
        ("FN 18: SYSREAD Q5 = ID270 NR1", None),
        ("CALL PGM OTHER", unknown),
        ("CALL LBL 3", unknown),
        ("FN 9: IF +Q1 EQU +1 GOTO LBL 3", unknown),
        ("STOP M5", None),
        ("* - a heading\n; a comment\nLBL 3\nLBL 0", None),
        ("SURPRISE 5", unknown),
        ("TOOL CALL 2 Z S100", None),
        ("LN X+1 Y+2 Z+3 NX+0 NY+0 NZ+1", None),
        ("L U+5 F100", None),
    ] {
        let path = part(&format!("L X+5 F600\n{between}\n{known}\nL X+10"));
        assert_eq!(fixed(&path.moves[1..])[0], None, "{between}");
        assert_eq!(fixed(&path.moves).last(), Some(&why), "{between}: {:?}", path.warnings);
        assert!(why.is_none() || !path.warnings.is_empty(), "{between}");
        // Without the known place nothing moves from where the tool is not known to be.
        let frames = ["CYCL", "PLANE", "TRANS", "FUNCTION", "TOOL", "LN", "L M143", "L U", "M140", "STOP M6"];
        if frames.iter().any(|name| between.starts_with(name)) && !between.contains("32.") {
            let path = part(&format!("L X+5 F600\n{between}\nL X+10"));
            assert_ne!(fixed(&path.moves).last(), Some(&None), "{between}");
        }
    }
}

#[test]
fn blocks_that_are_repeated_are_left_alone_from_their_label_on() {
    let found = moves("L X+1 F600\nLBL 1\nL IX+1\nCALL LBL 1 REP 3\nL X+9\nL X+10");
    let unknown = Some(Fixed::NotUnderstood);
    assert_eq!(fixed(&found), [None, unknown, unknown, unknown]);
    let path = part("L X+1 F600\nL X+2 M30\nLBL 1\nL IX+1\nLBL 0");
    assert_eq!(path.moves.len(), 3);
}

#[test]
fn compensated_contours_and_computed_corners_are_left_to_the_control() {
    let comp = Some(Fixed::CutterCompensation);
    let beside = Some(Fixed::Adjoining);
    assert_eq!(fixed(&moves("L X+5 RL F600\nL Y+5\nL X+9 Y+9 R0\nL X+20")), [comp, comp, comp, None]);
    assert_eq!(fixed(&moves("L X+5 F600\nL X+10\nRND R2\nL Y+10\nL Y+20")), [None, beside, beside, None]);
    assert_eq!(fixed(&moves("L X+5 F600\nCHF 2 F300\nL Y+10\nL Y+20")), [beside, beside, None]);
    // Tangential elements take the direction of the move beside them, with and without radius compensation.
    for block in ["FCT DR- R10", "FLT X+0 Y+0", "DEP LT LEN10", "DEP LN LEN+10"] {
        assert_eq!(fixed(&moves(&format!("L X+5 R0 F600\nL X+10 Y+1\n{block}")))[..2], [None, beside], "{block}");
    }
    for block in ["APPR LT X+10 Y+10 LEN10 R0", "APPR CT X+10 Y+10 CCA90 R+5 R0"] {
        let found = fixed(&moves(&format!("L X+5 R0 F600\n{block}\nM8\nL Y+12\nL X+20")));
        assert_eq!(found, [None, beside, beside, None], "{block}");
    }
    let found = moves("L X-5 F600\nAPPR LT X+0 Y+0 LEN15 RL F300\nL X+10\nDEP LT LEN10 F500\nL X+50 Y+0 Z+5\nL X+60");
    assert_eq!(fixed(&found), [None, beside, comp, beside, Some(Fixed::UnknownStart), None]);
}

#[test]
fn moves_that_others_depend_on_keep_their_ends() {
    let beside = Some(Fixed::Adjoining);
    // The fixed tangential circle turns with the end of the one before it.
    let found = moves("L X+5 F600\nL X+10\nCT X+20 Y+10 M6");
    assert_eq!(fixed(&found), [None, beside, Some(Fixed::ToolChange)]);
    // A pole measured from the end of a move is used behind a rapid.
    let found = moves("L X+5 F600\nCC IX+10 IY+0\nC X+25 DR+\nL Z+5 FMAX\nLP PR+3 PA+0 FMAX");
    assert_eq!(fixed(&found)[..2], [beside, None]);
    let found = moves("L X+5 F600\nCC X+15 Y+0\nC X+25 DR+\nL Z+5 FMAX\nLP PR+3 PA+0 FMAX");
    assert_eq!(fixed(&found)[..2], [None, None]);
}

#[test]
fn machine_coordinates_and_skipped_blocks_are_not_shifted() {
    let found = moves("L X+5 F600\nL Z-1 M91\nL X+10\nL Z+3 F600\nL X+20");
    assert_eq!(fixed(&found)[1..], [Some(Fixed::MachineCoordinates), Some(Fixed::UnknownStart), Some(Fixed::UnknownStart), None]);
    let found = moves("L X+5 F600\n/L X+10\nL X+20 Y+0 Z+0\nL X+30");
    assert_eq!(fixed(&found)[1..], [Some(Fixed::OptionalBlock), Some(Fixed::UnknownStart), None]);
}

#[test]
fn a_circle_that_is_none_is_left_alone_and_reported() {
    for circle in ["C X+20 Y+0 DR+", "CC X+50 Y+0\nC X+20 Y+7 DR+", "CR X+20 Y+0 R+3 DR+", "CT X+20 Y+5 Z+5", "CP IPA+90 DR-"] {
        let path = part(&format!("L X+0 Y+0 Z+5 F600\n{circle}\nL X+30 Y+0 Z+0\nL X+40"));
        assert_eq!(fixed(&path.moves[2..3]), [Some(Fixed::NotUnderstood)], "{circle}");
    }
}

#[test]
fn a_program_without_a_feed_is_refused_with_its_line() {
    let error = interpret(&parse("0 BEGIN PGM A MM\n1 L X+0 Y+0 Z+0 FMAX\n2 L X+1\n"), &Dialect::Fanuc.into());
    let Err(GcodeError::Refused { diagnostics }) = error else { panic!("{error:?}") };
    assert_eq!((diagnostics[0].line, diagnostics[0].column), (3, 3));
    assert!(diagnostics[0].message.contains("no feed"));
}

#[test]
fn blocks_are_numbered_one_by_one() {
    let text = "0 BEGIN PGM A MM\n; PLATE\n1 L X+1 ~\n  Y+2\nL X+3\n\n2 END PGM A MM\n";
    let again = gcode::renumber(&parse(text)).unwrap();
    assert_eq!(String::from_utf8(again).unwrap(), "0 BEGIN PGM A MM\n1 ; PLATE\n2 L X+1 ~\n  Y+2\n3 L X+3\n\n4 END PGM A MM\n");
    for same in [DIALOGUE, "BEGIN PGM A MM\nL X+1\n", "5 BEGIN PGM A MM\n"] {
        assert_eq!(gcode::renumber(&parse(same)).unwrap(), same.as_bytes());
    }
}

#[test]
fn feeds_of_programs_in_inches_are_tenths_of_an_inch() {
    let path = read("BEGIN PGM A INCH\nTOOL CALL 1 Z S1000\nL X+0 Y+0 Z+0 R0 FMAX M3\nL X+1 F600\nEND PGM A INCH\n");
    let step = path.moves.last().unwrap();
    assert_eq!(step.feed, Some(Feed::Linear { mm_s: 25.4 }));
    assert!((path.modal(step).feed_unit_mm - 2.54).abs() < 1e-12);
}

#[test]
fn ways_of_rotary_axes_do_not_concern_programs_without_them() {
    for way in ["M126", "L M126"] {
        let found = part(&format!("{way}\nL X+10 F600\nL M116\nL Y+10"));
        assert!(fixed(&found.moves[1..]).iter().all(Option::is_none), "{way}: {:?}", found.warnings);
    }
    let with_axis = moves("M126\nL X+10 F600\nL A+10");
    assert!(fixed(&with_axis).iter().all(Option::is_some));
}

#[test]
fn free_contours_keep_the_axis_of_the_tool() {
    for (free, known) in
        [("FC DR- R5", true), ("FL AN+45", true), ("FL Z-3", false), ("FC IZ-1", false), ("LN X+1 Y+1 Z+1 NX0", false)]
    {
        let found = moves(&format!("L X+10 F600\n{free}\nL X+0 Y+0\nL Y+10"));
        assert_eq!(found.last().unwrap().shiftable == Shiftable::Yes, known, "{free}");
    }
}

#[test]
fn a_tool_change_beside_a_move_leaves_the_place_unknown() {
    let found = moves("L X+5 F600\nL Z+50 R0 FMAX M6\nL X+10 F600\nL X+10 Y+0 Z+0 FMAX\nL X+20");
    assert_eq!(fixed(&found)[2..], [Some(Fixed::UnknownStart), Some(Fixed::Rapid), None]);
}

#[test]
fn a_contour_that_a_cycle_runs_again_is_not_split() {
    let contour = "LBL 1\nL X+30 F600\nL Y+30\nLBL 0\nL X+0\n";
    let held = moves(&format!("CYCL DEF 14.0 KONTUR\nCYCL DEF 14.1 KONTURLABEL 1\n{contour}"));
    assert_eq!(fixed(&held), [Some(Fixed::Unsplittable), Some(Fixed::Unsplittable), None]);
    assert_eq!(fixed(&moves(contour)), [None, None, None]);
}
