//! Recognition of SINUMERIK programs by codes and forms that no other control has.

use super::names::meaning;
use super::scan::{assigns, name};
use crate::lexer::lex_line;
use crate::number::skip_blanks;

/// Names of statements and functions that RS-274 does not have.
const NAMES: [&str; 13] =
    ["CALL", "DEF", "ENDFOR", "ENDIF", "ENDLOOP", "ENDWHILE", "EXTCALL", "GOTOB", "GOTOC", "GOTOF", "MCALL", "PROC", "REPEATB"];
/// G codes of SINUMERIK alone: frames, exact-stop criteria, blending, units of length and feed, settable offsets.
const CODES: [std::ops::RangeInclusive<u32>; 7] = [153..=153, 290..=291, 450..=451, 500..=599, 601..=603, 641..=645, 700..=710];

/// G codes of Fanuc, Haas and LinuxCNC: units, reference points, tool length, local frames, rotation, canned cycles, return levels.
const CODES_OF_OTHERS: [f64; 24] = [
    20.0, 21.0, 28.0, 30.0, 43.0, 44.0, 49.0, 52.0, 68.0, 69.0, 73.0, 76.0, 80.0, 81.0, 82.0, 83.0, 84.0, 85.0, 86.0, 89.0, 92.0,
    98.0, 99.0, 61.0,
];

/// Remedy where a program of another dialect holds a line that [`is_likely`].
pub(crate) const SINUMERIK_HELP: &str = "give --dialect sinumerik if the program is one: this line looks like it";

/// Longest name of the control, bytes, and more.
const LONGEST: usize = 64;

/// What one line says.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Sign {
    /// Nothing.
    Open,
    For,
    Against,
    /// The head of an archived program.
    Certain,
}

/// Whether `text` is a SINUMERIK program.
pub(crate) fn is_sinumerik(text: &[u8]) -> bool {
    let (mut found, mut likely, mut last_ends) = (false, false, false);
    for line in lines(text) {
        match of_line(line) {
            Sign::Certain => return true,
            Sign::Against => return false,
            Sign::For => found = true,
            Sign::Open => {}
        }
        let code = code_of(line);
        if !code.is_empty() {
            likely |= is_likely(line);
            last_ends = code.eq_ignore_ascii_case(b"M17");
        }
    }
    found || ((likely || last_ends) && !lines(text).any(has_code_of_others))
}

fn lines(text: &[u8]) -> impl Iterator<Item = &[u8]> {
    text.split(|byte| matches!(byte, b'\n' | b'\r')).map(<[u8]>::trim_ascii)
}

/// The block of a line without its comment, slash and number.
fn code_of(line: &[u8]) -> &[u8] {
    let code = line.split(|byte| *byte == b';').next().unwrap_or_default().trim_ascii();
    let code = code.strip_prefix(b"/").unwrap_or(code).trim_ascii_start();
    let number = if code.first().is_some_and(|byte| byte.eq_ignore_ascii_case(&b'N')) { 1 + digits(&code[1..]) } else { 0 };
    if number > 1 { code[number..].trim_ascii_start() } else { code }
}

fn digits(text: &[u8]) -> usize {
    text.iter().take_while(|byte| byte.is_ascii_digit()).count()
}

/// Whether a line has a form of SINUMERIK that other controls hardly have: a call `L100`, a label `NAME:`, `REPEAT NAME`, `G4 F2`, a tapping cycle
/// G331, a pole G110 with coordinates, a jump `GOTOF`.
pub(crate) fn is_likely(line: &[u8]) -> bool {
    let code = code_of(line);
    let Some(first) = code.first().map(u8::to_ascii_uppercase) else { return false };
    let word = name(code, 0);
    let behind = code[word.len()..].trim_ascii_start();
    match first {
        b'L' if word.len() > 1 && digits(&word[1..]) == word.len() - 1 => {
            behind.is_empty() || (behind[0].eq_ignore_ascii_case(&b'P') && digits(&behind[1..]) == behind.len() - 1)
        }
        b'G' => is_likely_code(code),
        b'I' if word.eq_ignore_ascii_case(b"IF") => jumps(code),
        _ if word.eq_ignore_ascii_case(b"REPEAT") => behind.first().is_some_and(u8::is_ascii_alphabetic),
        // A label begins with two letters.
        _ => word.len() > 1 && word[..2].iter().all(u8::is_ascii_alphabetic) && behind.first() == Some(&b':'),
    }
}

fn is_likely_code(code: &[u8]) -> bool {
    let mut words = Vec::new();
    lex_line(code, 0, &mut words);
    let has = |letters: &[u8]| words.iter().any(|word| letters.iter().any(|letter| word.is(*letter)));
    match words.first() {
        Some(word) if word.is(b'G') && word.value == 4.0 => has(b"FS") && !has(b"PXU"),
        Some(word) if word.is(b'G') && (110.0..=112.0).contains(&word.value) => has(b"XYZ") || contains_word(code, b"AP"),
        Some(word) => word.is(b'G') && [331.0, 332.0].contains(&word.value),
        None => false,
    }
}

fn jumps(code: &[u8]) -> bool {
    [&b"GOTOF"[..], b"GOTOB", b"GOTOC"].iter().any(|word| contains_word(code, word))
}

fn contains_word(code: &[u8], word: &[u8]) -> bool {
    code.windows(word.len()).any(|window| window.eq_ignore_ascii_case(word))
}

/// Whether a line has a code that SINUMERIK does not have in its own dialect, or that means something else there.
fn has_code_of_others(line: &[u8]) -> bool {
    let mut words = Vec::new();
    lex_line(code_of(line), 0, &mut words);
    words.iter().any(|word| {
        (word.is(b'G') && (CODES_OF_OTHERS.contains(&word.value) || word.value.fract() != 0.0))
            || (word.is(b'M') && (97.0..=99.0).contains(&word.value))
    })
}

