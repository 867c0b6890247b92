//! Numbers of several models side by side, one per lane: plain code without branches, which the compiler turns into vectors.

use std::ops::{Add, AddAssign, Div, Mul, Sub};

/// One number per lane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lanes<const L: usize>(pub [f64; L]);

impl<const L: usize> Lanes<L> {
    /// The same number in every lane.
    #[inline(always)]
    pub fn all(value: f64) -> Self {
        Self([value; L])
    }

    /// The number that each lane gives.
    #[inline(always)]
    pub fn of(lane: impl FnMut(usize) -> f64) -> Self {
        Self(std::array::from_fn(lane))
    }

    /// A number of each item.
    pub fn each<T>(items: &[T; L], of: impl Fn(&T) -> f64) -> Self {
        Self::of(|lane| of(&items[lane]))
    }

    /// A function of each number.
    #[inline(always)]
    pub fn map(self, of: impl Fn(f64) -> f64) -> Self {
        Self::of(|lane| of(self.0[lane]))
    }

    #[inline(always)]
    fn with(self, other: Self, of: impl Fn(f64, f64) -> f64) -> Self {
        Self::of(|lane| of(self.0[lane], other.0[lane]))
    }

    /// Absolute values.
    #[inline(always)]
    pub fn abs(self) -> Self {
        self.map(f64::abs)
    }

    /// Square roots.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        self.map(f64::sqrt)
    }

    /// These magnitudes with the signs of others.
    #[inline(always)]
    pub fn copysign(self, signs: Self) -> Self {
        self.with(signs, f64::copysign)
    }

    /// The numbers, not below `-level` and not above `level`.
    #[inline(always)]
    pub fn within(self, level: Self) -> Self {
        self.with(level, |value, level| {
            let value = if value > level { level } else { value };
            if value < -level { -level } else { value }
        })
    }

    /// `yes` where these numbers are below `than`, `no` elsewhere.
    #[inline(always)]
    pub fn where_below(self, than: f64, yes: Self, no: Self) -> Self {
        Self::of(|lane| if self.0[lane] < than { yes.0[lane] } else { no.0[lane] })
    }

    /// `e⁻ˣ` to within 2e-16 relative for `x` from 0; from [`DECAYED`] on `e` to the minus that. `e⁻ˣ = 2ⁿ·eʳ` with a series in `|r| ≤ ½ ln 2`.
    #[inline(always)]
    pub fn decay(self) -> Self {
        self.map(decay)
    }
}

/// Exponent from which an exponential decays no further: far below the last digit of what it is added to.
pub const DECAYED: f64 = 50.0;

#[inline(always)]
fn decay(x: f64) -> f64 {
    // Adding 1.5·2⁵² rounds to an integer; the additional 1023 leaves the exponent's bias in the low bits.
    const ROUND: f64 = 6_755_399_441_055_744.0 + 1023.0;
    // ln 2 in two parts, the first with few enough digits that its products with integers are exact (Cody and Waite 1980).
    const LN_2: (f64, f64) = (0.693_145_751_953_125, 1.428_606_820_309_417_2e-6);
    const SERIES: [f64; 13] = {
        let mut series = [1.0; 13];
        let mut k = 1;
        while k < 13 {
            series[k] = series[k - 1] / k as f64;
            k += 1;
        }
        series
    };
    let x = if x < DECAYED { -x } else { -DECAYED };
    let shifted = x * std::f64::consts::LOG2_E + ROUND;
    let n = shifted - ROUND;
    let r = (x - n * LN_2.0) - n * LN_2.1;
    let pair = |k: usize| SERIES[k] + SERIES[k + 1] * r;
    let square = r * r;
    let fourth = square * square;
    let (low, middle) = (pair(0) + pair(2) * square, pair(4) + pair(6) * square);
    let high = pair(8) + pair(10) * square + SERIES[12] * fourth;
    let series = low + fourth * (middle + fourth * high);
    series * f64::from_bits(shifted.to_bits() << 52)
}

impl<const L: usize> Add for Lanes<L> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.with(other, |a, b| a + b)
    }
}

impl<const L: usize> Sub for Lanes<L> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.with(other, |a, b| a - b)
    }
}

impl<const L: usize> Mul for Lanes<L> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.with(other, |a, b| a * b)
    }
}

impl<const L: usize> Div for Lanes<L> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.with(other, |a, b| a / b)
    }
}

impl<const L: usize> Mul<f64> for Lanes<L> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        self.map(|value| value * factor)
    }
}

impl<const L: usize> AddAssign for Lanes<L> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponentials_decay_as_those_of_the_standard_library() {
        assert_eq!(decay(0.0), 1.0);
        let worst = (0..500_000).map(|k| f64::from(k) * 1e-4).map(|x| (decay(x) / (-x).exp() - 1.0).abs()).fold(0.0, f64::max);
        assert!(worst < 4.5e-16, "{worst}");
        assert!(decay(1e300) < 1e-21 && decay(f64::INFINITY) == decay(DECAYED) && decay(f64::NAN) < 1e-21);
    }

    #[test]
    fn numbers_stay_within_a_level() {
        assert_eq!(Lanes([-3.0, 0.5, 3.0]).within(Lanes([1.0, 1.0, 2.0])), Lanes([-1.0, 0.5, 2.0]));
    }
}
