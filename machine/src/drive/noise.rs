//! Random processes of a run.

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// A stationary Ornstein-Uhlenbeck process: `⟨n(t) n(t+τ)⟩ = std² exp(−|τ|/time)`, stepped exactly.
#[derive(Debug, Clone)]
pub(super) struct Coloured {
    value: f64,
    keep: f64,
    kick: f64,
}

impl Coloured {
    /// A process of standard deviation `std`, started in its stationary state. Zero, and without a
    /// draw, if `std` is 0.
    pub(super) fn new(std: f64, time_s: f64, step_s: f64, rng: &mut ChaCha8Rng) -> Self {
        let keep = (-step_s / time_s).exp();
        Self { value: if std > 0.0 { std * normal(rng) } else { 0.0 }, keep, kick: std * (1.0 - keep * keep).sqrt() }
    }

    /// The value one step later.
    pub(super) fn step(&mut self, rng: &mut ChaCha8Rng) -> f64 {
        if self.kick > 0.0 {
            self.value = self.keep * self.value + self.kick * normal(rng);
        }
        self.value
    }
}

/// A sample of N(0, 1).
pub(super) fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::rand_core::SeedableRng;

    #[test]
    fn spread_and_correlation_time_match_the_settings() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let (std, steps) = (2.0, 400_000);
        let mut process = Coloured::new(std, 0.010, 0.001, &mut rng);
        let values: Vec<f64> = (0..steps).map(|_| process.step(&mut rng)).collect();
        let moment = |lag: usize| values.iter().zip(&values[lag..]).map(|(a, b)| a * b).sum::<f64>() / (steps - lag) as f64;
        assert!((moment(0).sqrt() - std).abs() < 0.05, "{}", moment(0).sqrt());
        assert!((moment(10) / moment(0) - (-1.0_f64).exp()).abs() < 0.03);
    }
}
