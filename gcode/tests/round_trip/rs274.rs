//! RS-274 programs.

use gcode::{Dialect, Edits, Options, edit, interpret, parse};
use proptest::prelude::*;

use crate::{check_bytes, check_interpretation};

/// Program fragments, joined at random. Close enough to G-code to reach every branch.
fn pieces() -> impl Strategy<Value = String> {
    let fixed = prop::sample::select(vec![
        "G0",
        "G1",
        "g2",
        "G3",
        "G17",
        "G18",
        "G19",
        "G20",
        "G21",
        "G28",
        "G30",
        "G33",
        "G38.2",
        "G4",
        "G40",
        "G41",
        "G43",
        "G49",
        "G52",
        "G53",
        "G54",
        "G55",
        "G54.1",
        "G59.3",
        "G61",
        "G64",
        "G65",
        "G66",
        "G67",
        "G68",
        "G69",
        "G7",
        "G8",
        "G73",
        "G80",
        "G81",
        "G83",
        "G90",
        "G91",
        "G90.1",
        "G91.1",
        "G92",
        "G92.1",
        "G92.2",
        "G92.3",
        "G93",
        "G94",
        "G95",
        "G96",
        "G98",
        "G99",
        "G10",
        "G123",
        "G1.55",
        "M2",
        "M3",
        "M6",
        "M30",
        "M98",
        "M99",
        "M62",
        "#1=2",
        "#<a>=[1",
        "X#1",
        "Y[#1+2]",
        "(c)",
        "(open",
        ";c",
        "/",
        "%",
        "O1",
        "o1 sub",
        "o1 endsub",
        "o1 if [1]",
        "o1 endif",
        "o<f> call",
        "IF[#1EQ1]GOTO1",
        "WHILE[1]DO1",
        "END1",
        "GOTO1",
        "\n",
        "\r\n",
        "\r",
        " ",
        "\t",
        "\0",
        "X=1",
        ",R1",
        "L2",
        "L20",
        "K0",
        "X",
        "G",
        "XSIN[1]",
        "--",
        "X-+1",
        "P-1",
        "P1e9",
    ]);
    let letters = prop::sample::select(b"XYZABCIJKRFPQLSTHDNEUVW".to_vec());
    let word =
        (letters, -50.0..50.0_f64, 0..5_usize).prop_map(|(letter, value, digits)| format!("{}{value:.digits$}", letter as char));
    let huge = (prop::sample::select(vec!["X1", "Z1", "I1", "F1", "R1", "P1"]), 8..320_usize)
        .prop_map(|(word, zeros)| word.to_owned() + &"0".repeat(zeros));
    prop_oneof![6 => word, 6 => fixed.prop_map(str::to_owned), 3 => Just("\n".to_owned()), 1 => huge]
}

fn programs() -> impl Strategy<Value = Vec<u8>> {
    prop_oneof![
        prop::collection::vec(any::<u8>(), 0..400),
        prop::collection::vec(pieces(), 0..80).prop_map(|pieces| pieces.concat().into_bytes()),
        prop::collection::vec(pieces(), 0..80).prop_map(|pieces| pieces.join(" ").into_bytes()),
        prop::collection::vec(pieces(), 0..80).prop_map(|pieces| format!("\u{feff}{}", pieces.concat()).into_bytes()),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn parsing_keeps_every_byte(bytes in programs()) {
        let program = parse(bytes.clone());
        check_bytes(&program, &bytes)?;
    }

    #[test]
    fn interpreting_never_panics(bytes in programs(), linux_cnc: bool, block_delete: Option<bool>) {
        let dialect = if linux_cnc { Dialect::LinuxCnc } else { Dialect::Fanuc };
        let program = parse(bytes);
        Dialect::detect(&program);
        let options = Options { block_delete, ..dialect.into() };
        check_interpretation(&program, &options)?;
    }

    #[test]
    fn edits_change_only_what_they_name(
        bytes in programs(),
        cuts in prop::collection::vec((any::<prop::sample::Index>(), prop::collection::vec(any::<u8>(), 0..6)), 0..12),
    ) {
        let program = parse(bytes.clone());
        let mut chosen: Vec<_> = cuts.iter().filter(|_| !program.words().is_empty()).map(|(at, text)| (at.index(program.words().len()), text)).collect();
        chosen.sort_by_key(|(word, _)| *word);
        chosen.dedup_by_key(|(word, _)| *word);
        let mut edits = Edits::new();
        for (word, text) in chosen.iter().rev() {
            edits.replace(program.words()[*word].span, (*text).clone());
        }
        let out = edit(&program, &edits).expect("words do not overlap");
        // Compare both: bytes between edits must be equal, edited bytes must be the given text.
        let (mut old, mut new) = (0, 0);
        for (word, text) in &chosen {
            let span = program.words()[*word].span;
            let kept = span.start as usize - old;
            prop_assert_eq!(&out[new..new + kept], &bytes[old..old + kept]);
            prop_assert_eq!(&out[new + kept..new + kept + text.len()], text.as_slice());
            old = span.end as usize;
            new += kept + text.len();
        }
        prop_assert_eq!(&out[new..], &bytes[old..]);
    }

    #[test]
    fn inserted_lines_are_lines(lines in prop::collection::vec("[A-Z0-9 ]{0,8}", 1..6), ending in prop::sample::select(vec!["\n", "\r\n", "\r"]), last: bool, at in any::<prop::sample::Index>()) {
        let text = lines.join(ending) + if last { ending } else { "" };
        let program = parse(text);
        prop_assume!(!program.blocks().is_empty());
        let block = at.index(program.blocks().len());
        let mut edits = Edits::new();
        edits.insert_after(&program, block, &["(after)", "(after 2)"]).expect("the block exists");
        edits.insert_before(&program, block, &["(before)"]).expect("the block exists");
        let again = parse(edit(&program, &edits).expect("no overlap"));
        prop_assert_eq!(again.blocks().len(), program.blocks().len() + 3);
        let line = |index: usize| again.text(again.blocks()[index].span);
        prop_assert_eq!(line(block), b"(before)");
        prop_assert_eq!(line(block + 1), program.text(program.blocks()[block].span));
        prop_assert_eq!(line(block + 2), b"(after)");
        prop_assert_eq!(line(block + 3), b"(after 2)");
    }
}

#[test]
fn no_pattern_makes_the_time_quadratic() {
    let begin = std::time::Instant::now();
    for piece in [
        "#", "# ", "N1", "/", "[", "X[", "X#", "#[", "#1=", "X-", "X ", "1 ", "(", "O", "O1 ", "AND ", ",A", "#1=1AND", "%",
        "o1 sub\n", "o1 if\n", "G68\n", "\r",
    ] {
        let text = piece.repeat(300_000);
        for bytes in [text.clone(), format!("N1{text}//"), format!("{}{}", "N1".repeat(300_000), "/".repeat(100_000))] {
            let program = parse(bytes.into_bytes());
            let _ = interpret(&program, &Dialect::LinuxCnc.into());
        }
    }
    // Seconds if linear, hours if not.
    assert!(begin.elapsed().as_secs() < 120);
}
