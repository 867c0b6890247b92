//! Ends of numbers, names, brackets and expressions in a line of a SINUMERIK program.

use std::borrow::Cow;

use crate::number::{is_blank, skip_blanks};

/// Operators between the operands of an expression, longest first ("Arithmetic functions", "Comparison operations and logic operations").
const SIGNS: [&[u8]; 12] = [b"==", b"<>", b">=", b"<=", b"<<", b"+", b"-", b"*", b"/", b">", b"<", b":"];
const WORDS: [&[u8]; 8] = [b"DIV", b"MOD", b"AND", b"OR", b"XOR", b"B_AND", b"B_OR", b"B_XOR"];

fn is_name_byte(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_'
}

/// The letters, digits and underscores at `at`.
pub(crate) fn name(line: &[u8], at: usize) -> &[u8] {
    let rest = line.get(at..).unwrap_or_default();
    &rest[..rest.iter().position(|byte| !is_name_byte(*byte)).unwrap_or(rest.len())]
}

/// Whether a name states how the value in its parentheses is meant: absolute, incremental, by the shortest way, from a table ("Absolute and
/// incremental dimensions", "Coded positions").
pub(crate) fn is_dimension(name: &[u8]) -> bool {
    let known: [&[u8]; 10] = [b"AC", b"IC", b"DC", b"ACP", b"ACN", b"CAC", b"CIC", b"CDC", b"CACP", b"CACN"];
    known.iter().any(|known| name.eq_ignore_ascii_case(known))
}

/// End and value of the number at `at`: sign, digits, point, exponent `EX`. Blanks end it.
pub(crate) fn number(line: &[u8], at: usize) -> Option<(usize, f64)> {
    let rest = line.get(at..)?;
    let signed = usize::from(matches!(rest.first(), Some(b'+' | b'-')));
    let body = &rest[signed..];
    let length = body.iter().position(|byte| !(byte.is_ascii_digit() || *byte == b'.')).unwrap_or(body.len());
    let mantissa = std::str::from_utf8(&rest[..signed + length]).ok()?;
    if !mantissa.bytes().any(|byte| byte.is_ascii_digit()) {
        return None;
    }
    let mut end = signed + length;
    let mut text = Cow::Borrowed(mantissa);
    if rest.get(end..end + 2).is_some_and(|mark| mark.eq_ignore_ascii_case(b"EX")) {
        let sign = usize::from(matches!(rest.get(end + 2), Some(b'+' | b'-')));
        let digits = rest[end + 2 + sign..].iter().take_while(|byte| byte.is_ascii_digit()).count();
        if digits > 0 {
            let exponent = std::str::from_utf8(&rest[end + 2..end + 2 + sign + digits]).ok()?;
            text = Cow::Owned(format!("{mantissa}e{exponent}"));
            end += 2 + sign + digits;
        }
    }
    let value: f64 = text.parse().ok()?;
    value.is_finite().then_some((at + end, value))
}

/// Index behind the bracket that closes the one at `at`; the end of the line if none does. Strings are skipped.
pub(crate) fn bracket_end(line: &[u8], at: usize) -> usize {
    let mut depth = 0_usize;
    let mut index = at;
    while let Some(byte) = line.get(index) {
        match byte {
            b'"' => {
                index = string_end(line, index);
                continue;
            }
            b'(' | b'[' => depth += 1,
            b')' | b']' => depth = depth.saturating_sub(1),
            _ => {}
        }
        index += 1;
        if depth == 0 {
            return index;
        }
    }
    line.len()
}

/// Index behind the quotation mark that closes the one at `at`.
pub(crate) fn string_end(line: &[u8], at: usize) -> usize {
    let mark = line.get(at).copied().unwrap_or_default();
    let rest = line.get(at + 1..).unwrap_or_default();
    rest.iter().position(|byte| *byte == mark).map_or(line.len(), |length| at + length + 2)
}

/// End of the statement at `at`: the comment, or the end of the line without blanks.
pub(crate) fn statement_end(line: &[u8], at: usize) -> usize {
    let mut end = at;
    while let Some(byte) = line.get(end) {
        match byte {
            b';' => break,
            b'"' => end = string_end(line, end),
            _ => end += 1,
        }
    }
    while end > at + 1 && is_blank(line[end - 1]) {
        end -= 1;
    }
    end
}

/// Whether an equals sign stands at `at` that is no comparison.
pub(crate) fn assigns(line: &[u8], at: usize) -> bool {
    line.get(at) == Some(&b'=') && line.get(at + 1) != Some(&b'=')
}

/// Length of the operator at `at`.
pub(crate) fn operator(line: &[u8], at: usize) -> Option<usize> {
    let rest = line.get(at..)?;
    if let Some(sign) = SIGNS.iter().find(|sign| rest.starts_with(sign)) {
        return Some(sign.len());
    }
    let word = name(line, at);
    WORDS.iter().any(|known| known.eq_ignore_ascii_case(word)).then_some(word.len())
}

/// End of the expression at `at`; `None` if there is none.
pub(crate) fn expression_end(line: &[u8], at: usize) -> Option<usize> {
    let mut end = operand_end(line, skip_blanks(line, at))?;
    loop {
        let Some(length) = operator(line, skip_blanks(line, end)) else { return Some(end) };
        let next = skip_blanks(line, skip_blanks(line, end) + length);
        match operand_end(line, next) {
            Some(past) => end = past,
            None => return Some(end),
        }
    }
}

fn operand_end(line: &[u8], at: usize) -> Option<usize> {
    let mut at = at;
    loop {
        let word = name(line, at);
        match line.get(at)? {
            b'+' | b'-' => at = skip_blanks(line, at + 1),
            _ if word.eq_ignore_ascii_case(b"NOT") || word.eq_ignore_ascii_case(b"B_NOT") => {
                at = skip_blanks(line, at + word.len());
            }
            _ => break,
        }
    }
    match line.get(at)? {
        b'(' => Some(bracket_end(line, at)),
        b'"' | b'\'' => Some(string_end(line, at)),
        b'0'..=b'9' | b'.' => number(line, at).map(|(end, _)| end),
        b'$' => Some(indexed_end(line, at + 1 + name(line, at + 1).len())),
        byte if byte.is_ascii_alphabetic() || *byte == b'_' => Some(indexed_end(line, at + name(line, at).len())),
        _ => None,
    }
}

/// End of the index and the arguments behind a name that ends at `at`.
fn indexed_end(line: &[u8], at: usize) -> usize {
    let mut end = at;
    while matches!(line.get(end), Some(b'[' | b'(')) {
        end = bracket_end(line, end);
    }
    let open = skip_blanks(line, end);
    if end == at && line.get(open) == Some(&b'(') { bracket_end(line, open) } else { end }
}
