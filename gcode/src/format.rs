//! Numbers in G-code form: no exponent, no minus zero, no trailing zeros, always a decimal point.

use crate::error::GcodeError;
use crate::modal::Units;

/// Writes a length in mm as a coordinate in the program's units with at most `decimals` digits after the point.
///
/// # Errors
/// [`GcodeError::NotFinite`] for NaN and infinities.
pub fn format_coordinate(value_mm: f64, units: Units, decimals: usize) -> Result<String, GcodeError> {
    format_number(value_mm / units.mm(), decimals)
}

/// Writes an angle in rad as degrees with at most `decimals` digits after the point.
///
/// # Errors
/// [`GcodeError::NotFinite`] for NaN and infinities.
pub fn format_angle(value_rad: f64, decimals: usize) -> Result<String, GcodeError> {
    format_number(value_rad.to_degrees(), decimals)
}

/// Writes a number with at most `decimals` digits after the point: `1.`, `-0.25`, `0.`.
///
/// # Errors
/// [`GcodeError::NotFinite`] for NaN and infinities.
pub fn format_number(value: f64, decimals: usize) -> Result<String, GcodeError> {
    let mut text = String::new();
    append_number(&mut text, value, decimals)?;
    Ok(text)
}

/// Appends a number to `text` in the form of [`format_number`]. Returns the value that a reader
/// parses from it.
///
/// # Errors
/// [`GcodeError::NotFinite`] for NaN and infinities.
pub fn append_number(text: &mut String, value: f64, decimals: usize) -> Result<f64, GcodeError> {
    if !value.is_finite() {
        return Err(GcodeError::NotFinite { value });
    }
    if let Some(read) = append_plain(text, value, decimals) {
        return Ok(read);
    }
    let mut number = format!("{value:.decimals$}");
    if number.contains('.') {
        number.truncate(number.trim_end_matches('0').len());
    } else {
        number.push('.');
    }
    let is_zero = !number.bytes().any(|b| matches!(b, b'1'..=b'9'));
    text.push_str(if is_zero { "0." } else { &number });
    // The standard library parses its own output.
    Ok(if is_zero { 0.0 } else { number.parse().unwrap_or(value) })
}

/// Up to this magnitude the error of a scaled number is below [`DOUBT`] and its integers are exact.
const LARGEST: f64 = 1e9;
/// Distance from half a last digit within which the rounding of a scaled number is uncertain.
const DOUBT: f64 = 1e-6;
/// Buffer length: digits and point of a number below [`LARGEST`], with spare decimals.
const ROOM: usize = 24;

/// The same text from integer digits, several times faster. `None` for large numbers and for
/// uncertain rounding.
fn append_plain(text: &mut String, value: f64, decimals: usize) -> Option<f64> {
    let scale = |decimals: usize| Some(10_f64.powi(i32::try_from(decimals).ok()?));
    let scaled = value.abs() * scale(decimals)?;
    if !(scaled < LARGEST && (scaled.fract() - 0.5).abs() > DOUBT && decimals + 2 < ROOM) {
        return None;
    }
    let mut digits = scaled.round() as u64;
    if digits == 0 {
        text.push_str("0.");
        return Some(0.0);
    }
    let mut decimals = decimals;
    while decimals > 0 && digits.is_multiple_of(10) {
        digits /= 10;
        decimals -= 1;
    }
    // A quotient of exact numbers is correctly rounded, as in a parser.
    let read = digits as f64 / scale(decimals)?;
    // From the last digit to the first.
    let mut bytes = [0; ROOM];
    let mut first = ROOM;
    while digits > 0 || ROOM - first <= decimals {
        if ROOM - first == decimals {
            first -= 1;
            bytes[first] = b'.';
        }
        first -= 1;
        bytes[first] = b'0' + (digits % 10) as u8;
        digits /= 10;
    }
    if value < 0.0 {
        text.push('-');
    }
    text.extend(bytes[first..].iter().map(|byte| char::from(*byte)));
    Some(read.copysign(value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plain_digits_are_those_of_the_standard_library() {
        let mut state = 1_u64;
        for k in 0..200_000_usize {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let value = (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
            let value = value * [1e-6, 1e-3, 1.0, 500.0, 1e7][k % 5];
            // Every other number has few digits, so that halves and whole numbers occur.
            let value = if k % 2 == 0 { value } else { (value * 16.0).round() / 16.0 };
            let decimals = k % 8;
            let mut text = format!("{value:.decimals$}");
            if !text.contains('.') {
                text.push('.');
            }
            let text = text.trim_end_matches('0');
            let text = if text.bytes().any(|b| matches!(b, b'1'..=b'9')) { text } else { "0." };
            let mut appended = String::from("X");
            let read = append_number(&mut appended, value, decimals);
            assert_eq!(&appended[1..], text, "{value:e} with {decimals}");
            assert_eq!(read, Ok(text.parse().unwrap()), "{value:e} with {decimals}");
        }
    }

    #[test]
    fn numbers_look_like_a_program() {
        let cases = [
            (1.0, 3, "1."),
            (-0.0001, 3, "0."),
            (-0.25, 3, "-0.25"),
            (100.0, 0, "100."),
            (1.23456, 4, "1.2346"),
            (0.0, 6, "0."),
            (1e-7, 6, "0."),
            (1e20, 1, "100000000000000000000."),
        ];
        for (value, decimals, text) in cases {
            assert_eq!(format_number(value, decimals).as_deref(), Ok(text));
        }
        assert_eq!(format_coordinate(25.4, Units::Inch, 4).as_deref(), Ok("1."));
        assert_eq!(format_angle(std::f64::consts::FRAC_PI_2, 4).as_deref(), Ok("90."));
        assert!(format_number(f64::NAN, 3).is_err() && format_number(f64::INFINITY, 3).is_err());
    }
}
