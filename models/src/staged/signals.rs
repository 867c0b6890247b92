//! What the features are made of: velocity, its increments, the position that is expected, and stop operators on it.

use serde::{Deserialize, Serialize};

use super::stop::run_stops;

/// Half-widths, scales and thresholds of one axis, all in its own unit (mm or rad) and seconds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Scales {
    /// Half-widths of the stop operators.
    pub stop_half_widths: Vec<f64>,
    /// Decay speeds of the terms that act in slow motion only, unit/s.
    pub slow_speeds: Vec<f64>,
    /// Middle of the trained positions, from which the position lines count their phase.
    pub centre: f64,
    /// Half the trained travel. Beyond it the position lines fade over as much again: their phase is known less and less.
    pub half_travel: f64,
    /// Spatial frequency of each position line, 1/unit.
    pub lines: Vec<f64>,
}

impl Scales {
    /// No operators, no lines: what a linear pass needs.
    #[must_use]
    pub fn linear() -> Self {
        Self { stop_half_widths: Vec::new(), slow_speeds: Vec::new(), centre: 0.0, half_travel: 0.0, lines: Vec::new() }
    }

    /// Whether widths and speeds are positive and everything is finite.
    pub(super) fn check(&self) -> Result<(), String> {
        let positive = |values: &[f64]| values.iter().all(|v| v.is_finite() && *v > 0.0);
        if positive(&self.stop_half_widths)
            && positive(&self.slow_speeds)
            && positive(&self.lines)
            && self.centre.is_finite()
            && self.half_travel.is_finite()
        {
            Ok(())
        } else {
            Err("a width, speed or line is not a positive number, or the travel is not a number".into())
        }
    }
}

/// Signals of one run, padded at both ends with rest so that every lag exists.
#[derive(Debug, Clone)]
pub struct Signals {
    pad: usize,
    len: usize,
    velocity: Vec<f64>,
    step: Vec<f64>,
    sign: Vec<f64>,
    position: Vec<f64>,
    stops: Vec<Vec<f64>>,
}

impl Signals {
    /// Signals of a reference with `pad` samples of rest before and after it.
    ///
    /// `flags` is the path whose direction of motion counts; `expected` the position that the axis is expected to take, on which the
    /// operators run. All three have one value a period and the same length.
    #[must_use]
    pub fn new(reference: &[f64], flags: &[f64], expected: &[f64], period_s: f64, pad: usize, scales: &Scales) -> Self {
        let velocity = padded_velocity(reference, period_s, pad);
        let mut step = vec![0.0; velocity.len()];
        for k in 1..velocity.len() {
            step[k] = velocity[k] - velocity[k - 1];
        }
        let sign = padded_velocity(flags, period_s, pad).into_iter().map(|v| if v == 0.0 { 0.0 } else { v.signum() }).collect();
        let mut position = padded(expected, pad);
        let stops = run_stops(&position, &scales.stop_half_widths);
        for x in &mut position {
            *x -= scales.centre;
        }
        Self { pad, len: reference.len(), velocity, step, sign, position, stops }
    }

    /// Number of samples of the run itself.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether the run has no samples.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Samples of rest at either end.
    #[must_use]
    pub fn pad(&self) -> usize {
        self.pad
    }

    /// Backward-difference velocity of the reference, unit/s, padded.
    #[must_use]
    pub fn velocity(&self) -> &[f64] {
        &self.velocity
    }

    /// Velocity increments, unit/s a sample, padded.
    #[must_use]
    pub fn step(&self) -> &[f64] {
        &self.step
    }

    /// Direction of motion, −1, 0 or 1, padded.
    #[must_use]
    pub fn sign(&self) -> &[f64] {
        &self.sign
    }

    /// Expected position less the centre, padded.
    #[must_use]
    pub fn position(&self) -> &[f64] {
        &self.position
    }

    /// Output of stop operator `index`, in −1…1, padded.
    #[must_use]
    pub fn stop(&self, index: usize) -> &[f64] {
        &self.stops[index]
    }
}

fn padded(values: &[f64], pad: usize) -> Vec<f64> {
    let (Some(&first), Some(&last)) = (values.first(), values.last()) else {
        return vec![0.0; 2 * pad];
    };
    let mut out = Vec::with_capacity(values.len() + 2 * pad);
    out.resize(pad, first);
    out.extend_from_slice(values);
    out.resize(values.len() + 2 * pad, last);
    out
}

fn padded_velocity(values: &[f64], period_s: f64, pad: usize) -> Vec<f64> {
    let mut out = vec![0.0; values.len() + 2 * pad];
    for k in 1..values.len() {
        out[pad + k] = (values[k] - values[k - 1]) / period_s;
    }
    out
}
