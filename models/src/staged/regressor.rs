//! Regressors: the signals that act on the tracking error through a response of their own.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::phase::sin_cos_of;
use super::signals::{Scales, Signals};

/// The factor of a regressor that depends on the motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MotionFactor {
    /// The constant 1.
    One,
    /// Velocity of the reference.
    Velocity,
    /// Increment of the velocity.
    VelocityStep,
    /// Direction of motion, times the friction level if that depends on the position.
    Sign,
    /// A stop operator.
    Stop(usize),
    /// A stop operator less the direction of motion: zero in steady motion at any speed.
    StopLessSign(usize),
    /// A stop operator that fades with speed, `z·exp(−|v|/q)`: operator, then decay speed.
    SlowStop(usize, usize),
    /// Magnitude of a stop operator, which differs between the two directions.
    StopMagnitude(usize),
    /// Saturated viscous friction: proportional to the expected velocity up to a speed and constant beyond it, `v/q` within −1…1.
    #[serde(rename = "drag")]
    SaturatedViscous(usize),
    /// Backlash between the motor and the measured position: a stop operator whose contribution the
    /// motor does not feel, so that the next pass's expected position excludes it.
    #[serde(rename = "play")]
    Backlash(usize),
}

/// The factor of a regressor that depends on the position.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PositionFactor {
    /// Constant.
    Flat,
    /// `cos 2πfx` of a position harmonic.
    Cos(usize),
    /// `sin 2πfx` of a position harmonic.
    Sin(usize),
}

/// A motion factor times a position factor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Regressor {
    /// Motion factor.
    #[serde(rename = "carrier")]
    pub motion: MotionFactor,
    /// Position factor.
    #[serde(rename = "wave")]
    pub position: PositionFactor,
}

impl From<MotionFactor> for Regressor {
    fn from(motion: MotionFactor) -> Self {
        Self { motion, position: PositionFactor::Flat }
    }
}

impl Regressor {
    /// The motion factor times cosine and sine of `harmonic`.
    #[must_use]
    pub fn on_harmonic(motion: MotionFactor, harmonic: usize) -> [Self; 2] {
        [PositionFactor::Cos(harmonic), PositionFactor::Sin(harmonic)].map(|position| Self { motion, position })
    }

    /// The harmonic of this regressor, if any.
    #[must_use]
    pub fn harmonic(&self) -> Option<usize> {
        match self.position {
            PositionFactor::Flat => None,
            PositionFactor::Cos(harmonic) | PositionFactor::Sin(harmonic) => Some(harmonic),
        }
    }

    /// Whether `scales` has the operator, speed and harmonic of this regressor.
    pub(super) fn fits(&self, scales: &Scales) -> bool {
        let stops = scales.stop_half_widths.len();
        let motion = match self.motion {
            MotionFactor::One | MotionFactor::Velocity | MotionFactor::VelocityStep | MotionFactor::Sign => true,
            MotionFactor::Stop(stop)
            | MotionFactor::StopLessSign(stop)
            | MotionFactor::StopMagnitude(stop)
            | MotionFactor::Backlash(stop) => stop < stops,
            MotionFactor::SlowStop(stop, speed) => stop < stops && speed < scales.slow_speeds.len(),
            MotionFactor::SaturatedViscous(speed) => speed < scales.drag_speeds.len(),
        };
        motion && self.harmonic().is_none_or(|harmonic| harmonic < scales.lines.len())
    }

