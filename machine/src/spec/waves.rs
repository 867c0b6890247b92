//! Waves over the motor turn and along an axis.

use serde::{Deserialize, Serialize};

use super::check::{finite, positive};
use crate::MachineError;

/// A wave over the motor turn: `amplitude · sin(per_turn · θ + phase)`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Harmonic {
    /// Relative amplitude.
    pub amplitude: f64,
    /// Waves per turn of the motor.
    pub per_turn: f64,
    /// Phase, rad.
    pub phase_rad: f64,
}

/// A torque over the motor turn: `amplitude_n_m · sin(per_turn · θ + phase)`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TorqueHarmonic {
    /// Amplitude, N·m.
    pub amplitude_n_m: f64,
    /// Waves per turn of the motor.
    pub per_turn: f64,
    /// Phase, rad.
    pub phase_rad: f64,
}

/// A wave along the axis: `amplitude · sin(2π x / period + phase)`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wave {
    /// Relative amplitude.
    pub amplitude: f64,
    /// Wavelength, mm.
    pub period_mm: f64,
    /// Phase, rad.
    pub phase_rad: f64,
}

impl Harmonic {
    /// Refuses numbers that are not finite, and a period that is not positive.
    pub(super) fn check(&self, at: &str) -> Result<(), MachineError> {
        finite(&format!("{at}.amplitude"), self.amplitude)?;
        positive(&format!("{at}.per_turn"), self.per_turn)?;
        finite(&format!("{at}.phase_rad"), self.phase_rad)
    }
}
