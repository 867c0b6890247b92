//! LuGre friction.

use super::sliding::Sliding;

/// `ż = v − |v|/g(v)·z`, `g = (F_c + (F_s − F_c)·exp(−(v/v_s)²))/σ0`, `F = σ0 z + σ1·exp(−(v/v_s)²)·ż`.
///
/// The bristle damping fades with the Stribeck curve. The model is therefore passive if `σ1 v_s ≤ 9
/// F_c`.
#[derive(Debug, Clone)]
pub(super) struct LuGre {
    stiffness: f64,
    damping: f64,
    deflection: f64,
}

impl LuGre {
    pub(super) fn new(stiffness: f64, damping: f64) -> Self {
        Self { stiffness, damping, deflection: 0.0 }
    }

    /// Force after a step at constant velocity, by the exact exponential of the linear equation in `z`.
    pub(super) fn step(&mut self, velocity: f64, sliding: Sliding, step_s: f64) -> f64 {
        let largest = sliding.steady() / self.stiffness;
        if largest <= 0.0 {
            return 0.0;
        }
        let before = self.deflection;
        let settled = largest.copysign(velocity);
        let travelled = velocity.abs() * step_s;
        self.deflection = settled + (before - settled) * (-travelled / largest).exp();
        let force = self.stiffness * self.deflection;
        if sliding.stribeck > 0.0 { force + self.damping * sliding.stribeck * (self.deflection - before) / step_s } else { force }
    }
}