/// Whether `text` has program numbers, comments in parentheses or parameters of other controls.
pub(crate) fn is_of_another(text: &[u8]) -> bool {
    text.split(|byte| matches!(byte, b'\n' | b'\r')).any(|line| of_line(line.trim_ascii()) == Sign::Against)
}

fn of_line(line: &[u8]) -> Sign {
    if line.get(..4).is_some_and(|head| head.eq_ignore_ascii_case(b"%_N_")) || line.starts_with(b";$PATH=") {
        return Sign::Certain;
    }
    let code = line.split(|byte| *byte == b';').next().unwrap_or_default();
    let is_number = code.len() > 1 && code[0].eq_ignore_ascii_case(&b'O') && (code[1].is_ascii_digit() || code[1] == b'<');
    // System variables have an underscore: `$P_UIFR`. Grbl's commands have none.
    let is_command = code.starts_with(b"$") && !name(code, 1).contains(&b'_');
    if is_number || is_command || code.starts_with(b"(") || code.contains(&b'#') {
        return Sign::Against;
    }
    let mut sign = Sign::Open;
    let mut at = 0;
    // Only a block number or a slash stands before.
    let mut at_head = true;
    while let Some(&byte) = code.get(at) {
        if byte == b'(' {
            // Behind a name it holds arguments, else a comment.
            return if sign == Sign::For { Sign::For } else { Sign::Open };
        }
        if !byte.is_ascii_alphabetic() {
            at += 1;
            continue;
        }
        // Letters and numbers may follow each other without blanks over the whole line.
        let word = name(&code[..code.len().min(at + LONGEST)], at);
        if is_own(code, at, word, at_head) {
            sign = Sign::For;
        }
        at_head &= word[0].eq_ignore_ascii_case(&b'N') && word[1..].iter().all(u8::is_ascii_digit);
        let letters = word.iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
        // `G1X10` is several words.
        at += if letters > 1 { word.len() } else { 1 };
    }
    sign
}

/// Whether the word at `at` is one that only SINUMERIK has.
fn is_own(code: &[u8], at: usize, word: &[u8], at_head: bool) -> bool {
    let past = skip_blanks(code, at + word.len());
    let letters = word.iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
    if letters == 1 {
        let digits = word[1..].iter().take_while(|byte| byte.is_ascii_digit()).count();
        let number = std::str::from_utf8(&word[1..1 + digits]).ok().and_then(|text| text.parse::<u32>().ok());
        let is_code = word[0].eq_ignore_ascii_case(&b'G') && number.is_some_and(|n| CODES.iter().any(|codes| codes.contains(&n)));
        let has_value =
            assigns(code, skip_blanks(code, at + 1 + digits)) && b"XYZABCIJKFRSMT".contains(&word[0].to_ascii_uppercase());
        return is_code || has_value;
    }
    // `IF R1==1 GOTOF END`.
    if word.eq_ignore_ascii_case(b"IF") && at_head && jumps(code) {
        return true;
    }
    let text = String::from_utf8_lossy(word).to_ascii_uppercase();
    let known = meaning(&text, true).is_some() || text == "CR";
    let is_called = code.get(past) == Some(&b'(');
    NAMES.contains(&text.as_str()) && at_head || known && (at_head || is_called || assigns(code, past))
}

#[cfg(test)]
mod tests {
    use super::is_sinumerik;

    #[test]
    fn programs_are_recognised_by_their_own_codes() {
        for text in [
            "%_N_PLATE_MPF\n;$PATH=/_N_WKS_DIR\nG1 X1\n",
            "N10 G54 G64 G642\n",
            "G1 X=10 F500",
            "r1=5\nG0 X0\n",
            "N10 CYCLE800(1,\"TABLE\",0,57)\n",
            "n20 trans x10\n",
            "G2 X10 Y0 CR=5",
            "MSG(\"Tasche\")\nG0 X0",
            "IF R1 > 5 \n N10 gotof END\n",
            "SUPA G0 Z0 D0",
            "G1 X1\nN50 L100\nX2",
            "G1 X1\nL20 P3\nX2",
            "G0 X1\nN45 G4 F2\n",
            "G0 X1\nG4 S30\n",
            "G331 Z-10 K1\n",
            "G110 X5 Y5\nG1 X1",
            "G0 X1\nM17\n\n",
            "G0 X1\nLAB1:\nG1 X2\n",
            "REPEAT LAB1 LAB2 P=2\n",
            "IF R1==1 GOTOF END\n",
        ] {
            assert!(is_sinumerik(text.as_bytes()), "{text}");
        }
        for text in [
            "%\nO0001\nG1 X1 (R1=5)\n",
            "(CYCLE81(1))\nG1 X1\n",
            "G0 X0 Y0 ; R1=5\n",
            "#1=5\nG1 X#1\n",
            "o100 sub\nTRAORI\n",
            "G1 X10 Y20 F100\nM30\n",
            "G91 G28 Z0\nG43 H1 Z50\n",
            "0 BEGIN PGM A MM\n",
            "G1 X1 (MSG(1))\n",
            "G21 G90\nL100\nG1 X1",
            "G1 X1 L3\nG4 P500 F100\n",
            "G0 X1\nG4 S2\nG28 Z0\n",
            "G110\nG1 X1",
            "M17\nG1 X1\n",
            "G54.1 P1\nL5\n",
            "$J=G91 X10 F500\nG1 X1\n",
            "$H\nG1 X1\nL20\n",
        ] {
            assert!(!is_sinumerik(text.as_bytes()), "{text}");
        }
    }
}
