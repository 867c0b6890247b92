//! RS-274 decimal numbers: sign, digits, one point, blanks anywhere, no exponent.

/// Powers of ten that an f64 holds exactly.
const EXACT_POWERS_OF_TEN: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21,
    1e22,
];
/// Integers up to this are exact in an f64.
const LARGEST_EXACT_INTEGER: u64 = 1 << 53;

pub(crate) fn is_blank(byte: u8) -> bool {
    byte == b' ' || byte == b'\t'
}

/// First index at or after `at` that is not a blank.
pub(crate) fn skip_blanks(line: &[u8], mut at: usize) -> usize {
    while line.get(at).is_some_and(|b| is_blank(*b)) {
        at += 1;
    }
    at
}

/// Reads a number at `at`. Returns the index past its last byte and its value, rounded to nearest.
///
/// Blanks between digits belong to the number, by RS-274 and its controls.
pub(crate) fn scan_number(line: &[u8], at: usize) -> Option<(usize, f64)> {
    match line.get(at) {
        Some(b'-') => scan_digits(line, skip_blanks(line, at + 1), true, at),
        Some(b'+') => scan_digits(line, skip_blanks(line, at + 1), false, at),
        _ => scan_digits(line, at, false, at),
    }
}

fn scan_digits(line: &[u8], from: usize, negative: bool, start: usize) -> Option<(usize, f64)> {
    let (mut mantissa, mut digits, mut decimals, mut overflow) = (0_u64, 0_usize, 0_usize, false);
    let mut point = false;
    let mut at = from;
    let mut end = from;
    while let Some(&byte) = line.get(at) {
        match byte {
            b'0'..=b'9' => {
                let next = mantissa.checked_mul(10).and_then(|m| m.checked_add(u64::from(byte - b'0')));
                match next {
                    Some(value) => mantissa = value,
                    None => overflow = true,
                }
                digits += 1;
                decimals += usize::from(point);
            }
            b'.' if !point => point = true,
            _ if is_blank(byte) => {
                let next = skip_blanks(line, at);
                match line.get(next) {
                    Some(b'0'..=b'9') => {}
                    Some(b'.') if !point => {}
                    _ => break,
                }
                at = next;
                continue;
            }
            _ => break,
        }
        at += 1;
        end = at;
    }
    if digits == 0 {
        return None;
    }
    let fast = if overflow || mantissa > LARGEST_EXACT_INTEGER { None } else { EXACT_POWERS_OF_TEN.get(decimals) };
    let value = match fast {
        // One division of two exact numbers is correctly rounded.
        Some(power) => {
            let magnitude = mantissa as f64 / power;
            if negative { -magnitude } else { magnitude }
        }
        None => slow_number(&line[start..end])?,
    };
    Some((end, value))
}

/// `None` if the digits exceed the precision of an f64.
fn slow_number(text: &[u8]) -> Option<f64> {
    let packed: String = text.iter().filter(|b| !is_blank(**b)).map(|b| char::from(*b)).collect();
    packed.parse().ok().filter(|value: &f64| value.is_finite())
}

/// Whether a value begins with two signs.
pub(crate) fn has_two_signs(value: &[u8]) -> bool {
    let mut marks = value.iter().filter(|byte| !is_blank(**byte));
    let mut is_sign = || marks.next().is_some_and(|byte| b"+-".contains(byte));
    is_sign() && is_sign()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_what_the_standard_library_reads() {
        let texts = [
            "0",
            "-0",
            "+1",
            "1.",
            ".5",
            "-.0007",
            "100.",
            "007",
            "0.1",
            "123456.789012345678901234",
            "9007199254740993",
            "-1701.841",
            "0.30000000000000004",
            "18446744073709551616.25",
        ];
        for text in texts {
            let (end, value) = scan_number(text.as_bytes(), 0).expect(text);
            assert_eq!(end, text.len());
            assert_eq!(value.to_bits(), text.parse::<f64>().expect(text).to_bits(), "{text}");
        }
    }

    #[test]
    fn stops_at_the_end_of_the_number() {
        assert_eq!(scan_number(b"1.5Y2", 0), Some((3, 1.5)));
        assert_eq!(scan_number(b"- 1 2 . 5 Y2", 0), Some((9, -12.5)));
        assert_eq!(scan_number(b"1.5.5", 0), Some((3, 1.5)));
        assert_eq!(scan_number(b"1E5", 0), Some((1, 1.0)));
        assert_eq!(scan_number(b"-", 0), None);
        assert_eq!(scan_number(b".", 0), None);
        assert_eq!(scan_number(b"", 0), None);
    }
}
