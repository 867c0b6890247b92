//! SINUMERIK programs: what their blocks mean.

use gcode::{
    Dialect, Feed, Fixed, Move, MoveKind, Options, PathMode, Shiftable, Toolpath, Units, WorkOffset, evaluate, interpret, parse,
};

fn read(text: &str) -> Toolpath {
    let mut program = Dialect::Sinumerik.read(parse(text));
    let options = Options::from(Dialect::Sinumerik);
    evaluate(&mut program, &options, &|_| None).unwrap_or_else(|error| panic!("{text}\n{error}"));
    interpret(&program, &options).unwrap_or_else(|error| panic!("{text}\n{error}"))
}

/// Ends of all moves with X, Y, Z known, and whether each may be shifted.
fn ends(text: &str) -> Vec<([f64; 3], Shiftable)> {
    let end = |step: &Move| (step.end.nominal_mm().map(|value| (value * 1e6).round() / 1e6), step.shiftable);
    read(text).moves.iter().map(end).collect()
}

fn last(text: &str) -> Move {
    *read(text).moves.last().expect("a move")
}

/// Start of a program at a known place.
const START: &str = "G17 G54 G90 G71 G94\nG0 X0 Y0 Z0\nF600\n";

fn after(text: &str) -> Move {
    last(&format!("{START}{text}"))
}

#[test]
fn axis_words_have_several_forms() {
    for (text, end) in [
        ("G1 X10 Y-2.5", [10.0, -2.5, 0.0]),
        ("G1 X=10 Y=-2.5", [10.0, -2.5, 0.0]),
        ("g1x10y-2.5z+1", [10.0, -2.5, 1.0]),
        ("G1 X=2*5+1 Y=SQRT(16)", [11.0, 4.0, 0.0]),
        ("R1=3\nG1 X=R1 Y=R1*2 Z=-R1", [3.0, 6.0, -3.0]),
        ("G1 X10\nX=IC(5)", [15.0, 0.0, 0.0]),
        ("G91\nG1 X10\nX=AC(4) Y2", [4.0, 2.0, 0.0]),
        ("G1 X=1.5EX1", [15.0, 0.0, 0.0]),
        (":20 G1 X7 ; Hauptsatz", [7.0, 0.0, 0.0]),
        ("N10 START: G1 X7 MSG(\"a;b\")", [7.0, 0.0, 0.0]),
        ("/3 N10 MSG(\"x\")\nG1 X7", [7.0, 0.0, 0.0]),
    ] {
        let step = after(text);
        assert_eq!((step.end.nominal_mm(), step.kind, step.shiftable), (end, MoveKind::Line, Shiftable::Yes), "{text}");
    }
}

#[test]
fn arcs_have_centres_radii_and_turns() {
    for (text, radius, sweep) in [
        ("G2 X10 Y0 I5 J0", 5.0, -180.0),
        ("G3 X10 Y0 CR=5", 5.0, 180.0),
        ("G3 X10 Y0 CR=-10", 10.0, 300.0),
        ("G3 X10 Y0 CR=+10", 10.0, 60.0),
        ("G91 G2 X10 I5", 5.0, -180.0),
        ("G1 X5\nG2 X5 Y10 I=AC(5) J=AC(5)", 5.0, -180.0),
        ("G3 X0 Y0 Z-3 I5 J0 TURN=2", 5.0, 1080.0),
        ("G2 X10 Y0 I5 J0 K0", 5.0, -180.0),
    ] {
        let step = after(text);
        let MoveKind::Arc(arc) = step.kind else { panic!("{text}: {:?}", step.kind) };
        assert!((arc.radius_end_mm - radius).abs() < 1e-9, "{text}: {arc:?}");
        assert!((arc.sweep.to_degrees() - sweep).abs() < 1e-9, "{text}: {arc:?}");
        assert_eq!(step.shiftable, Shiftable::Yes, "{text}");
    }
}

