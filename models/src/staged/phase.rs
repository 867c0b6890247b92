//! Sine and cosine of many phases at once.

use std::f64::consts::TAU;

use pulp::{Simd, WithSimd};

use crate::recurrent::Level;

/// Writes sine and cosine of phases in turns, to within 1e-15, to `sin` and `cos`, which are as long.
pub(super) fn sin_cos_of(turns: &[f64], sin: &mut [f64], cos: &mut [f64]) {
    Level::detect().run(Phases { turns, sin, cos });
}

struct Phases<'a> {
    turns: &'a [f64],
    sin: &'a mut [f64],
    cos: &'a mut [f64],
}

impl WithSimd for Phases<'_> {
    type Output = ();

    /// Plain code without branches, which the compiler turns into vectors of the level's width.
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for ((turns, sin), cos) in self.turns.iter().zip(self.sin).zip(self.cos) {
            (*sin, *cos) = sin_cos(*turns);
        }
    }
}

/// Coefficients of the series of `sin y / y` and `cos y` in `y²`, which an eighth of a turn needs.
const SIN: [f64; 8] = [
    1.0,
    -1.0 / 6.0,
    1.0 / 120.0,
    -1.0 / 5_040.0,
    1.0 / 362_880.0,
    -1.0 / 39_916_800.0,
    1.0 / 6_227_020_800.0,
    -1.0 / 1_307_674_368_000.0,
];
const COS: [f64; 9] = [
    1.0,
    -0.5,
    1.0 / 24.0,
    -1.0 / 720.0,
    1.0 / 40_320.0,
    -1.0 / 3_628_800.0,
    1.0 / 479_001_600.0,
    -1.0 / 87_178_291_200.0,
    1.0 / 20_922_789_888_000.0,
];

#[inline(always)]
fn sin_cos(turns: f64) -> (f64, f64) {
    // The nearest quarter of a turn, and what is left, without rounding: at most an eighth.
    let quarters = (4.0 * turns).round_ties_even();
    let y = (turns - 0.25 * quarters) * TAU;
    let square = y * y;
    let series = |terms: &[f64]| terms.iter().rev().fold(0.0, |sum, term| sum * square + term);
    let (near, far) = (y * series(&SIN), series(&COS));
    let quadrant = quarters - 4.0 * (0.25 * quarters).floor();
    let odd = quadrant == 1.0 || quadrant == 3.0;
    let (sin, cos) = if odd { (far, near) } else { (near, far) };
    (if quadrant >= 2.0 { -sin } else { sin }, if quadrant == 1.0 || quadrant == 2.0 { -cos } else { cos })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_the_standard_library_has_them() {
        let turns: Vec<f64> = (-4000..4000).map(|k| f64::from(k) / 250.0).chain([0.0, 0.125, -0.125, 1e-9, 1e6 + 0.25]).collect();
        let (mut sin, mut cos) = (vec![0.0; turns.len()], vec![0.0; turns.len()]);
        sin_cos_of(&turns, &mut sin, &mut cos);
        for ((t, sin), cos) in turns.iter().zip(sin).zip(cos) {
            // Whole turns taken off first: they would cost the standard library's argument its last digits.
            let (expected_sin, expected_cos) = ((t - t.round()) * TAU).sin_cos();
            assert!((sin - expected_sin).abs() < 1e-15 && (cos - expected_cos).abs() < 1e-15, "{t}: {sin} {cos}");
        }
    }
}
