//! What the features are made of: velocity, its increments, the position that is expected, and stop operators on it.

use serde::{Deserialize, Serialize};

use super::friction_map::{FrictionMap, Levels};
use super::stop::run_stops;

/// Half-widths, scales and thresholds of one axis, all in its own unit (mm or rad) and seconds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Scales {
    /// Half-widths of the stop operators.
    pub stop_half_widths: Vec<f64>,
    /// Decay speeds of the terms that act in slow motion only, unit/s.
    pub slow_speeds: Vec<f64>,
    /// Whether those fade with the expected velocity; with the reference's, from which a slow loop's differs, in models of earlier versions.
    #[serde(default)]
    pub slow_by_expected: bool,
    /// Speeds from which on a drag is constant, unit/s.
    #[serde(default)]
    pub drag_speeds: Vec<f64>,
    /// Middle of the trained positions, from which the position lines count their phase.
    pub centre: f64,
    /// Half the trained travel. Beyond it the position lines fade over as much again: their phase is known less and less.
    pub half_travel: f64,
    /// Spatial frequency of each position line, 1/unit.
    pub lines: Vec<f64>,
    /// Level of friction along the axis; the same everywhere when `None`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction_map: Option<FrictionMap>,
}

impl Scales {
    /// No operators, no lines: what a linear pass needs.
    #[must_use]
    pub fn linear() -> Self {
        Self {
            stop_half_widths: Vec::new(),
            slow_speeds: Vec::new(),
            slow_by_expected: true,
            drag_speeds: Vec::new(),
            centre: 0.0,
            half_travel: 0.0,
            lines: Vec::new(),
            friction_map: None,
        }
    }

    /// Whether widths and speeds are positive and everything is finite.
    pub(super) fn check(&self) -> Result<(), String> {
        if let Some(map) = &self.friction_map {
            map.check()?;
        }
        let positive = |values: &[f64]| values.iter().all(|v| v.is_finite() && *v > 0.0);
        if positive(&self.stop_half_widths)
            && positive(&self.slow_speeds)
            && positive(&self.drag_speeds)
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
    period_s: f64,
    /// Strain of the stop operators at the start.
    start: f64,
    velocity: Vec<f64>,
    step: Vec<f64>,
    sign: Vec<f64>,
    /// Direction times the level of friction, where that differs along the axis.
    push: Option<Vec<f64>>,
    /// `exp(−|v|/q)` of each decay speed.
    slow: Vec<Vec<f64>>,
    position: Vec<f64>,
    stops: Vec<Vec<f64>>,
    drag: Vec<Vec<f64>>,
    /// Whether the positions are the machine's.
    placed: bool,
}

impl Signals {
    /// Signals of a reference with `pad` samples of rest before and after it.
    ///
    /// `flags` is the path whose direction of motion counts; `expected` the position that the axis is expected to take, on which the
    /// operators run, strained by `start` at first. All three have one value a period and the same length.
    #[must_use]
    pub fn new(
        reference: &[f64],
        flags: &[f64],
        expected: &[f64],
        period_s: f64,
        start: f64,
        pad: usize,
        scales: &Scales,
    ) -> Self {
        let mut signals = Self { start, ..Self::of_motion(reference, flags, period_s, pad) };
        signals.expect(expected, scales);
        signals
    }

    /// What does not depend on the position that is expected: [`Signals::expect`] has to follow.
    #[must_use]
    pub(super) fn of_motion(reference: &[f64], flags: &[f64], period_s: f64, pad: usize) -> Self {
        let velocity = padded_velocity(reference, period_s, pad);
        let mut step = vec![0.0; velocity.len()];
        for k in 1..velocity.len() {
            step[k] = velocity[k] - velocity[k - 1];
        }
        let sign = padded_velocity(flags, period_s, pad).into_iter().map(|v| if v == 0.0 { 0.0 } else { v.signum() }).collect();
        let (slow, position, stops, drag) = Default::default();
        Self {
            pad,
            len: reference.len(),
            period_s,
            start: 0.0,
            velocity,
            step,
            sign,
            push: None,
            slow,
            position,
            stops,
            drag,
            placed: true,
        }
    }

    /// The same where positions are the machine's only if `placed`; else position lines are zero.
    #[must_use]
    pub(super) fn placed(self, placed: bool) -> Self {
        Self { placed, ..self }
    }

    /// Whether the positions are the machine's.
    pub(super) fn is_placed(&self) -> bool {
        self.placed
    }

    /// Takes the position that is expected, seen on these scales.
    pub(super) fn expect(&mut self, expected: &[f64], scales: &Scales) {
        pad_into(expected, self.pad, &mut self.position);
        let slow_by = if scales.slow_by_expected { &velocity_along(&self.position, self.period_s) } else { &self.velocity };
        let decay = |speed: &f64| slow_by.iter().map(|v| (v.abs() * (-1.0 / speed)).exp()).collect();
        self.slow = scales.slow_speeds.iter().map(decay).collect();
        let map = scales.friction_map.as_ref().filter(|_| self.placed);
        let levels = map.map(|map| Levels::along(map, &self.position, scales.centre));
        let pushed = |levels: &Levels| self.sign.iter().enumerate().map(|(k, sign)| sign * levels.towards(k, *sign)).collect();
        self.push = levels.as_ref().map(pushed);
        run_stops(&self.position, &scales.stop_half_widths, self.start, levels.as_ref(), &mut self.stops);
        self.drag.resize(scales.drag_speeds.len(), Vec::new());
        for (drag, speed) in self.drag.iter_mut().zip(&scales.drag_speeds) {
            let gain = 1.0 / (speed * self.period_s);
            drag.resize(self.position.len(), 0.0);
            for (drag, pair) in drag.iter_mut().skip(1).zip(self.position.windows(2)) {
                *drag = ((pair[1] - pair[0]) * gain).clamp(-1.0, 1.0);
            }
            if let Some(levels) = &levels {
                drag.iter_mut().enumerate().for_each(|(k, drag)| *drag *= levels.towards(k, *drag));
            }
        }
        self.position.iter_mut().for_each(|x| *x -= scales.centre);
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

    /// Direction of motion times the level of friction at the place, padded.
    #[must_use]
    pub fn push(&self) -> &[f64] {
        self.push.as_deref().unwrap_or(&self.sign)
    }

    /// What is left at its speed of a term that fades with decay speed `index`, padded.
    #[must_use]
    pub fn slow(&self, index: usize) -> &[f64] {
        &self.slow[index]
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

    /// Drag that is constant from speed `index` on, in −1…1, padded.
    #[must_use]
    pub fn drag(&self, index: usize) -> &[f64] {
        &self.drag[index]
    }
}

fn pad_into(values: &[f64], pad: usize, out: &mut Vec<f64>) {
    let (first, last) = (values.first().copied().unwrap_or(0.0), values.last().copied().unwrap_or(0.0));
    out.clear();
    out.resize(pad, first);
    out.extend_from_slice(values);
    out.resize(values.len() + 2 * pad, last);
}

/// Backward difference of a padded position.
fn velocity_along(position: &[f64], period_s: f64) -> Vec<f64> {
    std::iter::once(0.0).chain(position.windows(2).map(|pair| (pair[1] - pair[0]) / period_s)).collect()
}

fn padded_velocity(values: &[f64], period_s: f64, pad: usize) -> Vec<f64> {
    let mut out = vec![0.0; values.len() + 2 * pad];
    for k in 1..values.len() {
        out[pad + k] = (values[k] - values[k - 1]) / period_s;
    }
    out
}