#[test]
fn lengths_and_feeds_have_units_of_their_own() {
    let feed = |step: Move| match step.feed {
        Some(Feed::Linear { mm_s }) => mm_s * 60.0,
        other => panic!("{other:?}"),
    };
    let metric = after("G70 G1 X1 F254");
    assert_eq!((metric.end.nominal_mm()[0], feed(metric)), (25.4, 254.0));
    let inch = after("G700 G1 X1 F10");
    assert_eq!((inch.end.nominal_mm()[0], feed(inch)), (25.4, 254.0));
    let program = read(&format!("{START}G70 G1 X1"));
    assert_eq!(program.modals.last().map(|modal| (modal.units, modal.feed_unit_mm)), Some((Units::Inch, 1.0)));
    // F of a dwell is its time, and no feed.
    let moves = read(&format!("{START}G4 F1.5\nG1 X1")).moves;
    assert_eq!(moves[1].kind, MoveKind::Dwell { seconds: Some(1.5) });
    assert_eq!(feed(moves[2]), 600.0);
    let turns = read(&format!("{START}S600 M3\nG4 S30\nG1 X1")).moves;
    assert_eq!(turns[1].kind, MoveKind::Dwell { seconds: Some(3.0) });
}

#[test]
fn path_modes_and_offsets_are_those_of_the_control() {
    let mode = |text: &str| {
        let path = read(&format!("{START}{text}"));
        path.modal(path.moves.last().expect("a move")).path
    };
    assert_eq!(mode("G60\nG1 X1"), PathMode::ExactStop);
    assert_eq!(mode("G9 G1 X1"), PathMode::ExactStop);
    assert_eq!(mode("G9 G1 X1\nX2"), PathMode::Default);
    for code in ["G64", "G641 ADIS=0.5", "G642", "G645"] {
        assert_eq!(mode(&format!("{code}\nG1 X1")), PathMode::Continuous { tolerance_mm: None, merge_mm: None }, "{code}");
    }
    let offset = |text: &str| read(&format!("{START}{text}\nG0 X1 Y1 Z1\nG1 X2")).modals.last().expect("a state").work_offset;
    assert_eq!(offset("G57"), WorkOffset::Standard(4));
    assert_eq!(offset("G507"), WorkOffset::Extended(507));
    assert_eq!(after("G505\nG1 X2").shiftable, Shiftable::No(Fixed::UnknownStart));
}

#[test]
fn a_programmable_offset_leaves_no_jump() {
    let moves = ends(&format!("{START}TRANS X100 Y=R2+1\nG1 X1"));
    assert_eq!(moves.last().map(|step| step.1), Some(Shiftable::No(Fixed::NotUnderstood)), "R2 is not known");
    let step = after("G1 X110\nTRANS X100\nG1 X20");
    assert_eq!((step.start.nominal_mm()[0], step.end.nominal_mm()[0], step.shiftable), (110.0, 120.0, Shiftable::Yes));
    let step = after("TRANS X100 Y5\nATRANS X10\nG1 X1 Y1");
    assert_eq!(step.end.nominal_mm(), [111.0, 6.0, 0.0]);
    // TRANS replaces, and alone deletes.
    assert_eq!(after("TRANS X100\nTRANS Y5\nG1 X1 Y1").end.nominal_mm(), [1.0, 6.0, 0.0]);
    assert_eq!(after("TRANS X100\nTRANS\nG1 X1 Y1").end.nominal_mm(), [1.0, 1.0, 0.0]);
    // Whether an incremental word travels the offset depends on setting data.
    assert_eq!(after("TRANS X100\nG91 G1 X1\nY1").shiftable, Shiftable::No(Fixed::UnknownStart));
    assert_eq!(after("TRANS X100\nG1 X1\nG91 X1").shiftable, Shiftable::Yes);
}

