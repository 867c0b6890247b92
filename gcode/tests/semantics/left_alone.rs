//! Moves that are not changed, and why.

use gcode::{CutterCompensation, Dialect, Fixed, MoveKind, Options, Shiftable, interpret, parse};

use crate::{feeds, last, read, read_as, shifts};

#[test]
fn moves_that_are_not_changed() {
    let path = read(
        "G21 G0 X0 Y0 Z0\nG1 X1 F100\n/G1 X2\nM6 T2 X3\nG41 D1 X4\nX5\nG40 X6\nX7\nG53 X0\nG0 X0 Y0\nG33 Z-1 F1\nG4 P1500\n",
    );
    use Fixed::{
        CutterCompensation as Cutter, Dwell, MachineCoordinates, OptionalBlock, Rapid, Threading, ToolChange, UnknownStart,
    };
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
            no(UnknownStart),
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
fn what_another_control_may_do_leaves_the_moves_behind_it_alone() {
    let frame = "G21 G90 G17\nG0 X0 Y0 Z5\nG1 X2 F600\n";
    let behind = |block: &str, after: &str| feeds(&format!("{frame}{block}\n{after}"), Dialect::Fanuc);
    let unknown = Shiftable::No(Fixed::UnknownStart);
    // A tool's length is selected by D on SINUMERIK, NUM and Fagor; with G43 in the program it is not.
    for block in ["D2", "T2 D2", "N40 D2"] {
        assert_eq!(behind(block, "X9\nG1 X9 Y1 Z5\nX20\n"), [Shiftable::Yes, unknown, unknown, Shiftable::Yes], "{block}");
    }
    assert_eq!(feeds(&format!("{frame}D2\nX9\nG43 H1 Z5\n"), Dialect::Fanuc)[1], Shiftable::Yes);
    assert_eq!(feeds(&format!("{frame}D1\nX5\nG41 D1 X9\n"), Dialect::Fanuc)[1], Shiftable::Yes);
    assert!(feeds(&format!("{frame}G41 D1 X9\nG40 X20\nX30\n"), Dialect::Fanuc)[3] == Shiftable::Yes);
    // No hole is drilled with K0 or L0; whether the tool moves over it differs.
    for block in ["G98 G81 X10 Y10 Z-5 R2 K0 F200\nG80", "G99 G81 X10 Y10 Z-5 R2 L0 F200\nG80"] {
        assert_eq!(behind(block, "G1 X20 F600\n"), [Shiftable::Yes, unknown], "{block}");
    }
    // Repeated by Fagor's N behind the words.
    let repeated = behind("G91 X10 N3", "Y5\n");
    assert_eq!(repeated, [Shiftable::Yes, Shiftable::No(Fixed::NotUnderstood), unknown]);
    assert_eq!(behind("X10 N3", "Y5 N4\n"), [Shiftable::Yes; 3]);
    // Fagor: a move until contact.
    assert!(behind("G52 X20 F500", "G0 X0 Y0 Z5\nG1 X20 F600\n")[1] != Shiftable::Yes);
    // Some controls end a block at the semicolon.
    let not_understood = Shiftable::No(Fixed::NotUnderstood);
    assert_eq!(behind("X9; G91", "X10\n"), [Shiftable::Yes, not_understood, not_understood]);
    for comment in ["X9 ; 3 holes", "X9 ;", "X9 ; X10 is the end", "; G91", "X9 (G91)", "X9 F600 ; F is 600", "X9 R0"] {
        assert_eq!(behind(comment, "X30\n").last(), Some(&Shiftable::Yes), "{comment}");
    }
    // A corner that is rounded by R without a comma.
    let adjoining = Shiftable::No(Fixed::Adjoining);
    assert_eq!(behind("X9 R2", "Y10\nX20\n"), [Shiftable::Yes, adjoining, adjoining, Shiftable::Yes]);
}

#[test]
fn the_unit_may_stand_beside_the_tool() {
    let feed = |head: &str| last(&read(&format!("{head}\nG0 X0 Y0 Z5\nG1 X1 F600\n"))).end.xyz_mm().map(|end| end[0]);
    assert_eq!(feed("N10 G71 G90 G17 S1000 M3 T1 D1"), Some(1.0));
    assert_eq!(feed("N10 G70 G90 G17 S1000 M3 T1 D1"), Some(25.4));
    assert!(interpret(&parse("G71 D2 X3 F600\nG1 X1\n"), &Dialect::Fanuc.into()).is_err());
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
fn a_block_that_changes_an_offset_with_its_motion_is_left_alone_on_fanuc() {
    for word in ["H2", "G43 H1", "G49", "T0101", "D3"] {
        let part = format!("G21 G90 F600\nG0 X0 Y0 Z0\nG1 X10 {word}\nG1 X20\n");
        assert_eq!(feeds(&part, Dialect::Fanuc)[0], Shiftable::No(Fixed::ToolChange), "{word}");
    }
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
    // LinuxCNC has no such words.
    let text = "G21 G17 G90 G0 X0 Y0 Z0\nG1 X10 ,R2. F100\nY10\n";
    assert!(interpret(&parse(text), &Dialect::LinuxCnc.into()).is_err());
}
