//! Torque that depends on the motor angle.

use crate::spec::{Harmonic, MotorSpec, TorqueHarmonic};

/// Torque ripple and cogging.
#[derive(Debug, Clone)]
pub(super) struct Ripple {
    ripple: Vec<Harmonic>,
    cogging: Vec<TorqueHarmonic>,
}

impl Ripple {
    pub(super) fn new(spec: &MotorSpec) -> Self {
        Self { ripple: spec.ripple.clone(), cogging: spec.cogging.clone() }
    }

    /// Factor on the motor torque, and cogging torque in N·m, at `angle` in rad.
    pub(super) fn at(&self, angle: f64) -> (f64, f64) {
        let ripple = self.ripple.iter().map(|wave| wave.amplitude * (wave.per_turn * angle + wave.phase_rad).sin());
        let cogging = self.cogging.iter().map(|wave| wave.amplitude_n_m * (wave.per_turn * angle + wave.phase_rad).sin());
        (1.0 + ripple.sum::<f64>(), cogging.sum())
    }
}