#[test]
fn sections_end_with_their_own_codes() {
    for (opens, closes) in [
        ("ROT X30", "ROT"),
        ("AROT X30", "TRANS"),
        ("SCALE X2", "TRANS X5"),
        ("AMIRROR Z0", "MIRROR"),
        ("CYCLE800(1,\"TISCH\",0,57,0,0,0,0,30,0,0,0,0,1)", "CYCLE800()"),
        ("TRAORI", "TRAFOOF"),
        ("TRACYL(40)", "TRAFOOF"),
        ("DIAMON", "DIAMOF"),
        ("MCALL CYCLE81(10,0,2,-5)", "MCALL"),
        ("TOROT", "TOROTOF"),
        ("G58 X10", "TRANS"),
        ("G291", "G290"),
    ] {
        let inside = format!("{START}{opens}\nG0 X0 Y0 Z0\nG1 X5\n");
        assert_eq!(last(&inside).shiftable, Shiftable::No(Fixed::NotUnderstood), "{opens}");
        let unknown = format!("{inside}{closes}\nG1 X7");
        assert!(!matches!(last(&unknown).shiftable, Shiftable::Yes), "{closes}");
        let known = format!("{inside}{closes}\nG0 X0 Y0 Z0\nG1 X7");
        assert_eq!(last(&known).shiftable, Shiftable::Yes, "{opens} {closes}");
    }
}

#[test]
fn what_is_not_known_lasts() {
    for text in [
        "G810",
        "M428",
        "SUPPRESSIT",
        "MYMACRO(1,2)",
        "$P_UIFR[1,X,TR]=5",
        "$TC_DP3[1,1]=100",
        "WHEN $AA_IM[X]>5 DO M8",
        "DEFINE G1 AS G0",
        "CALL NAMEVAR",
        "CYCLE977(1,2,3)",
        "G=R1",
        "N10 TRANS: TRANS X=R9",
        "FGROUP(X,A)",
        "TABLE=90",
        "G0 TABLE=90",
        "TOFFL=2",
        "TOFF[Z]=2",
        "FXS[X]=1",
        "_POS[1]=5 G0 X1",
    ] {
        let step = after(&format!("{text}\nG0 X0 Y0 Z0\nG1 X7"));
        assert_eq!(step.shiftable, Shiftable::No(Fixed::NotUnderstood), "{text}");
    }
    for text in [
        "MSG(\"x\")",
        "STOPRE",
        "SOFT",
        "FFWON",
        "G601",
        "SPOS=90",
        "CYCLE832(0.01,_FINISH,1)",
        "$AC_TIMER[1]=0",
        "S2=500",
        "M1=3",
        "COMPCAD",
        "R5=$AA_IM[X]",
        "_CHBIT[3]=1",
        "DEF REAL NULL\nNULL=5",
        "G25 S100",
        "G111 X5 Y5",
        "FGROUP()",
        "LIMS=3000",
        "WORKPIECE(,\"\",,\"BOX\",112,0,-20)",
    ] {
        let step = after(&format!("{text}\nG1 X7"));
        assert_eq!((step.shiftable, step.end.nominal_mm()[0]), (Shiftable::Yes, 7.0), "{text}");
    }
}

