//! Splits one line of dialogue into words. Total: every non-blank byte belongs to exactly one word.

use crate::number::is_blank;
use crate::word::{Word, WordKind, offset, plain};

/// Names of a positioning block that stand alone: path functions, radius compensation, feeds.
const MOTION_ALONE: [&[u8]; 13] = [b"L", b"C", b"CR", b"CT", b"LP", b"CP", b"CTP", b"RL", b"RR", b"F", b"FMAX", b"AUTO", b"MAX"];
/// Names of a positioning block that have a value: incremental and polar coordinates, direction, feeds.
const MOTION_VALUED: [&[u8]; 16] =
    [b"IX", b"IY", b"IZ", b"IA", b"IB", b"IC", b"IU", b"IV", b"IW", b"PR", b"PA", b"IPR", b"IPA", b"DR", b"FU", b"FZ"];
/// Ends of a name that are the beginning of a parameter: `FQ5`, `XQL2`.
const PARAMETERS: [&[u8]; 4] = [b"QL", b"QR", b"QS", b"Q"];

fn listed(list: &[&[u8]], name: &[u8]) -> bool {
    list.iter().any(|entry| entry.eq_ignore_ascii_case(name))
}

/// Whether the first line that is not blank is `BEGIN PGM`, perhaps with a block number.
pub(crate) fn is_dialogue(text: &[u8]) -> bool {
    let mut lines = text.split(|byte| matches!(byte, b'\n' | b'\r')).map(<[u8]>::trim_ascii);
    let first = lines.find(|line| !line.is_empty()).unwrap_or_default();
    let digits = first.iter().position(|byte| !byte.is_ascii_digit()).unwrap_or(first.len());
    let mut words = first[digits..].split(|byte| is_blank(*byte)).filter(|word| !word.is_empty());
    [&b"BEGIN"[..], b"PGM"].iter().all(|name| words.next().is_some_and(|word| word.eq_ignore_ascii_case(name)))
}

/// Splits `line`, whose first byte is at offset `base` of the program, and appends its words.
pub(crate) fn lex_line(line: &[u8], base: u32, words: &mut Vec<Word>) {
    let mut at = 0;
    // Block number and block-skip character stand at the head.
    let (mut is_head, mut is_numbered) = (true, false);
    while let Some(&byte) = line.get(at) {
        if is_blank(byte) {
            at += 1;
            continue;
        }
        let word = match byte {
            b';' => plain(WordKind::Comment, at, line.len(), base),
            b'*' if is_head => plain(WordKind::Comment, at, line.len(), base),
            b'/' if is_head => plain(WordKind::BlockDelete, at, at + 1, base),
            b'0'..=b'9' if is_head && !is_numbered => block_number(line, at, base),
            b'"' => plain(WordKind::Keyword, at, string_end(line, at), base),
            b'~' => plain(WordKind::Keyword, at, at + 1, base),
            _ if byte.is_ascii_alphabetic() => named(line, at, base),
            _ => match number(line, at) {
                Some((end, value)) => Word { value, ..plain(WordKind::Keyword, at, end, base) },
                None => plain(WordKind::Unknown, at, unknown_end(line, at), base),
            },
        };
        at = (word.span.end - base) as usize;
        is_numbered |= word.is(b'N');
        is_head &= word.is(b'N') || word.kind == WordKind::BlockDelete;
        words.push(word);
    }
}

fn block_number(line: &[u8], at: usize, base: u32) -> Word {
    let length = line[at..].iter().position(|byte| !byte.is_ascii_digit()).unwrap_or(line.len() - at);
    let value = number(line, at).map_or(f64::NAN, |(_, value)| value);
    Word { letter: b'N', value, ..plain(WordKind::Number, at, at + length, base) }
}

fn string_end(line: &[u8], at: usize) -> usize {
    line[at + 1..].iter().position(|byte| *byte == b'"').map_or(line.len(), |length| at + length + 2)
}

fn unknown_end(line: &[u8], at: usize) -> usize {
    let is_other = |byte: &u8| is_blank(*byte) || byte.is_ascii_alphanumeric() || b";\"~+-.,".contains(byte);
    line[at + 1..].iter().position(is_other).map_or(line.len(), |length| at + 1 + length)
}

/// A signed number with a decimal point or comma at `at`: the index past it, and its value.
fn number(line: &[u8], at: usize) -> Option<(usize, f64)> {
    let mut end = at + usize::from(matches!(line.get(at), Some(b'+' | b'-')));
    let digits = end;
    let mut has_mark = false;
    while let Some(byte) = line.get(end) {
        match byte {
            b'0'..=b'9' => {}
            b'.' | b',' if !has_mark => has_mark = true,
            _ => break,
        }
        end += 1;
    }
    if !line[digits..end].iter().any(u8::is_ascii_digit) {
        return None;
    }
    let text: String = line[at..end].iter().map(|byte| if *byte == b',' { '.' } else { char::from(*byte) }).collect();
    text.parse().ok().map(|value| (end, value))
}

