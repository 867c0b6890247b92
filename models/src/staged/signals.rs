//! Signals of the features: velocity, its increments, the expected position, and stop operators on
//! it.

use serde::{Deserialize, Serialize};

use super::friction_map::{FrictionMap, Levels};
use super::stop::run_stops;
use crate::ranges::{DIVISOR, LENGTH, MOST_SIGNALS, POSITION, all_within, at_most, within};

/// Half-widths, scales and thresholds of one axis, all in its own unit (mm or rad) and seconds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Scales {
    /// Half-widths of the stop operators.
    pub stop_half_widths: Vec<f64>,
    /// Decay speeds of the terms that act only in slow motion, unit/s.
    pub slow_speeds: Vec<f64>,
    /// Whether these terms decay with the expected velocity. In models of earlier versions they
    /// decay with that of the reference, which differs for a slow loop.
    #[serde(default)]
    pub slow_by_expected: bool,
    /// Speeds from which on the saturated viscous friction is constant, unit/s.
    #[serde(default)]
    pub drag_speeds: Vec<f64>,
    /// Middle of the trained positions: phase origin of the position harmonics.
    pub centre: f64,
    /// Half the trained travel. Over the same distance beyond it the position harmonics taper off,
    /// since their phase becomes uncertain.
    pub half_travel: f64,
    /// Spatial frequency of each position harmonic, 1/unit.
    pub lines: Vec<f64>,
    /// Friction level along the axis; constant if `None`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction_map: Option<FrictionMap>,
}

impl Scales {
    /// No operators, no harmonics: the scales of a linear pass.
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

    /// Checks that widths and speeds are positive and all numbers are finite.
    pub(super) fn check(&self) -> Result<(), String> {
        if let Some(map) = &self.friction_map {
            map.check()?;
        }
        for (key, values) in [
            ("stop_half_widths", &self.stop_half_widths),
            ("slow_speeds", &self.slow_speeds),
            ("drag_speeds", &self.drag_speeds),
            ("lines", &self.lines),
        ] {
            at_most(&format!("number of {key}"), values.len(), MOST_SIGNALS)?;
            all_within(key, values, DIVISOR)?;
        }
        within("centre", self.centre, POSITION)?;
        within("half_travel", self.half_travel, LENGTH)
    }
}

/// Signals of one run, padded at both ends with a standstill so that every lag exists.
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
    /// Direction times the friction level, if that depends on the position.
    friction_sign: Option<Vec<f64>>,
    /// `exp(−|v|/q)` of each decay speed.
    slow: Vec<Vec<f64>>,
    position: Vec<f64>,
    stops: Vec<Vec<f64>>,
    viscous: Vec<Vec<f64>>,
    /// Whether the positions are in machine coordinates.
    placed: bool,
}

impl Signals {
    /// Signals of a reference with `pad` samples of standstill before and after it.
    ///
    /// `flags` is the path that gives the direction of motion; `expected` the expected position of
    /// the axis, on which the operators run, with initial strain `start`. All three have one value
    /// per period and the same length.
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

    /// The signals that do not depend on the expected position; call [`Signals::expect`] next.
    #[must_use]
    pub(super) fn of_motion(reference: &[f64], flags: &[f64], period_s: f64, pad: usize) -> Self {
        let velocity = padded_velocity(reference, period_s, pad);
        let mut step = vec![0.0; velocity.len()];
        for k in 1..velocity.len() {
            step[k] = velocity[k] - velocity[k - 1];
        }
        let sign = padded_velocity(flags, period_s, pad).into_iter().map(|v| if v == 0.0 { 0.0 } else { v.signum() }).collect();
        let (slow, position, stops, viscous) = Default::default();
        Self {
            pad,
            len: reference.len(),
            period_s,
            start: 0.0,
            velocity,
            step,
            sign,
            friction_sign: None,
            slow,
            position,
            stops,
            viscous,
            placed: true,
        }
    }

    /// The same with positions in machine coordinates only if `placed`; else position harmonics are
    /// zero.
    #[must_use]
    pub(super) fn placed(self, placed: bool) -> Self {
        Self { placed, ..self }
    }

    /// Whether the positions are in machine coordinates.
    pub(super) fn is_placed(&self) -> bool {
        self.placed
    }

    /// Computes the signals of the expected position on these scales.
    pub(super) fn expect(&mut self, expected: &[f64], scales: &Scales) {
        pad_into(expected, self.pad, &mut self.position);
        let slow_by = if scales.slow_by_expected { &velocity_along(&self.position, self.period_s) } else { &self.velocity };
        let decay = |speed: &f64| slow_by.iter().map(|v| (v.abs() * (-1.0 / speed)).exp()).collect();
        self.slow = scales.slow_speeds.iter().map(decay).collect();
        let map = scales.friction_map.as_ref().filter(|_| self.placed);
        let levels = map.map(|map| Levels::along(map, &self.position, scales.centre));
        let with_level =
            |levels: &Levels| self.sign.iter().enumerate().map(|(k, sign)| sign * levels.towards(k, *sign)).collect();
        self.friction_sign = levels.as_ref().map(with_level);
        run_stops(&self.position, &scales.stop_half_widths, self.start, levels.as_ref(), &mut self.stops);
        self.viscous.resize(scales.drag_speeds.len(), Vec::new());
        for (viscous, speed) in self.viscous.iter_mut().zip(&scales.drag_speeds) {
            let gain = 1.0 / (speed * self.period_s);
            viscous.resize(self.position.len(), 0.0);
            for (viscous, pair) in viscous.iter_mut().skip(1).zip(self.position.windows(2)) {
                *viscous = ((pair[1] - pair[0]) * gain).clamp(-1.0, 1.0);
            }
            if let Some(levels) = &levels {
                viscous.iter_mut().enumerate().for_each(|(k, viscous)| *viscous *= levels.towards(k, *viscous));
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

    /// Samples of standstill padding at either end.
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

    /// Direction of motion times the friction level at the position, padded.
    #[must_use]
    pub fn friction_sign(&self) -> &[f64] {
        self.friction_sign.as_deref().unwrap_or(&self.sign)
    }

    /// Factor `exp(−|v|/q)` of the terms with decay speed `index`, padded.
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

    /// Saturated viscous friction that is constant from speed `index` on, in −1…1, padded.
    #[must_use]
    pub fn saturated_viscous(&self, index: usize) -> &[f64] {
        &self.viscous[index]
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
