//! Sigmoid and tanh on vectors, to better than 6e-7 absolute.
//!
//! Both use one exponential and one reciprocal; several reciprocals share one division, the slow
//! operation.

use pulp::Simd;

/// Limit of the exponents of two: beyond it neither function changes by more than 4e-9, and
/// products of four denominators stay finite.
const LIMIT: f32 = 28.0;

/// `1 + e^(s·x)`: `e^(s·x) = 2ⁿ·2^r` with `n` the integer nearest to the exponent, clamped to [`LIMIT`], and a polynomial in
/// `|r| ≤ 1/2`, whose coefficients keep the relative error below 1.1e-7.
#[inline(always)]
fn denominator<S: Simd>(simd: S, x: S::f32s, s: f32) -> S::f32s {
    // Adding 1.5·2²³ rounds to an integer; the additional 127 leaves the exponent bias in the low
    // bits.
    const ROUND: f32 = 12_582_912.0 + 127.0;
    let splat = |value| simd.splat_f32s(value);
    let exponent = simd.mul_f32s(x, splat(s * std::f32::consts::LOG2_E));
    let exponent = simd.max_f32s(simd.min_f32s(exponent, splat(LIMIT)), splat(-LIMIT));
    let shifted = simd.add_f32s(exponent, splat(ROUND));
    let r = simd.sub_f32s(exponent, simd.sub_f32s(shifted, splat(ROUND)));
    let mut sum = splat(0.001_330_035_5);
    for coefficient in [0.009_669_661, 0.055_505_59, 0.240_222_83, std::f32::consts::LN_2, 1.0] {
        sum = simd.mul_add_e_f32s(sum, r, splat(coefficient));
    }
    let power = simd.wrapping_dyn_shl_u32s(simd.transmute_u32s_f32s(shifted), simd.splat_u32s(23));
    simd.mul_add_e_f32s(sum, simd.transmute_f32s_u32s(power), splat(1.0))
}

/// `1/a` and `1/b` with one division.
#[inline(always)]
fn reciprocals<S: Simd>(simd: S, a: S::f32s, b: S::f32s) -> (S::f32s, S::f32s) {
    let both = simd.div_f32s(simd.splat_f32s(1.0), simd.mul_f32s(a, b));
    (simd.mul_f32s(both, b), simd.mul_f32s(both, a))
}

/// `1 − 2·x`: gives tanh from the reciprocal of its denominator.
#[inline(always)]
fn one_minus_twice<S: Simd>(simd: S, x: S::f32s) -> S::f32s {
    simd.mul_add_e_f32s(x, simd.splat_f32s(-2.0), simd.splat_f32s(1.0))
}

/// `σ(x)` and `σ(y)`, `σ(x) = 1/(1 + e⁻ˣ)`.
#[inline(always)]
pub(crate) fn sigmoids<S: Simd>(simd: S, x: S::f32s, y: S::f32s) -> (S::f32s, S::f32s) {
    reciprocals(simd, denominator(simd, x, -1.0), denominator(simd, y, -1.0))
}

/// `σ` of the first, second and fourth, and `tanh` of the third: an LSTM's gates, with one division.
#[inline(always)]
pub(crate) fn gates<S: Simd>(simd: S, [i, f, g, o]: [S::f32s; 4]) -> [S::f32s; 4] {
    let (i, f) = (denominator(simd, i, -1.0), denominator(simd, f, -1.0));
    let (g, o) = (denominator(simd, g, 2.0), denominator(simd, o, -1.0));
    let (first, second) = reciprocals(simd, simd.mul_f32s(i, f), simd.mul_f32s(g, o));
    let tanh = one_minus_twice(simd, simd.mul_f32s(second, o));
    [simd.mul_f32s(first, f), simd.mul_f32s(first, i), tanh, simd.mul_f32s(second, g)]
}

/// `tanh x = 1 − 2/(1 + e²ˣ)`.
#[inline(always)]
pub(crate) fn tanh<S: Simd>(simd: S, x: S::f32s) -> S::f32s {
    let inverse = simd.div_f32s(simd.splat_f32s(1.0), denominator(simd, x, 2.0));
    one_minus_twice(simd, inverse)
}

#[cfg(test)]
mod tests {
    use super::super::level::Level;
    use super::*;
    use pulp::WithSimd;

    struct All<'a>(&'a [f32], &'a mut [[f32; 3]]);

    impl WithSimd for All<'_> {
        type Output = ();
        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            for (&x, out) in self.0.iter().zip(self.1) {
                let v = simd.splat_f32s(x);
                let mut first = [0.0];
                simd.partial_store_f32s(&mut first, tanh(simd, v));
                out[0] = first[0];
                let [_, s, t, _] = gates(simd, [v; 4]);
                simd.partial_store_f32s(&mut first, t);
                out[1] = first[0];
                simd.partial_store_f32s(&mut first, s);
                out[2] = first[0];
            }
        }
    }

    #[test]
    fn close_to_the_exact_functions_everywhere() {
        let x: Vec<f32> = (-400_000..=400_000).map(|i| i as f32 * 1e-4).chain([-1e30, 1e30, 0.0]).collect();
        for level in [Level::detect(), Level::portable()] {
            let mut y = vec![[0.0; 3]; x.len()];
            level.run(All(&x, &mut y));
            let worst = x.iter().zip(&y).fold(0.0_f64, |worst, (&x, y)| {
                let x = f64::from(x);
                let sigmoid = 1.0 / (1.0 + (-x).exp());
                worst
                    .max((f64::from(y[0]) - x.tanh()).abs())
                    .max((f64::from(y[1]) - x.tanh()).abs())
                    .max((f64::from(y[2]) - sigmoid).abs())
            });
            println!("{} lanes: worst {worst:.2e}", level.lanes());
            assert!(worst < 6e-7, "{worst}");
        }
    }
}
