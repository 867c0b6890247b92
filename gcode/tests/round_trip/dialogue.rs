//! Dialogue programs, whatever stands behind `BEGIN PGM`.

use gcode::{Language, Options, interpret, parse, recognise, renumber};
use proptest::prelude::*;

use crate::{check_bytes, check_interpretation};

/// Fragments of dialogue, joined at random.
const PIECES: [&str; 78] = [
    "L",
    "C",
    "CR",
    "CT",
    "LP",
    "CP",
    "CTP",
    "CC",
    "RND R2",
    "CHF 1",
    "APPR LT",
    "DEP PLCT",
    "LEN5",
    "R0",
    "RL",
    "RR",
    "R+",
    "R-5",
    "DR+",
    "DR-",
    "FMAX",
    "F MAX",
    "F AUTO",
    "F500",
    "FU0.1",
    "FZ.2",
    "FQ1",
    "F",
    "M3",
    "M91",
    "M99",
    "M103 F20",
    "M120 LA5",
    "M128",
    "M129",
    "M140 MB10",
    "M30",
    "M777",
    "M",
    "IX+5",
    "IPA-720",
    "IPR+1",
    "PA+90",
    "PR20",
    "X+Q1",
    "YQ2",
    "Z-QL3",
    "Q1 = +5",
    "FN 0: Q2 = -3",
    "FN 9: IF +Q1 EQU +1 GOTO LBL 1",
    "LBL 1",
    "LBL \"A",
    "CALL LBL 1 REP 2",
    "TOOL CALL 5 Z S3000 F100",
    "TOOL CALL \"MILL\" Y",
    "TOOL DEF 3",
    "CYCL DEF 7.0",
    "CYCL DEF 7.1 X+5",
    "CYCL DEF 7.1 #3",
    "CYCL DEF 8.1 X",
    "CYCL DEF 10.1 ROT+5",
    "CYCL DEF 200 A ~",
    "CYCL DEF 247 ~",
    "Q339=+1",
    "CYCL CALL",
    "PLANE RESET",
    "PLANE SPATIAL",
    "TRANS DATUM AXIS",
    "STOP",
    "END PGM",
    "/",
    "~",
    ";c",
    "* - a",
    "\n",
    "\r\n",
    "\t",
    "99999999999999999999",
];

fn programs() -> impl Strategy<Value = Vec<u8>> {
    let letters = prop::sample::select(b"XYZABCUVWRFSQ".to_vec());
    let word = (letters, -50.0..50.0_f64, 0..5_usize, any::<bool>()).prop_map(|(letter, value, digits, comma)| {
        let number = format!("{}{value:+.digits$}", letter as char);
        if comma { number.replace('.', ",") } else { number }
    });
    let piece =
        prop_oneof![4 => word, 6 => prop::sample::select(PIECES.to_vec()).prop_map(str::to_owned), 3 => Just("\n".to_owned())];
    let head = prop::sample::select(vec!["BEGIN PGM A MM\n", "0 BEGIN PGM A INCH\r\n", "\u{feff}\n 7 begin pgm\r"]);
    let body = prop_oneof![
        1 => prop::collection::vec(any::<u8>(), 0..400),
        3 => (prop::collection::vec(piece, 0..80), prop::sample::select(vec!["", " "])).prop_map(|(pieces, by)| pieces.join(by).into_bytes()),
    ];
    (head, body).prop_map(|(head, body)| [head.as_bytes(), &body].concat())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn parsing_keeps_every_byte(bytes in programs()) {
        let program = parse(bytes.clone());
        prop_assert_eq!(program.language(), Language::Dialogue);
        check_bytes(&program, &bytes)?;
    }

    #[test]
    fn interpreting_never_panics(bytes in programs(), block_delete: Option<bool>) {
        let program = parse(bytes);
        recognise(&program);
        check_interpretation(&program, &Options { block_delete, ..Options::default() })?;
    }

    /// Numbering changes numbers only, and a program that it numbered stays.
    #[test]
    fn numbering_is_stable(bytes in programs()) {
        let once = renumber(&parse(bytes.clone())).expect("a parsed program can be numbered");
        let program = parse(once.clone());
        prop_assert_eq!(program.blocks().len(), parse(bytes).blocks().len());
        prop_assert_eq!(renumber(&program), Ok(once));
    }
}

#[test]
fn no_pattern_makes_the_time_quadratic() {
    let begin = std::time::Instant::now();
    for piece in [
        "L X+Q1\n",
        "Q1 = 5\n",
        "LBL 1\n",
        "CALL LBL 1\n",
        "C DR+ F1\n",
        "~\n",
        "X",
        "Q",
        "+",
        "1 ",
        "CC\nCT X+1 Y+1 F1\n",
        "\"",
        "CYCL DEF 10.1 ROT+1\n",
    ] {
        let program = parse(format!("BEGIN PGM A MM\n{}", piece.repeat(100_000)));
        let _ = interpret(&program, &Options::default());
        let _ = renumber(&program);
    }
    // Seconds if linear, hours if not.
    assert!(begin.elapsed().as_secs() < 60);
}
