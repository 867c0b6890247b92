//! Recognition of SINUMERIK programs by codes and forms that no other control has.

use super::names::meaning;
use super::scan::{assigns, name};
use crate::number::skip_blanks;

/// Names of statements and functions that RS-274 does not have.
const NAMES: [&str; 13] =
    ["CALL", "DEF", "ENDFOR", "ENDIF", "ENDLOOP", "ENDWHILE", "EXTCALL", "GOTOB", "GOTOC", "GOTOF", "MCALL", "PROC", "REPEATB"];
/// G codes of SINUMERIK alone: frames, exact-stop criteria, blending, units of length and feed, settable offsets.
const CODES: [std::ops::RangeInclusive<u32>; 7] = [153..=153, 290..=291, 450..=451, 500..=599, 601..=603, 641..=645, 700..=710];

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
    let mut found = false;
    for line in text.split(|byte| matches!(byte, b'\n' | b'\r')) {
        match of_line(line.trim_ascii()) {
            Sign::Certain => return true,
            Sign::Against => return false,
            Sign::For => found = true,
            Sign::Open => {}
        }
    }
    found
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
    if is_number || code.starts_with(b"(") || code.contains(&b'#') {
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
        ] {
            assert!(!is_sinumerik(text.as_bytes()), "{text}");
        }
    }
}