#[test]
fn moves_that_the_control_computes_are_left_alone() {
    use Fixed::*;
    let fixed = |text: &str| {
        let all = ends(&format!("{START}{text}"));
        all.into_iter().skip(1).map(|(_, shiftable)| shiftable).collect::<Vec<_>>()
    };
    let no = Shiftable::No;
    assert_eq!(fixed("G1 X1 RND=0.5\nY1\nX0"), [no(Adjoining), no(Adjoining), Shiftable::Yes]);
    assert_eq!(fixed("G1 X1 RNDM=2\nY1\nRNDM=0 X0\nY0"), [no(Adjoining), no(Adjoining), no(Adjoining), Shiftable::Yes]);
    // The corner before the first move without rounding is still rounded.
    assert_eq!(fixed("G1 X1 RNDM=2\nY1\nRNDM=0\nX0\nY0"), [no(Adjoining), no(Adjoining), no(Adjoining), Shiftable::Yes]);
    assert_eq!(fixed("G1 X1 F=R9\nX2\nX3 F100"), [no(RunTime), no(RunTime), Shiftable::Yes]);
    assert_eq!(fixed("G95 F0.1 S1=500 G1 X1\nSUPA X2\nX3\nS500 X4"), [no(RunTime), no(RunTime), no(RunTime), Shiftable::Yes]);
    assert_eq!(fixed("G1 X1 F=R9\nSUPA G1 X2\nF100 Y3"), [no(RunTime), no(RunTime), no(UnknownStart)]);
    assert_eq!(fixed("G0 X1 RND=2\nG1 Y1\nX0"), [no(Rapid), no(Adjoining), Shiftable::Yes]);
    assert_eq!(fixed("G1 X1\nCT X2 Y2\nG1 X3"), [no(Adjoining), no(Adjoining), Shiftable::Yes]);
    assert_eq!(fixed("G1 X1\nASPLINE X2 Y2\nX3 Y3"), [no(Adjoining), no(NotUnderstood), no(NotUnderstood)]);
    assert_eq!(fixed("G1 X1\nCIP X2 Y2 I1=1 J1=2"), [Shiftable::Yes, no(Adjoining)]);
    assert_eq!(fixed("G111 X0 Y0\nG1 AP=30 RP=10\nX1\nX0"), [no(Adjoining), Shiftable::Yes, Shiftable::Yes]);
    assert_eq!(fixed("G1 X1 A3=0 B3=0 C3=1"), [no(NotUnderstood)]);
    assert_eq!(fixed("G1 X1 U5"), [no(NotUnderstood)]);
    assert_eq!(fixed("SUPA G1 Z0 D0"), [no(MachineCoordinates)]);
    assert_eq!(fixed("G1 X1 D2"), [no(ToolChange)]);
    assert_eq!(
        fixed("G41 G1 X1\nX2\nG40 X3\nX4"),
        [no(CutterCompensation), no(CutterCompensation), no(CutterCompensation), Shiftable::Yes]
    );
    assert_eq!(fixed("CYCLE81(10,0,2,-5)\nG1 X1"), [no(UnknownStart)]);
    assert_eq!(fixed("G1 X=R7\nX1"), [no(RunTime), no(UnknownStart)]);
    assert_eq!(fixed("G1 X1 FB=100\nX2"), [no(Adjoining), Shiftable::Yes]);
    assert_eq!(fixed("G1 X1 H5"), [no(Unsplittable)]);
    assert_eq!(fixed("G1 X1 M3 M0"), [no(Unsplittable)]);
    assert_eq!(fixed("G1 X1 M5"), [Shiftable::Yes]);
    assert_eq!(fixed("G331 Z-5 K1\nG332 Z5 K1"), [no(Threading), no(Threading)]);
}

#[test]
fn the_head_of_an_archive_and_its_end_are_no_code() {
    let text = "%_N_PLATE_MPF\n;$PATH=/_N_WKS_DIR/_N_PLATE_WPD\nG54 G0 X0 Y0 Z0\nG1 X5 F100\nM30\n%_N_OTHER_SPF\nG1 X99\nM17\n";
    assert_eq!(Dialect::detect(&parse(text)), Dialect::Sinumerik);
    assert_eq!(read(text).moves.len(), 2);
}

#[test]
fn modes_that_a_switch_may_skip_end_what_is_known() {
    assert_eq!(after("/TRANS X5\nG0 X0 Y0 Z0\nG1 X1").shiftable, Shiftable::No(Fixed::NotUnderstood));
    assert_eq!(after("/G1 X5\nG1 Y1").shiftable, Shiftable::No(Fixed::UnknownStart));
    assert_eq!(after("/MSG(\"x\")\nG1 X1").shiftable, Shiftable::Yes);
}