/// Index past a parameter `Q1`, `QL1`, `QR1`, `QS1` at `at`.
fn parameter_end(line: &[u8], at: usize) -> Option<usize> {
    let rest = line.get(at..)?;
    let name = PARAMETERS.iter().find(|name| rest.get(..name.len()).is_some_and(|head| head.eq_ignore_ascii_case(name)))?;
    let digits = rest[name.len()..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    (digits > 0).then_some(at + name.len() + digits)
}

/// A name with its value: `L`, `X+10`, `IPA+360`, `DR-`, `X+Q1`, `FMAX`.
fn named(line: &[u8], at: usize, base: u32) -> Word {
    let letters = line[at..].iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
    let length = letters - parameter_within(line, at, letters);
    let name = &line[at..at + length];
    let value_at = at + length;
    let sign = usize::from(matches!(line.get(value_at), Some(b'+' | b'-')));
    let letter = if length == 1 { name[0].to_ascii_uppercase() } else { 0 };
    let kind = |single: WordKind, list: &[&[u8]]| match letter {
        0 if listed(list, name) => WordKind::Motion,
        0 => WordKind::Keyword,
        _ => single,
    };
    let (kind, end, value) = if let Some((end, value)) = number(line, value_at) {
        (kind(WordKind::Number, &MOTION_VALUED), end, value)
    } else if let Some(end) = parameter_end(line, value_at + sign) {
        (kind(WordKind::Expression, &MOTION_VALUED), end, f64::NAN)
    } else if sign == 1 && (name.eq_ignore_ascii_case(b"DR") || letter == b'R') {
        let value = if line[value_at] == b'-' { -1.0 } else { 1.0 };
        (WordKind::Motion, value_at + 1, value)
    } else {
        let kind = if listed(&MOTION_ALONE, name) { WordKind::Motion } else { WordKind::Keyword };
        return Word { value_start: offset(base, value_at), ..plain(kind, at, value_at, base) };
    };
    let letter = if matches!(kind, WordKind::Number | WordKind::Expression) { letter } else { 0 };
    Word { value_start: offset(base, value_at), letter, value, ..plain(kind, at, end, base) }
}

/// Number of letters at the end of a name that begin a parameter.
fn parameter_within(line: &[u8], at: usize, letters: usize) -> usize {
    let follows = line.get(at + letters).is_some_and(u8::is_ascii_digit);
    let name = &line[at..at + letters];
    let is_end = |end: &&&[u8]| name.len() > end.len() && name[name.len() - end.len()..].eq_ignore_ascii_case(end);
    let is_address =
        |head: &[u8]| (head.len() == 1 && b"XYZABCUVWFR".contains(&head[0].to_ascii_uppercase())) || listed(&MOTION_VALUED, head);
    PARAMETERS.iter().find(is_end).filter(|end| follows && is_address(&name[..name.len() - end.len()])).map_or(0, |end| end.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(line: &str) -> Vec<(WordKind, u8, String)> {
        let mut words = Vec::new();
        lex_line(line.as_bytes(), 0, &mut words);
        words.iter().map(|word| (word.kind, word.letter, line[word.span.range()].to_owned())).collect()
    }

    #[test]
    fn a_positioning_block_is_split() {
        use WordKind::{Comment, Expression, Motion, Number};
        let found = words("12 L X+10,5 IY-.25 Z+Q12 R0 FMAX M3 ; up");
        let expected = [
            (Number, b'N', "12"),
            (Motion, 0, "L"),
            (Number, b'X', "X+10,5"),
            (Motion, 0, "IY-.25"),
            (Expression, b'Z', "Z+Q12"),
            (Number, b'R', "R0"),
            (Motion, 0, "FMAX"),
            (Number, b'M', "M3"),
            (Comment, 0, "; up"),
        ];
        assert_eq!(found, expected.map(|(kind, letter, text)| (kind, letter, text.to_owned())));
    }

    #[test]
    fn values_are_read() {
        let line = "C X+10,5 DR- FQ5 R-2.5 7.1";
        let mut words = Vec::new();
        lex_line(line.as_bytes(), 0, &mut words);
        let values: Vec<f64> = words.iter().map(|word| word.value).collect();
        assert!(values[0].is_nan() && values[3].is_nan());
        assert_eq!([values[1], values[2], values[4], values[5]], [10.5, -1.0, -2.5, 7.1]);
        assert_eq!((words[3].kind, words[3].letter), (WordKind::Expression, b'F'));
    }

    #[test]
    fn dialogue_begins_with_its_name() {
        for text in ["0 BEGIN PGM A MM", "\r\n  begin pgm 12 INCH\r\n", "BEGIN PGM"] {
            assert!(is_dialogue(text.as_bytes()), "{text}");
        }
        for text in ["", "%\nBEGIN PGM", "(BEGIN PGM)", "BEGIN PGMS", "G0 X1 BEGIN PGM"] {
            assert!(!is_dialogue(text.as_bytes()), "{text}");
        }
    }
}
