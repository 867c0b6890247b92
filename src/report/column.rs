//! Numbers in the page: typed arrays, little-endian, as base64.

use serde::Serialize;

/// One column of numbers, as the page's `column()` reads it: value = `offset` + `scale` × integer, or the number itself without them.
#[derive(Debug, Clone, Serialize)]
pub struct Column {
    /// `i16`, `u8`, `u32` or `f32`.
    kind: &'static str,
    length: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    scale: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    offset: Option<f64>,
    data: String,
}

/// Integer that stands for no value.
const NONE: i16 = i16::MIN;
/// Steps over the range of a column in 16 bits.
const STEPS: f64 = 65_534.0;

impl Column {
    /// Values in 16 bits each: to 1/65,534 of their range, its ends exactly. What is not finite is no value.
    #[must_use]
    pub fn scaled(values: &[f64]) -> Self {
        let finite = values.iter().copied().filter(|value| value.is_finite());
        let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        let (low, high) = if low <= high { (low, high) } else { (0.0, 0.0) };
        let scale = (high - low) / STEPS;
        let step = |value: &f64| match (value.is_finite(), scale > 0.0) {
            (false, _) => NONE,
            (true, false) => -i16::MAX,
            (true, true) => (((value - low) / scale).round() - f64::from(i16::MAX)) as i16,
        };
        let bytes = values.iter().flat_map(|value| step(value).to_le_bytes());
        let offset = low + f64::from(i16::MAX) * scale;
        Self { scale: Some(scale), offset: Some(offset), ..Self::of("i16", values.len(), bytes) }
    }

    /// Values with seven digits, for positions and lengths. What is not finite is no value.
    #[must_use]
    pub fn float(values: &[f64]) -> Self {
        Self::of("f32", values.len(), values.iter().flat_map(|value| (*value as f32).to_le_bytes()))
    }

    /// Whole numbers.
    #[must_use]
    pub fn whole(values: &[usize]) -> Self {
        let number = |value: &usize| u32::try_from(*value).unwrap_or(u32::MAX).to_le_bytes();
        Self::of("u32", values.len(), values.iter().flat_map(number))
    }

    /// Yes or no.
    #[must_use]
    pub fn flags(values: &[bool]) -> Self {
        Self::of("u8", values.len(), values.iter().map(|value| u8::from(*value)))
    }

    fn of(kind: &'static str, length: usize, bytes: impl Iterator<Item = u8>) -> Self {
        Self { kind, length, scale: None, offset: None, data: base64(&bytes.collect::<Vec<u8>>()) }
    }
}

/// Base64 with padding (RFC 4648, section 4).
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let group = (0..3).fold(0_u32, |group, k| group << 8 | u32::from(chunk.get(k).copied().unwrap_or(0)));
        for digit in 0..4 {
            let known = digit <= chunk.len();
            let index = (group >> (18 - 6 * digit)) & 63;
            text.push(if known { char::from(DIGITS[index as usize]) } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_of_rfc_4648() {
        let cases = [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg=="), ("foobar", "Zm9vYmFy")];
        for (plain, encoded) in cases {
            assert_eq!(base64(plain.as_bytes()), encoded);
        }
    }

    fn read(column: &Column) -> Vec<f64> {
        let digit = |c: u8| match c {
            b'A'..=b'Z' => c - b'A',
            b'a'..=b'z' => c - b'a' + 26,
            b'0'..=b'9' => c - b'0' + 52,
            b'+' => 62,
            _ => 63,
        };
        let digits: Vec<u8> = column.data.bytes().filter(|c| *c != b'=').map(digit).collect();
        let bits: Vec<u8> = digits.iter().flat_map(|d| (0..6).rev().map(move |bit| (d >> bit) & 1)).collect();
        let bytes: Vec<u8> = bits.chunks_exact(8).map(|byte| byte.iter().fold(0, |sum, bit| sum << 1 | bit)).collect();
        let integers = bytes.chunks_exact(2).map(|two| i16::from_le_bytes([two[0], two[1]]));
        integers
            .map(|i| if i == NONE { f64::NAN } else { column.offset.unwrap() + column.scale.unwrap() * f64::from(i) })
            .collect()
    }

    #[test]
    fn scaled_columns_keep_the_ends_of_their_range() {
        let values = [-3.25, 0.1, f64::NAN, 41.7, f64::INFINITY, 2.0];
        let column = Column::scaled(&values);
        let found = read(&column);
        assert!((found[0] + 3.25).abs() < 1e-12 && (found[3] - 41.7).abs() < 1e-12);
        assert!(found[2].is_nan() && found[4].is_nan());
        assert!([1, 5].iter().all(|k| (found[*k] - values[*k]).abs() <= (41.7 + 3.25) / STEPS));
        assert_eq!(read(&Column::scaled(&[7.5, 7.5])), [7.5, 7.5]);
        assert!(Column::scaled(&[]).data.is_empty() && read(&Column::scaled(&[f64::NAN]))[0].is_nan());
    }
}