/// The programs of `tests/sinumerik`, which the product's tests compensate too.
#[test]
fn real_programs_are_recognised_and_read() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/sinumerik");
    let mut count = 0;
    for entry in std::fs::read_dir(&folder).expect("the folder").map(|entry| entry.expect("an entry").path()) {
        let bytes = std::fs::read(&entry).expect("a file");
        let program = parse(bytes.clone());
        assert_eq!(gcode::edit(&program, &gcode::Edits::new()).as_deref(), Ok(bytes.as_slice()), "{entry:?}");
        assert_eq!(gcode::recognise(&program), None, "{entry:?}");
        if entry.extension().is_some_and(|ending| ending == "mpf") {
            count += 1;
            assert_eq!(Dialect::detect(&program), Dialect::Sinumerik, "{entry:?}");
            let options = Options::from(Dialect::Sinumerik);
            let files = |name: &str| std::fs::read(folder.join(name)).ok();
            let flat = gcode::expand(&program, &options, &files).unwrap_or(bytes);
            let mut flat = Dialect::Sinumerik.read(parse(flat));
            evaluate(&mut flat, &options, &files).unwrap_or_else(|error| panic!("{entry:?}\n{error}"));
            let path = interpret(&flat, &options).unwrap_or_else(|error| panic!("{entry:?}\n{error}"));
            assert!(path.moves.iter().any(|step| step.shiftable == Shiftable::Yes), "{entry:?}");
        }
    }
    assert!(count >= 12, "{count} programs");
}

#[test]
fn a_fault_names_the_codes_of_the_control() {
    let read = |text: &str| interpret(&Dialect::Sinumerik.read(parse(text)), &Dialect::Sinumerik.into());
    let Err(gcode::GcodeError::Refused { diagnostics }) = read("G90 G0 X0 Y0 Z0\nF100\nG2 X10 Y0 I15 J10\nG1 X=1") else {
        panic!("it is refused")
    };
    let fault = diagnostics.iter().find(|fault| fault.message.contains("no circle")).expect("the arc");
    assert_eq!(fault.help, None);
    let path = read("G90 G0 X0 Y0 Z0\nG1 X=1 F100").expect("a move");
    assert!(path.warnings[0].message.starts_with("none of G70, G71, G700, G710"), "{:?}", path.warnings);
}

#[test]
fn names_of_modes_that_leave_the_path_alone_open_nothing() {
    for block in ["FIFOCTRL", "ORISON", "CYCLE832()"] {
        let program = format!("{START}{block}\nG1 X1\nY1");
        assert_eq!(last(&program).shiftable, Shiftable::Yes, "{block}");
        assert!(read(&program).warnings.is_empty(), "{block}");
    }
    // What F refers to, and the feed of a tooth.
    let grouped = read(&format!("{START}FGROUP(X,Y)\nG1 X1\nFGROUP()\nG0 X0 Y0 Z0\nG1 X1\nG94 FZ=0.05\nX2\nX3 F600\nX4"));
    let feeds: Vec<_> = grouped.moves.iter().filter(|step| step.is_feed()).map(|step| step.shiftable == Shiftable::Yes).collect();
    assert_eq!(feeds, [false, true, false, true, true]);
    assert!(grouped.warnings.iter().any(|warning| warning.message.contains("`FGROUP(X,Y)`")), "{:?}", grouped.warnings);
    // Under a feed profile F holds at the end of its block.
    for profile in ["FLIN", "FCUB"] {
        let of = read(&format!("{START}G1 X1 F500\n{profile}\nX2 F3000\nY2\nFNORM\nG0 X0 Y0 Z0\nG1 X1\nX2"));
        let of: Vec<_> = of.moves.iter().filter(|step| step.is_feed()).map(|step| step.shiftable == Shiftable::Yes).collect();
        assert_eq!(of, [true, false, false, true, true], "{profile}");
    }
}

