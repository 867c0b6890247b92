//! Impulse responses: from a shift of the reference to the actual position.

use nalgebra::{DMatrix, DVector};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use machine::Machine;
use motion::{AxisKind, Trajectory};

use crate::CompensationError;

/// Response of one axis's position to a unit shift of its reference at one sample; causal.
#[derive(Debug, Clone, PartialEq)]
pub struct ImpulseResponse {
    taps: Vec<f64>,
}

/// Taps at the end whose sum is below this share of the static gain are dropped.
const NEGLIGIBLE: f64 = 1e-9;
/// Ridge of the identification, as a share of the probe's energy: it acts only on a probe with
/// little excitation.
const RIDGE: f64 = 1e-9;

/// RMS of a model's probe, mm: larger than backlash and presliding of most machines, within the
/// capability of motors.
const MODEL_PROBE_MM: f64 = 0.01;
/// Ridge of a model's response at its first and last tap, as a share of the probe's energy: late
/// taps need evidence in the data.
const MODEL_RIDGE: [f64; 2] = [1e-6, 1e-2];

/// Largest difference of the static gain of an axis that follows its command from 1. A probe that friction absorbs, or that a model of friction
/// answers at random, has another: 1.33 and −1.08 were found of a position loop without integrator whose friction deflects it by 40 µm.
const FOLLOWS: f64 = 0.25;

/// A ridge that grows exponentially over the taps.
fn decaying(taps: usize) -> Vec<f64> {
    let [first, last] = MODEL_RIDGE;
    (0..taps).map(|i| first * (last / first).powf(i as f64 / taps as f64)).collect()
}

/// Lever arm that converts a shift in mm to an angle, mm.
const LEVER_MM: f64 = 100.0;

impl ImpulseResponse {
    /// A response with the given taps, the first one without delay.
    ///
    /// # Errors
    /// When there is no tap, or one is not a number.
    pub fn new(mut taps: Vec<f64>) -> Result<Self, CompensationError> {
        if taps.is_empty() || taps.iter().any(|tap| !tap.is_finite()) {
            return Err(CompensationError::BadSetting {
                name: "number of usable taps of an impulse response",
                value: 0.0,
                remedy: "identify the response from a log in which the axis moves",
            });
        }
        let total: f64 = taps.iter().map(|tap| tap.abs()).sum();
        let mut tail = 0.0;
        while taps.len() > 1 {
            tail += taps[taps.len() - 1].abs();
            if tail > NEGLIGIBLE * total {
                break;
            }
            taps.pop();
        }
        Ok(Self { taps })
    }

    /// Least-squares response from `input` to `output`. Both start from zero (differences of two
    /// runs, or increments of reference and actual position of one).
    ///
    /// # Errors
    /// When the input does not excite that many taps, or the lengths differ.
    pub fn identify(input: &[f64], output: &[f64], taps: usize) -> Result<Self, CompensationError> {
        Self::identify_with(input, output, taps, &vec![RIDGE; taps])
    }

    /// As [`ImpulseResponse::identify`], with a ridge for each tap, as a share of the input's energy.
    fn identify_with(input: &[f64], output: &[f64], taps: usize, ridge: &[f64]) -> Result<Self, CompensationError> {
        let unusable = |value: f64| CompensationError::BadSetting {
            name: "samples from which an impulse response is identified",
            value,
            remedy: "give as many outputs as inputs, several times as many as taps, and let the axis move",
        };
        let samples = input.len();
        if samples != output.len() || taps == 0 || samples < 2 * taps {
            return Err(unusable(samples as f64));
        }
        // Correlations of the input with itself and with the output, over all rows: normal
        // equations of the delayed inputs.
        let at = |k: usize, lag: usize| if k >= lag { input[k - lag] } else { 0.0 };
        let mut normal = DMatrix::zeros(taps, taps);
        for column in 0..taps {
            // Along a diagonal each entry loses the last row of the previous one.
            let mut sum: f64 = (0..samples).map(|k| at(k, 0) * at(k, column)).sum();
            for row in 0..taps - column {
                normal[(row, row + column)] = sum;
                normal[(row + column, row)] = sum;
                let last = samples - 1 - row;
                sum -= input[last] * at(last, column);
            }
        }
        let energy = normal[(0, 0)];
        if energy <= 0.0 {
            return Err(unusable(samples as f64));
        }
        for i in 0..taps {
            normal[(i, i)] += ridge[i] * energy;
        }
        let right = DVector::from_fn(taps, |lag, _| (lag..samples).map(|k| input[k - lag] * output[k]).sum::<f64>());
        let solved = normal.cholesky().map(|factor| factor.solve(&right)).ok_or_else(|| unusable(samples as f64))?;
        Self::new(solved.iter().copied().collect())
    }

