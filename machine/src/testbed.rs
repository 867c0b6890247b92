//! Paper E's testbed: two linear axes under feedback, without friction or backlash.
//!
//! The paper prints the orders of plant and controller (eq. 19-20) but no coefficients. Those here are of the same orders, with a
//! lightly damped pair of poles and zeros near 17 Hz and another near 60 Hz, and stabilised with a bandwidth of about 30 Hz.

use motion::{Axis, Trajectory};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

use crate::{Machine, MachineError};

/// Plant `P(z) = K(z + α₁)(z² − α₂z + α₃)(z² − α₄z + α₅) / ((z − β₁)(z − 1)(z² − β₂z + β₃)(z² − β₄z + β₅))` (eq. 19) and controller
/// `k_p(z) = k Π(z − αᵢ)/(z − βᵢ)` (eq. 20).
#[derive(Debug, Clone, Copy)]
struct Coefficients {
    gain: f64,
    zeros: [f64; 5],
    poles: [f64; 5],
    controller_gain: f64,
    controller_zeros: [f64; 3],
    controller_poles: [f64; 3],
}

const X: Coefficients = Coefficients {
    gain: 8.5e-4,
    zeros: [0.95, 1.98, 0.991, 1.87, 0.972],
    poles: [0.999, 1.977, 0.989, 1.74, 0.87],
    controller_gain: 40.0,
    controller_zeros: [0.99, 0.96, 0.95],
    controller_poles: [0.999, 0.8, 0.8],
};

const Y: Coefficients = Coefficients {
    gain: 1.1e-3,
    zeros: [0.94, 1.975, 0.987, 1.86, 0.965],
    poles: [0.9988, 1.971, 0.9845, 1.7, 0.84],
    controller_gain: 28.0,
    controller_zeros: [0.99, 0.96, 0.95],
    controller_poles: [0.999, 0.8, 0.8],
};

/// Paper E's two axes. Every run starts at rest at zero, whatever the reference's first sample: a shift of that one is followed like any other.
#[derive(Debug)]
pub struct Testbed {
    /// Standard deviation of the noise that is added to every sample of a run, mm.
    noise_mm: f64,
    random: ChaCha8Rng,
}

impl Testbed {
    /// Sampling period, s.
    pub const PERIOD_S: f64 = 1e-3;

    /// The testbed with measuring noise of this standard deviation, mm.
    #[must_use]
    pub fn new(noise_mm: f64, seed: u64) -> Self {
        Self { noise_mm, random: ChaCha8Rng::seed_from_u64(seed) }
    }

    /// Axes of its references, X and Y.
    #[must_use]
    pub fn axes() -> Vec<Axis> {
        vec![Axis::named("x"), Axis::named("y")]
    }

    /// Impulse responses of both axes from reference to position, without noise, over `samples` samples.
    #[must_use]
    pub fn responses(samples: usize) -> [Vec<f64>; 2] {
        let mut impulse = vec![0.0; samples];
        if let Some(first) = impulse.first_mut() {
            *first = 1.0;
        }
        [&X, &Y].map(|axis| closed_loop(axis, &impulse))
    }
}

impl Machine for Testbed {
    fn run(&mut self, reference: &Trajectory) -> Result<Trajectory, MachineError> {
        if reference.axes() != Self::axes() || reference.period_s() != Self::PERIOD_S {
            return Err(MachineError::Misfit(format!("the testbed has the axes x and y and a period of {} s", Self::PERIOD_S)));
        }
        let columns = reference.columns().iter().zip([&X, &Y]).map(|(column, axis)| {
            let noise = |random: &mut ChaCha8Rng| -> f64 { StandardNormal.sample(random) };
            closed_loop(axis, column).iter().map(|y| y + self.noise_mm * noise(&mut self.random)).collect()
        });
        Ok(reference.with_columns(columns.collect())?)
    }
}

/// Position of an axis at rest that is given this reference.
fn closed_loop(of: &Coefficients, reference: &[f64]) -> Vec<f64> {
    let [a1, a2, a3, a4, a5] = of.zeros;
    let [b1, b2, b3, b4, b5] = of.poles;
    let mut plant = [
        Section::new([0.0, of.gain, of.gain * a1], [-(b1 + 1.0), b1]),
        Section::new([1.0, -a2, a3], [-b2, b3]),
        Section::new([1.0, -a4, a5], [-b4, b5]),
    ];
    let lead = |i: usize| Section::new([1.0, -of.controller_zeros[i], 0.0], [-of.controller_poles[i], 0.0]);
    let mut controller = [lead(0), lead(1), lead(2)];
    let position = |reference: &f64| {
        // The first section of the plant passes nothing at once, so the position is known before the input.
        let position = plant.iter().fold(0.0, |input, section| section.output(input));
        let effort =
            controller.iter_mut().fold(of.controller_gain * (reference - position), |input, section| section.step(input));
        plant.iter_mut().fold(effort, |input, section| section.step(input));
        position
    };
    reference.iter().map(position).collect()
}

/// `(b₀ + b₁z⁻¹ + b₂z⁻²)/(1 + a₁z⁻¹ + a₂z⁻²)`, transposed direct form II.
#[derive(Debug)]
struct Section {
    b: [f64; 3],
    a: [f64; 2],
    state: [f64; 2],
}

impl Section {
    fn new(b: [f64; 3], a: [f64; 2]) -> Self {
        Self { b, a, state: [0.0; 2] }
    }

    /// Output for this input, which does not change the state.
    fn output(&self, input: f64) -> f64 {
        self.b[0] * input + self.state[0]
    }

    fn step(&mut self, input: f64) -> f64 {
        let output = self.output(input);
        self.state = [self.b[1] * input - self.a[0] * output + self.state[1], self.b[2] * input - self.a[1] * output];
        output
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_followed_without_steady_error() {
        for axis in [&X, &Y] {
            let answer = closed_loop(axis, &[1.0; 3000]);
            assert!(answer.iter().all(|y| y.abs() < 1.5), "{axis:?}");
            assert!((answer[2999] - 1.0).abs() < 1e-6, "{}", answer[2999]);
        }
    }

    #[test]
    fn runs_are_the_convolution_with_the_responses() {
        let column: Vec<f64> = (0..200).map(|k| (f64::from(k) * 0.1).sin()).collect();
        let reference = Trajectory::new(Testbed::PERIOD_S, Testbed::axes(), vec![column.clone(); 2]).unwrap();
        let run = Testbed::new(0.0, 1).run(&reference).unwrap();
        for (response, actual) in Testbed::responses(200).iter().zip(run.columns()) {
            for (k, actual) in actual.iter().enumerate() {
                let sum: f64 = (0..=k).map(|lag| response[lag] * column[k - lag]).sum();
                assert!((sum - actual).abs() < 1e-9, "{k}: {sum} {actual}");
            }
        }
        assert!(Testbed::new(0.0, 1).run(&Trajectory::new(0.002, Testbed::axes(), vec![vec![0.0]; 2]).unwrap()).is_err());
    }

    #[test]
    fn noise_follows_the_seed() {
        let reference = Trajectory::new(Testbed::PERIOD_S, Testbed::axes(), vec![vec![0.0; 500]; 2]).unwrap();
        let spread = |seed| {
            let run = Testbed::new(1e-3, seed).run(&reference).unwrap().into_columns().concat();
            (run.iter().map(|y| y * y).sum::<f64>() / run.len() as f64).sqrt()
        };
        assert!((spread(1) - 1e-3).abs() < 1e-4, "{}", spread(1));
        assert_ne!(spread(1), spread(2));
    }
}
