//! Interpolation between samples.

use std::ops::{Add, Mul, Sub};

/// Value and derivative at `t` in `[0, 1]` of the cubic from `from` to `to` with these end
/// derivatives.
#[inline]
#[must_use]
pub fn hermite<V>(from: V, to: V, leaving: V, arriving: V, t: f64) -> (V, V)
where
    V: Copy + Add<Output = V> + Sub<Output = V> + Mul<f64, Output = V>,
{
    let chord = to - from;
    let square = chord * 3.0 - leaving * 2.0 - arriving;
    let cube = leaving + arriving - chord * 2.0;
    (from + (leaving + (square + cube * t) * t) * t, leaving + (square * 2.0 + cube * 3.0 * t) * t)
}

/// Value, and slope per sample, of `values` at a fractional index: the cubic through the samples
/// with central differences, constant beyond the ends.
///
/// Empty `values` give zeros.
#[must_use]
pub fn cubic(values: &[f64], at: f64) -> (f64, f64) {
    let Some(last) = values.len().checked_sub(1) else { return (0.0, 0.0) };
    let at = at.clamp(0.0, last as f64);
    let k = (at.floor() as usize).min(last.saturating_sub(1));
    let t = at - k as f64;
    let value = |i: usize| values[i.min(last)];
    let (before, from, to, after) = (values[k.saturating_sub(1)], value(k), value(k + 1), value(k + 2));
    let (leaving, arriving) = (0.5 * (to - before), 0.5 * (after - from));
    hermite(from, to, leaving, arriving, t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_interpolated_and_parabolas_reproduced() {
        let values: Vec<f64> = (0..10).map(|k| f64::from(k * k)).collect();
        assert_eq!(cubic(&values, 4.0).0, 16.0);
        assert!((cubic(&values, 4.5).0 - 20.25).abs() < 1e-12 && (cubic(&values, 4.5).1 - 9.0).abs() < 1e-12);
        assert_eq!((cubic(&values, -3.0).0, cubic(&values, 99.0).0, cubic(&[], 1.0).0), (0.0, 81.0, 0.0));
        assert_eq!(cubic(&[5.0], 0.3).0, 5.0);
    }
}