    /// The responses of all axes of a machine, real or learned: from runs on `path` with and
    /// without small pseudo-random shifts of `amplitude_mm`, on rotary axes at a lever of 100 mm.
    /// The motion avoids that static friction absorbs the shifts.
    ///
    /// # Errors
    /// When the machine does not run, or the path is shorter than twice `memory_s`, the duration of
    /// a response.
    pub fn probe(
        machine: &mut dyn Machine,
        path: &Trajectory,
        amplitude_mm: f64,
        memory_s: f64,
    ) -> Result<Vec<Self>, CompensationError> {
        let taps = (memory_s / path.period_s()).ceil() as usize;
        // A fixed generator: the same machine and path give the same responses. Each axis has its
        // own stream.
        let mut state = 0x9E37_79B9_7F4A_7C15_u64;
        let mut sign = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            if state >> 63 == 0 { 1.0 } else { -1.0 }
        };
        let probes = path.axes().iter().zip(path.columns()).map(|(axis, column)| {
            let amplitude = if axis.kind == AxisKind::Rotary { amplitude_mm / LEVER_MM } else { amplitude_mm };
            column.iter().map(|_| amplitude * sign()).collect()
        });
        let probes: Vec<Vec<f64>> = probes.collect();
        let probed = path.columns().iter().zip(&probes);
        let probed = path.with_columns(probed.map(|(x, u)| x.iter().zip(u).map(|(x, u)| x + u).collect()).collect())?;
        let (without, with) = (machine.run(path)?, machine.run(&probed)?);
        let answers = with.columns().iter().zip(without.columns());
        probes
            .iter()
            .zip(answers)
            .map(|(probe, (with, without))| {
                let answer: Vec<f64> = with.iter().zip(without).map(|(with, without)| with - without).collect();
                Self::identify(probe, &answer, taps)
            })
            .collect()
    }

    /// As [`ImpulseResponse::probe`], for a model without noise: shifts of every duration from one
    /// sample to the memory, so that slow and fast responses are excited, and a prior of smooth
    /// decay ("tuned/correlated" kernel; Chen, Ohlsson and Ljung 2012).
    ///
    /// # Errors
    /// As [`ImpulseResponse::probe`].
    pub fn probe_model(machine: &mut dyn Machine, path: &Trajectory, memory_s: f64) -> Result<Vec<Self>, CompensationError> {
        let without = machine.run(path)?;
        Self::probe_model_beside(machine, path, &without, memory_s)
    }

    /// As [`ImpulseResponse::probe_model`], where `without` is the run of `path`.
    ///
    /// # Errors
    /// As [`ImpulseResponse::probe`].
    pub fn probe_model_beside(
        machine: &mut dyn Machine,
        path: &Trajectory,
        without: &Trajectory,
        memory_s: f64,
    ) -> Result<Vec<Self>, CompensationError> {
        let taps = ((memory_s / path.period_s()).ceil() as usize).clamp(1, (path.len() / 4).max(1));
        let octaves = taps.ilog2() + 1;
        let mut state = 0x9E37_79B9_7F4A_7C15_u64;
        let mut sign = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            if state >> 63 == 0 { 1.0 } else { -1.0 }
        };
        let mut probe = |axis: &motion::Axis| -> Vec<f64> {
            let lever = if axis.kind == AxisKind::Rotary { LEVER_MM } else { 1.0 };
            let mut signs = vec![0.0; octaves as usize];
            let mut sum = |k: usize| {
                for (octave, value) in signs.iter_mut().enumerate() {
                    if k.is_multiple_of(1 << octave) {
                        *value = sign();
                    }
                }
                signs.iter().sum::<f64>() * MODEL_PROBE_MM / lever / f64::from(octaves).sqrt()
            };
            (0..path.len()).map(&mut sum).collect()
        };
        let probes: Vec<Vec<f64>> = path.axes().iter().map(&mut probe).collect();
        let probed = path.columns().iter().zip(&probes);
        let probed = path.with_columns(probed.map(|(x, u)| x.iter().zip(u).map(|(x, u)| x + u).collect()).collect())?;
        let with = machine.run(&probed)?;
        let answers = with.columns().iter().zip(without.columns());
        let found = probes.par_iter().zip(answers.collect::<Vec<_>>()).map(|(probe, (with, without))| {
            let answer: Vec<f64> = with.iter().zip(without).map(|(with, without)| with - without).collect();
            Ok(Self::identify_with(probe, &answer, taps, &decaying(taps))?.shortened())
        });
        found.collect()
    }

    /// The responses that a run of `path` shows by its motion alone, from increments of command and actual position, with the prior of
    /// [`ImpulseResponse::probe_model`]; `None` for an axis that does not move. They hold what friction takes from the motion and gives back, and nothing
    /// of frequencies that the motion does not have.
    #[must_use]
    pub fn of_motion(path: &Trajectory, run: &Trajectory, memory_s: f64) -> Vec<Option<Self>> {
        let taps = ((memory_s / path.period_s()).ceil() as usize).clamp(1, (path.len() / 4).max(1));
        let increments = |column: &Vec<f64>| -> Vec<f64> { column.windows(2).map(|pair| pair[1] - pair[0]).collect() };
        let axes: Vec<_> = path.columns().iter().zip(run.columns()).collect();
        let found = axes.into_par_iter().map(|(path, run)| {
            Some(Self::identify_with(&increments(path), &increments(run), taps, &decaying(taps)).ok()?.shortened())
        });
        found.collect()
    }

    /// Whether the static gain is near 1, as it is where an axis follows its command.
    #[must_use]
    pub fn follows(&self) -> bool {
        (self.static_gain() - 1.0).abs() <= FOLLOWS
    }

    /// Drops the taps at the end whose sum is below a hundredth of the total.
    fn shortened(mut self) -> Self {
        let total: f64 = self.taps.iter().map(|tap| tap.abs()).sum();
        let mut tail = 0.0;
        while self.taps.len() > 1 {
            tail += self.taps[self.taps.len() - 1].abs();
            if tail > 0.01 * total {
                break;
            }
            self.taps.pop();
        }
        self
    }

    /// The taps.
    #[must_use]
    pub fn taps(&self) -> &[f64] {
        &self.taps
    }

    /// Position after a constant shift of 1.
    #[must_use]
    pub fn static_gain(&self) -> f64 {
        self.taps.iter().sum()
    }

    /// Delay of a slow motion, samples: the first moment of the response over its static gain; 0 if
    /// that is not positive.
    #[must_use]
    pub fn delay_samples(&self) -> f64 {
        let gain = self.static_gain();
        let moment: f64 = self.taps.iter().enumerate().map(|(lag, tap)| lag as f64 * tap).sum();
        if gain > 0.0 { (moment / gain).max(0.0) } else { 0.0 }
    }

    /// Samples after a step until the response stays within the share `within` of its static gain.
    #[must_use]
    pub fn settled_samples(&self, within: f64) -> usize {
        let gain = self.static_gain();
        let mut left = 0.0;
        let leaves = |tap: &f64| {
            left += tap;
            left.abs() > within * gain.abs()
        };
        self.taps.len() - self.taps.iter().rev().position(leaves).unwrap_or(self.taps.len())
    }

    /// `y = P·u`: the filter.
    pub fn apply(&self, u: &[f64], y: &mut [f64]) {
        let before = self.taps.len() - 1;
        let reversed: Vec<f64> = self.taps.iter().rev().copied().collect();
        slide(&reversed, u, before, y);
    }

    /// `y = Pᵀ·u`: the filter run backwards in time.
    pub fn apply_transposed(&self, u: &[f64], y: &mut [f64]) {
        slide(&self.taps, u, 0, y);
    }
}

