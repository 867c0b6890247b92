//! Variation of friction with position and time.

use std::f64::consts::TAU;

use crate::spec::{FrictionSpec, Warming};

/// Friction relative to its mean, over the axis and over the screw turn.
#[derive(Debug, Clone)]
pub(crate) struct Level {
    spec: FrictionSpec,
}

impl Level {
    pub(crate) fn new(spec: &FrictionSpec) -> Self {
        Self { spec: spec.clone() }
    }

    /// `1 + Σ waves + Σ screw_waves + Σ patches` at the table's position (mm) and the motor's angle (rad).
    pub(crate) fn at(&self, position_mm: f64, angle: f64) -> f64 {
        let waves =
            self.spec.waves.iter().map(|wave| wave.amplitude * (TAU * position_mm / wave.period_mm + wave.phase_rad).sin());
        let turns = self.spec.screw_waves.iter().map(|wave| wave.amplitude * (wave.per_turn * angle + wave.phase_rad).sin());
        let patches = self.spec.patches.iter().map(|patch| {
            let ratio = (position_mm - patch.centre_mm) / patch.width_mm;
            patch.amplitude * (-ratio * ratio).exp()
        });
        1.0 + waves.sum::<f64>() + turns.sum::<f64>() + patches.sum::<f64>()
    }
}

/// Decrease of the level while the machine warms up, relative to its mean.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Warmth {
    share: f64,
    /// Present value of `exp(−t/time)`, and its factor from period to period.
    left: f64,
    keep: f64,
}

impl Warmth {
    /// State after `elapsed_s` of running, stepped every `tick_s`. No warming at a noise of zero.
    pub(crate) fn new(warming: Option<Warming>, noise: f64, elapsed_s: f64, tick_s: f64) -> Self {
        let Warming { share, time_s } = warming.unwrap_or(Warming { share: 0.0, time_s: 1.0 });
        Self { share: noise * share, left: (-elapsed_s / time_s).exp(), keep: (-tick_s / time_s).exp() }
    }

    /// `1 + share·(2·exp(−t/time) − 1)`, then advances one period.
    pub(crate) fn step(&mut self) -> f64 {
        let level = 1.0 + self.share * (2.0 * self.left - 1.0);
        self.left *= self.keep;
        level
    }
}
