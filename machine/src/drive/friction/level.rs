//! How friction varies with place.

use std::f64::consts::TAU;

use crate::spec::FrictionSpec;

/// Friction relative to its mean, over the axis and the screw's turn.
#[derive(Debug, Clone)]
pub(in crate::drive) struct Level {
    spec: FrictionSpec,
}

impl Level {
    pub(in crate::drive) fn new(spec: &FrictionSpec) -> Self {
        Self { spec: spec.clone() }
    }

    /// `1 + Σ waves + Σ screw_waves + Σ patches` at the table's position (mm) and the motor's angle (rad).
    pub(in crate::drive) fn at(&self, position_mm: f64, angle: f64) -> f64 {
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
