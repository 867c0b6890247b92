//! Truncated Taylor series: a value and its first three derivatives, propagated through a formula.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// `[f, f′, f″, f‴]` of a function of one parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jet(pub [f64; 4]);

impl Jet {
    /// The parameter itself at `u`.
    #[must_use]
    pub fn variable(u: f64) -> Self {
        Self([u, 1.0, 0.0, 0.0])
    }

    /// A constant.
    #[must_use]
    pub fn constant(value: f64) -> Self {
        Self([value, 0.0, 0.0, 0.0])
    }

    /// `g(f)` from `g` and its derivatives at `f`, by Faà di Bruno's formula.
    fn compose(self, g: [f64; 4]) -> Self {
        let [_, a, b, c] = self.0;
        Self([g[0], g[1] * a, g[2] * a * a + g[1] * b, g[3] * a * a * a + 3.0 * g[2] * a * b + g[1] * c])
    }

    /// Sine.
    #[must_use]
    pub fn sin(self) -> Self {
        let (s, c) = self.0[0].sin_cos();
        self.compose([s, c, -s, -c])
    }

    /// Cosine.
    #[must_use]
    pub fn cos(self) -> Self {
        let (s, c) = self.0[0].sin_cos();
        self.compose([c, -s, -c, s])
    }

    /// Reciprocal. Infinite if the value is zero.
    #[must_use]
    pub fn recip(self) -> Self {
        let r = 1.0 / self.0[0];
        self.compose([r, -r * r, 2.0 * r * r * r, -6.0 * r * r * r * r])
    }
}

impl Add for Jet {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }
}

impl Sub for Jet {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Neg for Jet {
    type Output = Self;
    fn neg(self) -> Self {
        self * -1.0
    }
}

impl Mul for Jet {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let ([a, a1, a2, a3], [b, b1, b2, b3]) = (self.0, other.0);
        Self([a * b, a1 * b + a * b1, a2 * b + 2.0 * a1 * b1 + a * b2, a3 * b + 3.0 * (a2 * b1 + a1 * b2) + a * b3])
    }
}

impl Mul<f64> for Jet {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Self(self.0.map(|value| value * factor))
    }
}

impl Add<f64> for Jet {
    type Output = Self;
    fn add(self, value: f64) -> Self {
        self + Self::constant(value)
    }
}

impl Div for Jet {
    type Output = Self;
    // A quotient is the product with a reciprocal.
    #[allow(clippy::suspicious_arithmetic_impl)]
    fn div(self, other: Self) -> Self {
        self * other.recip()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_agree_with_differences() {
        let f = |u: Jet| (u * 2.0).sin() * u / (u.cos() * 0.3 + 1.5);
        let (u, h) = (0.7, 1e-3);
        let jet = f(Jet::variable(u)).0;
        let value = |u: f64| f(Jet::variable(u)).0;
        for (order, derivative) in jet.into_iter().enumerate().skip(1) {
            let numeric = (value(u + h)[order - 1] - value(u - h)[order - 1]) / (2.0 * h);
            assert!((numeric - derivative).abs() < 1e-4, "order {order}: {numeric} {derivative}");
        }
    }
}
