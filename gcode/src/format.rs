//! Numbers as a program writes them: no exponent, no minus zero, no trailing zeros, always a decimal point.

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
    if !value.is_finite() {
        return Err(GcodeError::NotFinite { value });
    }
    let mut text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.truncate(text.trim_end_matches('0').len());
    } else {
        text.push('.');
    }
    let is_zero = !text.bytes().any(|b| matches!(b, b'1'..=b'9'));
    Ok(if is_zero { "0.".to_owned() } else { text })
}

#[cfg(test)]
mod tests {
    use super::*;

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
