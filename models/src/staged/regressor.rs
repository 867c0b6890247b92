//! Regressors: the signals that act on the tracking error through a response of their own.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::phase::sin_cos_of;
use super::signals::{Scales, Signals};

/// The factor of a regressor that follows the motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MotionFactor {
    /// The constant 1.
    One,
    /// Velocity of the reference.
    Velocity,
    /// Increment of the velocity.
    VelocityStep,
    /// Direction of motion, times the level of friction where that differs along the axis.
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
    /// Backlash between the motor and what is measured: a stop operator whose contribution the motor does not feel, so that the next
    /// pass's expected position is without it.
    #[serde(rename = "play")]
    Backlash(usize),
}

/// The factor of a regressor that follows the position.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PositionFactor {
    /// The same everywhere.
    Flat,
    /// `cos 2πfx` of a position line.
    Cos(usize),
    /// `sin 2πfx` of a position line.
    Sin(usize),
}

/// A factor of the motion times one of the position.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Regressor {
    /// What follows the motion.
    #[serde(rename = "carrier")]
    pub motion: MotionFactor,
    /// What follows the position.
    #[serde(rename = "wave")]
    pub position: PositionFactor,
}

impl From<MotionFactor> for Regressor {
    fn from(motion: MotionFactor) -> Self {
        Self { motion, position: PositionFactor::Flat }
    }
}

impl Regressor {
    /// The motion times cosine and sine of `line`.
    #[must_use]
    pub fn on_line(motion: MotionFactor, line: usize) -> [Self; 2] {
        [PositionFactor::Cos(line), PositionFactor::Sin(line)].map(|position| Self { motion, position })
    }

    /// The line that this channel follows, if any.
    #[must_use]
    pub fn line(&self) -> Option<usize> {
        match self.position {
            PositionFactor::Flat => None,
            PositionFactor::Cos(line) | PositionFactor::Sin(line) => Some(line),
        }
    }

    /// Whether `scales` has the operator, speed and line that this channel names.
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
        motion && self.line().is_none_or(|line| line < scales.lines.len())
    }

    /// The signal that this channel is as it stands, over all padded samples, if it is one.
    pub(super) fn signal<'a>(&self, signals: &'a Signals) -> Option<&'a [f64]> {
        match (self.motion, self.position) {
            (MotionFactor::Velocity, PositionFactor::Flat) => Some(signals.velocity()),
            (MotionFactor::VelocityStep, PositionFactor::Flat) => Some(signals.step()),
            (MotionFactor::Sign, PositionFactor::Flat) => Some(signals.push()),
            (MotionFactor::Stop(stop) | MotionFactor::Backlash(stop), PositionFactor::Flat) => Some(signals.stop(stop)),
            (MotionFactor::SaturatedViscous(speed), PositionFactor::Flat) => Some(signals.drag(speed)),
            _ => None,
        }
    }

    /// Writes the channel's values at the padded samples `start..start + out.len()` to `out`.
    pub fn fill(&self, signals: &Signals, waves: &Waves, start: usize, out: &mut [f64]) {
        let rows = start..start + out.len();
        match self.motion {
            MotionFactor::One => out.fill(1.0),
            MotionFactor::Velocity => out.copy_from_slice(&signals.velocity()[rows.clone()]),
            MotionFactor::VelocityStep => out.copy_from_slice(&signals.step()[rows.clone()]),
            MotionFactor::Sign => out.copy_from_slice(&signals.push()[rows.clone()]),
            MotionFactor::Stop(stop) | MotionFactor::Backlash(stop) => out.copy_from_slice(&signals.stop(stop)[rows.clone()]),
            MotionFactor::StopLessSign(stop) => {
                let stops = signals.stop(stop)[rows.clone()].iter().zip(&signals.push()[rows.clone()]);
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
            MotionFactor::SaturatedViscous(speed) => out.copy_from_slice(&signals.drag(speed)[rows.clone()]),
            MotionFactor::StopMagnitude(stop) => {
                for (y, z) in out.iter_mut().zip(&signals.stop(stop)[rows.clone()]) {
                    *y = z.abs();
                }
            }
        }
        let position = match self.position {
            PositionFactor::Flat => return,
            PositionFactor::Cos(line) => waves.cos(line, rows),
            PositionFactor::Sin(line) => waves.sin(line, rows),
        };
        for (y, w) in out.iter_mut().zip(position) {
            *y *= w;
        }
    }
}

/// Cosine and sine of every position line over a stretch of padded samples.
#[derive(Debug, Default)]
pub struct Waves {
    origin: usize,
    cos: Vec<Vec<f64>>,
    sin: Vec<Vec<f64>>,
}

impl Waves {
    /// Waves of all lines at the padded samples `rows`; zero where the positions are not the machine's.
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
        let of_line = |line: &f64| {
            turns.iter_mut().zip(position).for_each(|(turns, x)| *turns = line * x);
            let (mut sin, mut cos) = (vec![0.0; turns.len()], vec![0.0; turns.len()]);
            sin_cos_of(&turns, &mut sin, &mut cos);
            for position in [&mut sin, &mut cos] {
                position.iter_mut().zip(&shares).for_each(|(position, share)| *position *= share);
            }
            (cos, sin)
        };
        let (cos, sin) = scales.lines.iter().map(of_line).unzip();
        Self { origin, cos, sin }
    }

    /// Cosine of one line at the padded samples `rows`.
    #[must_use]
    pub fn cos(&self, line: usize, rows: Range<usize>) -> &[f64] {
        &self.cos[line][rows.start - self.origin..rows.end - self.origin]
    }

    /// Sine of one line at the padded samples `rows`.
    #[must_use]
    pub fn sin(&self, line: usize, rows: Range<usize>) -> &[f64] {
        &self.sin[line][rows.start - self.origin..rows.end - self.origin]
    }
}
