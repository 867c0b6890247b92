//! SINUMERIK programs: no byte is lost, nothing panics, and a flat program makes the moves of its original.

use std::iter::zip;

use gcode::{Axis, Dialect, Edits, Move, Options, Shiftable, Span, edit, evaluate, expand, interpret, parse};
use proptest::prelude::*;

const FRAGMENTS: [&str; 108] = [
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
    "CIP X10 Y0 I1=5 J1=5",
    "CIP",
    "G111 X5 Y5",
    "G110 X1 Y1",
    "G112 AP=30 RP=5",
    "G3 AP=IC(30)",
    "G1 AP=30 RP=10 Z1",
    "CT X20",
    "I1=5",
    "J1=IC(5)",
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
    "SCALE X1.02 Y1.02 Z1.02",
    "ASCALE X1.5 Y1.5",
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

/// An expression of known values.
fn value() -> impl Strategy<Value = String> + Clone {
    let leaf =
        prop_oneof![(-9..9_i32).prop_map(|n| format!("{n}")), (1..5_u8).prop_map(|n| format!("R{n}")), Just("2.5".to_owned())];
    leaf.prop_recursive(2, 6, 2, |inner| {
        let pair = (inner.clone(), prop::sample::select(vec!["+", "-", "*"]), inner.clone());
        prop_oneof![
            pair.prop_map(|(a, sign, b)| format!("({a}{sign}{b})")),
            (prop::sample::select(vec!["SIN", "COS", "ABS", "TRUNC", "POT"]), inner).prop_map(|(of, x)| format!("{of}({x})")),
        ]
    })
}

/// A block that moves, assigns or changes a mode.
fn block() -> impl Strategy<Value = String> {
    let code = prop::sample::select(vec![
        "G90",
        "G91",
        "G60",
        "G64",
        "TRANS",
        "TRANS X=R1",
        "ATRANS Y2",
        "AROT RPL=30",
        "SCALE X1.02 Y1.02 Z1.02",
        "ASCALE Z0.5",
        "ASCALE X=R1 Y=R1",
        "MSG(\"a;b\")",
        "G9",
        "F=100+ABS(R2)",
        "M8",
    ]);
    let axis = (prop::sample::select(vec!["X", "Y", "Z"]), value(), 0..4_u8).prop_map(|(axis, value, form)| match form {
        0 => format!("{axis}=IC({value})"),
        1 => format!("{axis}=AC({value})"),
        _ => format!("{axis}={value}"),
    });
    let motion = prop::sample::select(vec!["G0", "N7 G0", ""]);
    prop_oneof![
        4 => (motion, axis).prop_map(|(code, axis)| format!("{code} {axis}")),
        2 => (1..5_u8, value()).prop_map(|(number, value)| format!("R{number}={value}")),
        1 => code.prop_map(str::to_owned),
        1 => value().prop_map(|value| format!("SUB({value})")),
    ]
}

/// Blocks in branches, loops, repetitions and jumps.
fn body() -> impl Strategy<Value = String> {
    block().prop_recursive(3, 24, 4, |inner| {
        let lines = prop::collection::vec(inner, 1..4).prop_map(|lines| lines.join("\n"));
        let compared = (value(), prop::sample::select(vec!["<", ">", "==", "<>", ">="]), value());
        let condition = compared.prop_map(|(a, sign, b)| format!("({a}) {sign} ({b})"));
        prop_oneof![
            2 => lines.clone(),
            1 => (condition.clone(), lines.clone(), lines.clone()).prop_map(|(of, a, b)| format!("IF {of}\n{a}\nELSE\n{b}\nENDIF")),
            1 => (6..9_u8, lines.clone()).prop_map(|(n, a)| format!("FOR R{n}=1 TO 2\n{a}\nENDFOR")),
            1 => (10..13_u8, lines.clone()).prop_map(|(n, a)| format!("R{n}=0\nREPEAT\nR{n}=R{n}+1\n{a}\nUNTIL R{n}>=2")),
            1 => (condition, 0..1000_u32, lines.clone()).prop_map(|(of, n, a)| format!("IF {of} GOTOF L_{n}\n{a}\nL_{n}:")),
            1 => (0..1000_u32, lines).prop_map(|(n, a)| format!("S_{n}:\n{a}\nREPEAT S_{n} P=2")),
        ]
    })
}

/// A program that a control runs to its end. Its moves are rapids: feed moves may run only once in place.
fn sound_program() -> impl Strategy<Value = Vec<u8>> {
    let head = "G54 G90 G71 G94\nG0 X0 Y0 Z0 F500\nR1=1 R2=2 R3=3 R4=4\n";
    prop::collection::vec(body(), 1..8).prop_map(move |parts| format!("{head}{}\nM30\n", parts.join("\n")).into_bytes())
}

fn files(name: &str) -> Option<Vec<u8>> {
    (name == "SUB.SPF").then(|| b"PROC SUB(REAL A)\nG0 X=A\nRET\n".to_vec())
}

/// Values are written with nine decimals; increments add up their roundings.
const WRITTEN_MM: f64 = 1e-5;

/// Whether two moves are of a kind and end at the same point. More may be known in the flat program, where words that are never reached are left out.
fn is_same(original: &Move, flat: &Move) -> bool {
    let mut of_axes = zip([Axis::X, Axis::Y, Axis::Z], zip(original.end.nominal_mm(), flat.end.nominal_mm()));
    let is_near = |(axis, (a, b)): (Axis, (f64, f64))| {
        !original.end.is_known(axis) || (flat.end.is_known(axis) && (a - b).abs() < WRITTEN_MM)
    };
    std::mem::discriminant(&original.kind) == std::mem::discriminant(&flat.kind) && of_axes.all(is_near)
}

/// A rotary axis that is named behind the end of the program is one reason more not to trust the rotation; the flat program does not name it.
#[test]
fn words_behind_the_end_make_less_known_and_nothing_else() {
    let options = Options::from(Dialect::Sinumerik);
    let text = b"G54 G0 X0 Y0 Z0 F500\nROT RPL=30\nCT X20\nG0 X10 Y0\nM30\nA=10\n";
    let mut original = Dialect::Sinumerik.read(parse(text.to_vec()));
    let flat = expand(&original, &options, &files).expect("it can be written");
    evaluate(&mut original, &options, &files).expect("it was expanded");
    let original = interpret(&original, &options).expect("it is read");
    let mut flat = Dialect::Sinumerik.read(parse(flat));
    evaluate(&mut flat, &options, &files).expect("nothing to evaluate");
    let flat = interpret(&flat, &options).expect("it is read");
    assert_eq!(original.moves.len(), flat.moves.len());
    assert!(zip(&original.moves, &flat.moves).all(|(a, b)| is_same(a, b)), "{:?}\n{:?}", original.moves, flat.moves);
    assert!(original.moves.iter().all(|of| of.shiftable != Shiftable::Yes), "{:?}", original.moves);
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
    fn a_flat_program_makes_the_same_moves(bytes in prop_oneof![8 => sound_program(), 1 => program()]) {
        let options = Options::from(Dialect::Sinumerik);
        let mut program = Dialect::Sinumerik.read(parse(bytes));
        let Ok(flat) = expand(&program, &options, &files) else { return Ok(()) };
        evaluate(&mut program, &options, &files).expect("it was expanded");
        let Ok(original) = interpret(&program, &options) else { return Ok(()) };
        let mut flat = Dialect::Sinumerik.read(parse(flat));
        evaluate(&mut flat, &options, &files).expect("a flat program has nothing to evaluate");
        let text = String::from_utf8_lossy(flat.bytes()).into_owned();
        let written = interpret(&flat, &options).unwrap_or_else(|error| panic!("{error}\n{text}"));
        prop_assert_eq!(original.moves.len(), written.moves.len(), "{}", text);
        // Where the flat program follows a frame that the original leaves alone, coordinates of the original are those of the frame.
        let in_frame = |(a, b): &(&Move, &Move)| original.modal(a).rotation == written.modal(b).rotation;
        let other = original.moves.iter().zip(&written.moves).filter(in_frame).find(|(a, b)| !is_same(a, b));
        prop_assert!(other.is_none(), "{:?}\n{}", other, text);
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

#[test]
fn most_generated_programs_have_moves_in_loops_and_branches() {
    use proptest::strategy::ValueTree;
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let options = Options::from(Dialect::Sinumerik);
    let (mut read, mut flat) = (0, 0);
    for _ in 0..300 {
        let bytes = sound_program().new_tree(&mut runner).expect("a program").current();
        let mut parsed = Dialect::Sinumerik.read(parse(bytes));
        let is_flat = expand(&parsed, &options, &files).is_ok_and(|text| text != parsed.bytes());
        evaluate(&mut parsed, &options, &files)
            .unwrap_or_else(|error| panic!("{error}\n{}", String::from_utf8_lossy(parsed.bytes())));
        let moves = interpret(&parsed, &options).map_or(0, |path| path.moves.len());
        read += usize::from(moves > 3);
        flat += usize::from(is_flat && moves > 3);
    }
    println!("{read} of 300 have moves, {flat} of them are written anew");
    assert!(read > 150 && flat > 100, "{read} {flat}");
}