#[test]
fn blocks_that_wait_for_the_spindle_and_polynomials_are_left_alone() {
    for block in ["X5 SPOS=90", "X5 TURN=2", "POLY PO[X]=(5,0.25) PO[Y]=(0,0.1) PL=1"] {
        let of = ends(&format!("{START}G1 X1\n{block}\nG1 X0 Y0 Z0\nX2"));
        assert_ne!(of[2].1, Shiftable::Yes, "{block}");
        assert_eq!(of.last().unwrap().1, Shiftable::Yes, "{block}");
    }
}

#[test]
fn moves_beside_a_spline_keep_their_direction() {
    let (yes, beside) = (Shiftable::Yes, Shiftable::No(Fixed::Adjoining));
    let shiftable = |text: &str| -> Vec<Shiftable> {
        let of: Vec<Move> = read(&format!("{START}{text}")).moves;
        of.iter().filter(|step| step.is_feed()).map(|step| step.shiftable).collect()
    };
    for between in ["", "BTAN\n", "BNAT ENAT\n", "MSG(\"a\")\n"] {
        let found = shiftable(&format!("G1 X5\nX20 Y0.05\n{between}CSPLINE X20 Y10\nX30 Y20\n{between}G1 X30 Y40\nX0\nY0"));
        assert_eq!(found[..2], [yes, beside], "{between}");
        assert_eq!(found[found.len() - 3..], [beside, yes, yes], "{between}");
    }
}

#[test]
fn modes_that_end_beside_a_move_leave_it_its_words() {
    for name in ["DIAMOF", "FNORM", "CP", "TOROTOF", "PAROTOF", "TRAFOOF", "FGROUP()"] {
        for block in [format!("G1 X20 {name}"), format!("{name} G1 X20")] {
            let found = ends(&format!("{START}{block}\nX20 Y15"));
            let [.., (first, _), (second, shiftable)] = found.as_slice() else { panic!("{block}") };
            assert_eq!((*first, *second, *shiftable), ([20.0, 0.0, 0.0], [20.0, 15.0, 0.0], Shiftable::Yes), "{block}");
        }
    }
    // Where it ends a section, only a full position is known again.
    let found = ends(&format!("{START}DIAMON\nG1 X10\nDIAMOF X20\nY15\nG0 X0 Y0 Z0\nG1 Y5"));
    assert_eq!(found[found.len() - 3].1, Shiftable::No(Fixed::UnknownStart), "{found:?}");
    assert_eq!(found.last().unwrap().1, Shiftable::Yes);
}

#[test]
fn frames_with_parentheses_or_a_motion_code_are_not_read_as_those_of_words() {
    for block in ["TRANS(X10,Y5)", "ATRANS(X10)", "SCALE(X2)", "MIRROR(X)", "ROT(Z30)", "G0 Z50 TRANS"] {
        let found = read(&format!("{START}{block}\nG1 X5 Y5 Z0\nX8"));
        assert!(found.moves.iter().rev().take(2).all(|step| step.shiftable != Shiftable::Yes), "{block}");
    }
}

#[test]
fn a_contour_that_a_cycle_runs_again_is_not_split() {
    let contour = "KA: G1 X30 F600\nG1 Y30\nKE: G1 X0\nG1 Y0\n";
    let shiftable = |cycle: &str| -> Vec<Shiftable> {
        ends(&format!("{START}{contour}{cycle}M30\n")).into_iter().skip(1).take(4).map(|(_, shiftable)| shiftable).collect()
    };
    let held = Shiftable::No(Fixed::Unsplittable);
    assert_eq!(shiftable(""), [Shiftable::Yes; 4]);
    assert_eq!(shiftable("CYCLE72(\"KA:KE\",10,0,1,-5,2,0,0,500,200,11,42,1,2,,1,2,)\n"), [held, held, held, Shiftable::Yes]);
}