/// Outputs per block: they and their inputs stay in the first-level cache.
const BLOCK: usize = 512;
/// Taps that are summed in one pass over a block.
const TOGETHER: usize = 8;

/// `y(k) = Σ taps(i)·u(k + i − before)`, with zeros outside of `u`, with the widest vectors of the processor. Every term is rounded on its
/// own: the same bits at every width.
fn slide(taps: &[f64], u: &[f64], before: usize, y: &mut [f64]) {
    Arch::new().dispatch(Slide { taps, u, before, y });
}

struct Slide<'a> {
    taps: &'a [f64],
    u: &'a [f64],
    before: usize,
    y: &'a mut [f64],
}

impl WithSimd for Slide<'_> {
    type Output = ();

    // A closure would not be compiled for the wider vectors: it is not always inlined.
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        slide_blocks(self.taps, self.u, self.before, self.y);
    }
}

#[inline(always)]
fn slide_blocks(taps: &[f64], u: &[f64], before: usize, y: &mut [f64]) {
    let count = taps.len().next_multiple_of(TOGETHER);
    let mut padded_taps = taps.to_vec();
    padded_taps.resize(count, 0.0);
    let mut window = vec![0.0; BLOCK + count];
    for (block, y) in y.chunks_mut(BLOCK).enumerate() {
        let start = block * BLOCK;
        for (slot, k) in window.iter_mut().zip(start..) {
            *slot = if k >= before { u.get(k - before).copied().unwrap_or(0.0) } else { 0.0 };
        }
        y.fill(0.0);
        for (index, taps) in padded_taps.as_chunks::<TOGETHER>().0.iter().enumerate() {
            let window = &window[index * TOGETHER..][..y.len() + TOGETHER - 1];
            for (y, u) in y.iter_mut().zip(window.array_windows::<TOGETHER>()) {
                let mut sum = *y;
                for i in 0..TOGETHER {
                    sum += taps[i] * u[i];
                }
                *y = sum;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_response_of_a_known_filter_is_found() {
        let truth = ImpulseResponse::new((0..30).map(|k| 0.3 * 0.7_f64.powi(k)).collect()).unwrap();
        let mut state = 1_u64;
        let input: Vec<f64> = (0..500)
            .map(|_| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                (state >> 40) as f64 / f64::from(1 << 24) - 0.5
            })
            .collect();
        let mut output = vec![0.0; 500];
        truth.apply(&input, &mut output);
        let found = ImpulseResponse::identify(&input, &output, 40).unwrap();
        for (found, truth) in found.taps().iter().zip(truth.taps()) {
            assert!((found - truth).abs() < 1e-6, "{found} {truth}");
        }
        assert!((found.static_gain() - truth.static_gain()).abs() < 1e-6);
        assert!(ImpulseResponse::identify(&[0.0; 100], &[0.0; 100], 10).is_err());
        assert!(ImpulseResponse::identify(&[1.0; 10], &[1.0; 10], 10).is_err());
    }

    /// A first-order lag of ten samples that answers to small shifts at random: to each with another turn of a wave of 3 µm.
    struct Scattering;

    impl Machine for Scattering {
        fn run(&mut self, reference: &Trajectory) -> Result<Trajectory, machine::MachineError> {
            let follow = |column: &Vec<f64>| {
                let mut position = column[0];
                let next = |target: &f64| {
                    position += 0.1 * (target - position);
                    position + 0.4 * (std::f64::consts::TAU * target / 0.003).sin()
                };
                column.iter().map(next).collect()
            };
            Ok(reference.with_columns(reference.columns().iter().map(follow).collect())?)
        }
    }

    #[test]
    fn the_motion_shows_a_response_that_scatters_every_probe() {
        let wave = |k: usize| 400.0 * (k as f64 * 0.004).sin();
        let path =
            Trajectory::new(0.002, motion::Axis::xyz(), vec![(0..3000).map(wave).collect(), vec![0.0; 3000], vec![0.0; 3000]]);
        let path = path.unwrap();
        let run = Scattering.run(&path).unwrap();
        let probed = ImpulseResponse::probe_model_beside(&mut Scattering, &path, &run, 0.4).unwrap();
        assert!(!probed[0].follows(), "{}", probed[0].static_gain());
        let moved = ImpulseResponse::of_motion(&path, &run, 0.4);
        assert!(moved[1].is_none());
        let moved = moved[0].as_ref().unwrap();
        assert!(
            moved.follows() && (moved.delay_samples() - 9.0).abs() < 2.0,
            "{} {}",
            moved.static_gain(),
            moved.delay_samples()
        );
    }

    #[test]
    fn a_response_settles_within_a_share_of_its_gain() {
        // After n samples 0.5^n of the step is left.
        let response = ImpulseResponse::new((1..=20).map(|k| 0.5_f64.powi(k)).collect()).unwrap();
        assert_eq!([0.6, 0.3, 0.02].map(|within| response.settled_samples(within)), [1, 2, 6]);
        // One that passes its end and comes back is not settled before it does.
        let overshooting = ImpulseResponse::new(vec![0.5, 0.7, -0.3, 0.1]).unwrap();
        assert_eq!([0.3, 0.05].map(|within| overshooting.settled_samples(within)), [2, 4]);
        assert_eq!(ImpulseResponse::new(vec![1.0]).unwrap().settled_samples(0.02), 1);
    }

    #[test]
    fn the_transposed_filter_is_the_adjoint() {
        let response = ImpulseResponse::new(vec![0.1, 0.5, 0.3, -0.2]).unwrap();
        let u: Vec<f64> = (0..20).map(|k| f64::from(k).sin()).collect();
        let w: Vec<f64> = (0..20).map(|k| f64::from(k * k).cos()).collect();
        let (mut pu, mut ptw) = (vec![0.0; 20], vec![0.0; 20]);
        response.apply(&u, &mut pu);
        response.apply_transposed(&w, &mut ptw);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        assert!((dot(&pu, &w) - dot(&u, &ptw)).abs() < 1e-12);
    }
}
