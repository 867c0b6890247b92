//! SINUMERIK programs: no byte is lost, nothing panics, and a flat program makes the moves of its original.

use gcode::{Dialect, Edits, Move, Options, Span, edit, evaluate, expand, interpret, parse};
use proptest::prelude::*;

const FRAGMENTS: [&str; 96] = [
    "G0",
    "G1",
    "g2",
    "G3",
    "G4 F1",
    "G9",
    "G17",
    "G18",
    "G40",
    "G41",
    "G53",
    "G54",
    "G500",
    "G505",
    "G58",
    "G60",
    "G64",
    "G641",
    "G642",
    "G70",
    "G71",
    "G700",
    "G90",
    "G91",
    "G93",
    "G94",
    "G95",
    "G96",
    "G111",
    "G331",
    "G=R1",
    "M3",
    "M6",
    "M17",
    "M30",
    "M1=3",
    "M99",
    "T1",
    "T=\"A;B\"",
    "D1",
    "S1000",
    "S1=5",
    "F100",
    "F=R1",
    "X10",
    "X=10",
    "Y=R1+2",
    "Z=IC(-1)",
    "X=AC(R2*3)",
    "A=DC(10)",
    "B30",
    "I5",
    "J=AC(5)",
    "CR=5",
    "TURN=2",
    "RND=1",
    "RNDM=2",
    "AP=30",
    "RP=10",
    "A3=1",
    "X1=5",
    "R1=5",
    "R[2]=R1*2",
    "DEF INT I=5",
    "FOR I=1 TO 3",
    "ENDFOR",
    "WHILE R1<9",
    "ENDWHILE",
    "IF R1==5",
    "ELSE",
    "ENDIF",
    "GOTOF AB",
    "GOTOB AB",
    "AB:",
    "REPEAT AB P=2",
    "REPEAT",
    "UNTIL R1>3",
    "SUB",
    "SUB(R1)",
    "L10 P2",
    "CALL \"SUB\"",
    "MCALL CYCLE81(1)",
    "MCALL",
    "CYCLE800()",
    "CYCLE83(10,0,R1)",
    "TRANS X5",
    "ATRANS",
    "ROT RPL=30",
    "TRAORI",
    "TRAFOOF",
    "MSG(\"Stück\")",
    "; Kommentar",
    "/2",
    "N10",
    "$P_UIFR[1]=5",
    "%_N_SUB_SPF",
];

/// Lines of fragments, and now and then any bytes.
fn program() -> impl Strategy<Value = Vec<u8>> {
    let fragment = prop_oneof![
        12 => prop::sample::select(FRAGMENTS.to_vec()).prop_map(|text| text.as_bytes().to_vec()),
        1 => prop::collection::vec(any::<u8>(), 0..6),
        1 => prop::sample::select(vec!["(", ")", "[", "]", "\"", "=", "==", "'", "$", "<<", ":", "%", "EX", "_"])
            .prop_map(|text| text.as_bytes().to_vec()),
    ];
    let blank = prop::sample::select(vec!["", " ", "\n", "\n", "\r\n", " "]);
    prop::collection::vec((fragment, blank), 0..40).prop_map(|parts| {
        let mut text = b"G54 G0 X0 Y0 Z0 F500\n".to_vec();
        for (part, blank) in parts {
            text.extend(part);
            text.extend(blank.as_bytes());
        }
        text
    })
}

fn files(name: &str) -> Option<Vec<u8>> {
    (name == "SUB.SPF").then(|| b"PROC SUB(REAL A)\nG0 X=A\nRET\n".to_vec())
}

/// What a move does.
fn kind(step: &Move) -> (std::mem::Discriminant<gcode::MoveKind>, [i64; 3]) {
    (std::mem::discriminant(&step.kind), step.end.nominal_mm().map(|value| (value * 1e4).round() as i64))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, ..ProptestConfig::default() })]

    #[test]
    fn every_byte_belongs_to_one_word_and_nothing_panics(bytes in program()) {
        let mut program = Dialect::Sinumerik.read(parse(bytes.clone()));
        prop_assert_eq!(&edit(&program, &Edits::new()).expect("no edits"), &bytes);
        let mut at = 0;
        for word in program.words() {
            prop_assert!(word.span.start as usize >= at && word.span.end > word.span.start, "{:?}", word);
            let between = program.text(Span { start: at as u32, end: word.span.start });
            prop_assert!(between.iter().all(|byte| b" \t\r\n".contains(byte)), "{:?}", String::from_utf8_lossy(between));
            at = word.span.end as usize;
        }
        prop_assert!(bytes[at..].iter().all(|byte| b" \t\r\n".contains(byte)));
        let options = Options::from(Dialect::Sinumerik);
        let _ = gcode::recognise(&program);
        if evaluate(&mut program, &options, &files).is_ok() {
            let _ = interpret(&program, &options);
        }
    }

    #[test]
    fn a_flat_program_makes_the_same_moves(bytes in program()) {
        let options = Options::from(Dialect::Sinumerik);
        let mut program = Dialect::Sinumerik.read(parse(bytes));
        let Ok(flat) = expand(&program, &options, &files) else { return Ok(()) };
        evaluate(&mut program, &options, &files).expect("it was expanded");
        let Ok(original) = interpret(&program, &options) else { return Ok(()) };
        let mut flat = Dialect::Sinumerik.read(parse(flat));
        evaluate(&mut flat, &options, &files).expect("a flat program has nothing to evaluate");
        let text = String::from_utf8_lossy(flat.bytes()).into_owned();
        let written = interpret(&flat, &options).unwrap_or_else(|error| panic!("{error}\n{text}"));
        let moves = |path: &gcode::Toolpath| path.moves.iter().map(kind).collect::<Vec<_>>();
        prop_assert_eq!(moves(&original), moves(&written), "{}", text);
    }
}

#[test]
fn no_pattern_makes_the_time_quadratic() {
    let begin = std::time::Instant::now();
    for piece in [
        "(",
        "X(",
        "X=(",
        "X=",
        "X=1+",
        "R1=",
        "R[",
        "[",
        "\"",
        "X=\"",
        "$A[",
        "AB",
        "AB ",
        "AB=",
        "AB(",
        "/",
        "+",
        "X=+ ",
        "N1",
        "A1",
        "IF\n",
        "FOR I=1 TO 2\n",
        "AB:\n",
        "GOTOF AB\n",
        "%_N_A_SPF\n",
        "R1=R1+1 ",
        "DEF REAL ",
        "TRANS X1\n",
        "\r",
    ] {
        let text = piece.repeat(100_000);
        for bytes in [text.clone(), format!("G0 X=1 {text}//")] {
            let program = Dialect::Sinumerik.read(parse(bytes.into_bytes()));
            let _ = interpret(&program, &Dialect::Sinumerik.into());
        }
    }
    // Seconds if linear, hours if not.
    assert!(begin.elapsed().as_secs() < 120);
}