    /// The stored signal that equals this regressor over all padded samples, if there is one.
    pub(super) fn signal<'a>(&self, signals: &'a Signals) -> Option<&'a [f64]> {
        match (self.motion, self.position) {
            (MotionFactor::Velocity, PositionFactor::Flat) => Some(signals.velocity()),
            (MotionFactor::VelocityStep, PositionFactor::Flat) => Some(signals.step()),
            (MotionFactor::Sign, PositionFactor::Flat) => Some(signals.friction_sign()),
            (MotionFactor::Stop(stop) | MotionFactor::Backlash(stop), PositionFactor::Flat) => Some(signals.stop(stop)),
            (MotionFactor::SaturatedViscous(speed), PositionFactor::Flat) => Some(signals.saturated_viscous(speed)),
            _ => None,
        }
    }

    /// Writes the regressor's values at the padded samples `start..start + out.len()` to `out`.
    pub fn fill(&self, signals: &Signals, harmonics: &Harmonics, start: usize, out: &mut [f64]) {
        let rows = start..start + out.len();
        match self.motion {
            MotionFactor::One => out.fill(1.0),
            MotionFactor::Velocity => out.copy_from_slice(&signals.velocity()[rows.clone()]),
            MotionFactor::VelocityStep => out.copy_from_slice(&signals.step()[rows.clone()]),
            MotionFactor::Sign => out.copy_from_slice(&signals.friction_sign()[rows.clone()]),
            MotionFactor::Stop(stop) | MotionFactor::Backlash(stop) => out.copy_from_slice(&signals.stop(stop)[rows.clone()]),
            MotionFactor::StopLessSign(stop) => {
                let stops = signals.stop(stop)[rows.clone()].iter().zip(&signals.friction_sign()[rows.clone()]);
                for (y, (z, sign)) in out.iter_mut().zip(stops) {
                    *y = z - sign;
                }
            }
            MotionFactor::SlowStop(stop, speed) => {
                let stops = signals.stop(stop)[rows.clone()].iter().zip(&signals.slow(speed)[rows.clone()]);
                for (y, (z, slow)) in out.iter_mut().zip(stops) {
                    *y = z * slow;
                }
            }
            MotionFactor::SaturatedViscous(speed) => out.copy_from_slice(&signals.saturated_viscous(speed)[rows.clone()]),
            MotionFactor::StopMagnitude(stop) => {
                for (y, z) in out.iter_mut().zip(&signals.stop(stop)[rows.clone()]) {
                    *y = z.abs();
                }
            }
        }
        let position = match self.position {
            PositionFactor::Flat => return,
            PositionFactor::Cos(harmonic) => harmonics.cos(harmonic, rows),
            PositionFactor::Sin(harmonic) => harmonics.sin(harmonic, rows),
        };
        for (y, w) in out.iter_mut().zip(position) {
            *y *= w;
        }
    }
}

/// Cosine and sine of every position harmonic over a range of padded samples.
#[derive(Debug, Default)]
pub struct Harmonics {
    origin: usize,
    cos: Vec<Vec<f64>>,
    sin: Vec<Vec<f64>>,
}

impl Harmonics {
    /// All harmonics at the padded samples `rows`; zero if the positions are not in machine
    /// coordinates.
    #[must_use]
    pub fn new(signals: &Signals, rows: Range<usize>, scales: &Scales) -> Self {
        let (position, origin) = (&signals.position()[rows.clone()], rows.start);
        if !signals.is_placed() {
            let nothing = vec![vec![0.0; position.len()]; scales.lines.len()];
            return Self { origin, cos: nothing.clone(), sin: nothing };
        }
        let share = |x: &f64| {
            let beyond = x.abs() - scales.half_travel;
            if beyond <= 0.0 { 1.0 } else { (1.0 - beyond / scales.half_travel).max(0.0) }
        };
        let fades = position.iter().any(|x| x.abs() > scales.half_travel);
        let shares: Vec<f64> = if fades && !scales.lines.is_empty() { position.iter().map(share).collect() } else { Vec::new() };
        let mut turns = vec![0.0; position.len()];
        let of_harmonic = |harmonic: &f64| {
            turns.iter_mut().zip(position).for_each(|(turns, x)| *turns = harmonic * x);
            let (mut sin, mut cos) = (vec![0.0; turns.len()], vec![0.0; turns.len()]);
            sin_cos_of(&turns, &mut sin, &mut cos);
            for position in [&mut sin, &mut cos] {
                position.iter_mut().zip(&shares).for_each(|(position, share)| *position *= share);
            }
            (cos, sin)
        };
        let (cos, sin) = scales.lines.iter().map(of_harmonic).unzip();
        Self { origin, cos, sin }
    }

    /// Cosine of one harmonic at the padded samples `rows`.
    #[must_use]
    pub fn cos(&self, harmonic: usize, rows: Range<usize>) -> &[f64] {
        &self.cos[harmonic][rows.start - self.origin..rows.end - self.origin]
    }

    /// Sine of one harmonic at the padded samples `rows`.
    #[must_use]
    pub fn sin(&self, harmonic: usize, rows: Range<usize>) -> &[f64] {
        &self.sin[harmonic][rows.start - self.origin..rows.end - self.origin]
    }
}
