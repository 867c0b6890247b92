//! Blocks with words that are not read: what may be changed behind them.

use gcode::{Dialect, Shiftable, expand, interpret, parse};

use crate::read;

/// The blocks whose moves may be changed where these stand between a move and `behind`.
fn changed(blocks: &str, behind: &str) -> Vec<u32> {
    let path = read(&format!("G21 G17 G90 G94 G0 X0 Y0 Z0\nG1 X5 F100\n{blocks}\n{behind}\nM30\n"));
    assert!(path.warnings.iter().any(|warning| warning.line == 3), "{blocks}: {:?}", path.warnings);
    path.moves.iter().filter(|step| step.shiftable == Shiftable::Yes).map(|step| step.block).collect()
}

#[test]
fn a_coordinate_that_is_not_read_leaves_the_position_unknown_until_it_is_stated() {
    for block in [
        "X20 X21",
        "X20 I1",
        "X20 Q5",
        "X20 U5",
        "X20 V-1 W2",
        "X20,5",
        "X--20",
        "X=20",
        "X.",
        "X",
        "Y=-3",
        "X20 ,",
        "G1 X20,5 Y2 F200",
        "G2 X20,5 Y2 R30",
        "X(P1)",
        "X=#500",
        "X20. G40 I-1. J0.",
    ] {
        assert_eq!(changed(block, "X30\nG1 X30 Y5 Z-1\nX40"), [1, 5], "{block}");
    }
}

#[test]
fn a_statement_that_is_not_read_leaves_all_behind_it_alone() {
    for block in [
        "X20 E5",
        "X20 'REMARK",
        "X20 \"REMARK\"",
        "X20 !",
        "X20 /M8",
        "X20 & Y1",
        "> X20",
        "X20 FOO(3)",
        "X20;M98 P5",
        // The first word that is not read is not the only one.
        "X=VC1 F=VC2",
        "X+Q1 FQ10",
        "X(P1) F(P2)",
        "X--5 \"CALL\"",
        "X(P1) CALL O100",
        "V.A.ORGT[1].X = 50",
        "X20 ,R",
        "X20 F1,500",
        "X30.,G91",
        "X30.,F100",
        "G54,1 P2",
        "G91,1",
        "G91 X,5",
        "X20 M8 ,",
        "X20 D1 D2",
        // Neither is a feed move.
        "G0 X22,5 Y5 Z0",
        "G0 X20 Y20 Z1,",
        "G99 G81 X10 Y10 Z-5 R=VC1",
        "G99 G81 X22,5 Y10 Z-5 R2",
        "G92 X=E1",
        "G92 X(P1)",
        "G92 X22,5",
        "G52 X(P1)",
        "G52 X2,5",
        "G52 X.",
        "G52 X(P1) F1000",
        "G52 X5,Y5",
        "G10 L2 P1 X=VC1",
        "G10 L2 P1 R=VC1",
        "G28 X--5 Y0",
        "G28 X Y",
        "G7.1 C=VC1",
    ] {
        assert_eq!(changed(block, "G80\nG0 X1 Y1 Z1\nG1 X30 Y5 Z-1\nX40 F100"), [1], "{block}");
    }
}

#[test]
fn which_of_two_codes_or_feeds_is_in_force_is_not_known_until_it_is_stated() {
    for block in [
        "G0 G1 X20",
        "G1 G0 X20",
        "G1 G2 X20 R40",
        "G2 G2 G3 X20 R40",
        "G1 G1 G0 X20",
        "G0 G81 X20 Z-1 R2",
        "G1 G33 X20",
        "G0 G1",
    ] {
        assert_eq!(changed(block, "X30 Y5 Z-1\nG80\nX35 Y6 Z-1\nG1 X40 Y5 Z-1\nX45"), [1, 7], "{block}");
    }
    for block in ["X20 F100 F200", "F100 F200"] {
        assert_eq!(changed(block, "X30 Y5 Z-1\nX40\nX50 F300\nX60"), [1, 5, 6], "{block}");
    }
}

#[test]
fn g90_and_g91_in_a_block_leave_moves_alone_until_one_is_stated() {
    for block in ["G91 G28 Z0 G90", "G90 X10 G91 Y2"] {
        assert_eq!(changed(block, "G1 X30 Y5 Z-1\nX35\nG90 X30 Y5 Z-1\nX40"), [1, 6], "{block}");
    }
}

