//! Sums of shifted signals, and series from their second differences.

use pulp::{Simd, WithSimd};

use crate::recurrent::Level;

/// One summand: `weight` times an input, read from `offset` on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Tap {
    /// Index of the input.
    pub input: usize,
    /// Samples.
    pub offset: usize,
    /// Factor.
    pub weight: f64,
}

/// Adds `Σ_taps weight·input[i + offset]` to every `out[i]`.
pub(super) fn add_taps(taps: &[Tap], inputs: &[&[f64]], out: &mut [f64]) {
    Level::detect().run(Sum { taps, inputs, out });
}

/// Number of output vectors summed together, in registers.
const VECTORS: usize = 8;

/// The terms of each output are added in order and rounded one by one: the same bits at every
/// vector width.
struct Sum<'a> {
    taps: &'a [Tap],
    inputs: &'a [&'a [f64]],
    out: &'a mut [f64],
}

impl WithSimd for Sum<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { taps, inputs, out } = self;
        let width = VECTORS * S::F64_LANES;
        let whole = out.len() / width * width;
        for (index, out) in out[..whole].chunks_exact_mut(width).enumerate() {
            let (out, _) = S::as_mut_simd_f64s(out);
            let mut sums = [simd.splat_f64s(0.0); VECTORS];
            sums.copy_from_slice(out);
            for tap in taps {
                let weight = simd.splat_f64s(tap.weight);
                let (input, _) = S::as_simd_f64s(&inputs[tap.input][index * width + tap.offset..][..width]);
                for (sum, value) in sums.iter_mut().zip(input) {
                    *sum = simd.add_f64s(*sum, simd.mul_f64s(weight, *value));
                }
            }
            out.copy_from_slice(&sums);
        }
        for tap in taps {
            for (y, u) in out[whole..].iter_mut().zip(&inputs[tap.input][whole + tap.offset..]) {
                *y += tap.weight * u;
            }
        }
    }
}

/// Adds to `out` the series whose first two values are `first` and `second` and whose second difference around every later one is in `bends`.
pub(super) fn add_bent([first, second]: [f64; 2], bends: &[f64], out: &mut [f64]) {
    let (mut value, mut slope) = (second, second - first);
    for (y, start) in out.iter_mut().zip([first, second]) {
        *y += start;
    }
    for (y, bend) in out.iter_mut().skip(2).zip(bends) {
        slope += bend;
        value += slope;
        *y += value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_output_is_the_plain_sum_to_the_last_bit() {
        let inputs: Vec<Vec<f64>> = (0..3).map(|j| (0..200).map(|i| (f64::from(i + j) * 0.7).sin()).collect()).collect();
        let inputs: Vec<&[f64]> = inputs.iter().map(Vec::as_slice).collect();
        let taps: Vec<Tap> = (0..9).map(|i| Tap { input: i % 3, offset: 7 * i % 11, weight: 1.0 / (3 + i) as f64 }).collect();
        for outputs in [0, 1, 31, 64, 153] {
            let mut out = vec![0.1; outputs];
            add_taps(&taps, &inputs, &mut out);
            for (k, found) in out.into_iter().enumerate() {
                let plain = taps.iter().fold(0.1, |sum, tap| sum + tap.weight * inputs[tap.input][k + tap.offset]);
                assert_eq!(found, plain, "{outputs} outputs");
            }
        }
    }
}