#[test]
fn words_behind_a_semicolon_are_a_block_in_a_program_without_remarks_there() {
    let path = |block: &str, end: &str| {
        read(&format!("(PART)\n;\nG21 G17 G90 G94 G0 X0 Y0 Z0\nG1 X5 F100\n{block}\nX30 Y5 Z-1\nX40\nM30 ;{end}\n"))
    };
    let changed = |block: &str, end: &str| path(block, end).moves.iter().filter(|step| step.shiftable == Shiftable::Yes).count();
    for block in [
        "X20;M98 P5 (DRILL)",
        "X20;M98 P#1",
        "X20;/M98 P5",
        "X20;Y10. ,R2.",
        "X20;Y[10.]",
        "X20;Y10.(A);X5.",
        "X20;#1=5",
        "X20;GOTO 5",
        "X20;M6 T5",
        "X20;M21",
        "X20;N5 G91",
        "X20;X20",
        "X20;M5",
        "X20;M30",
        "X20;M99 P10",
        "X20;H2",
        "X20;S2000",
        "X20;G91;X5;%",
        "X20;M60",
        "X20;IF[#500EQ1]GOTO10",
        "X20;WHILE[#1LT5]DO1",
        "X20;END1",
        "(DRILL);G91 X5",
        "N10;G91 X5",
    ] {
        assert_eq!(changed(block, ""), 1, "{block}");
        // A remark shows that all are.
        let moves = if block.contains("X20") { 4 } else { 3 };
        assert_eq!(changed(block, " end of part"), moves, "{block}");
    }
    for block in [
        "X20;if X5 is worn change it",
        "X20; end of part 3",
        "X20;3 mm drill",
        "X20;F is 100",
        "X20;goto safe height",
        "X20;",
        "X20;(X5)",
    ] {
        assert_eq!(changed(block, ""), 4, "{block}");
    }
}

#[test]
fn an_axis_that_only_words_name_that_are_not_read_is_not_taken_to_rest() {
    let path = read("G21 G17 G90 G94 G0 X0 Y0\nG1 X5 F1000\nZ-,5\nX30 Y5\nX40\nY20\nM30\n");
    assert!(path.moves.iter().all(|step| step.shiftable != Shiftable::Yes || step.block < 2), "{path:?}");
}

#[test]
fn letters_that_stand_twice_are_all_looked_at() {
    for block in ["X20 X21 F100 F200", "N1 N2 F100 F200", "S1000 S1200 F100 F200"] {
        assert_eq!(changed(block, "G1 X30 Y5 Z-1\nX40"), [1], "{block}");
    }
    for block in ["X20 X21 D1 D2", "G92 X5 X6", "G52 X5 X6", "G10 L2 P1 R45 R0", "X20,5 F--500", "G81 X10 Y10 Z-5 R2 G80"] {
        let behind = if block.contains("G80") { "X30 Y20\nX40" } else { "G1 X30 Y5 Z-1\nX40" };
        assert_eq!(changed(block, behind), [1], "{block}");
    }
    for block in ["X20 X20", "X20 F100 F100", "N1 X20 N1", "T1 M6 T2\nG1 X30 Y5 Z-1"] {
        let path = read(&format!("G21 G17 G90 G94 G0 X0 Y0 Z0\nG1 X5 F100\n{block}\nX40\nM30\n"));
        assert_eq!(path.moves.last().map(|step| step.shiftable), Some(Shiftable::Yes), "{block}: {:?}", path.warnings);
    }
}

#[test]
fn an_exponent_beside_an_m_code_leaves_its_own_move_alone() {
    assert_eq!(changed("M8 X0 E5", "G1 X30 Y5 Z-1\nX40"), [1]);
}

#[test]
fn a_parameter_in_a_word_that_is_not_read_is_not_written_without_its_assignment() {
    for block in ["X40. ,R#101", "X=#101", "X,#101", "X--#101", "X#101;#101=5."] {
        let program = parse(format!("%\nO1\n#101=2.\nG21 G17 G90 G0 X0 Y0 Z0\nG1 X5. F100\n{block}\nX1.\nM30\n"));
        let flat = expand(&program, &Dialect::Fanuc.into(), &|_| None);
        assert!(flat.is_err(), "{block}: {}", String::from_utf8_lossy(&flat.unwrap()));
        assert!(interpret(&program, &Dialect::Fanuc.into()).is_ok(), "{block}");
    }
}
