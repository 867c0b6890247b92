//! Sensor and simulation options of a machine.

use serde::{Deserialize, Serialize};

/// Position sensor of the position loop and of the log.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Sensor {
    /// The encoder on the motor shaft. It does not measure backlash and screw deflection.
    #[default]
    Motor,
    /// A scale on the table.
    Table,
}

impl Sensor {
    /// Whether it is the motor encoder, the default of a machine file.
    pub(crate) fn is_motor(&self) -> bool {
        *self == Self::Motor
    }
}

/// Interpolation of the reference between its samples.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// Straight lines.
    #[default]
    Linear,
    /// Cubic Hermite segments with central-difference slopes.
    Cubic,
}

/// Simulation options.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SimulationOptions {
    /// Feedback of the position loop, and the view that [`Machine::run`](crate::Machine::run)
    /// returns. `None`: that of the machine.
    pub sensor: Option<Sensor>,
    /// Factor on all run-to-run noise: torque and force noise, friction level per run, drift. 1: as
    /// described. 0: nothing is drawn and every run is the same.
    pub noise_scale: f64,
    /// Whether encoder and scale are quantised to whole counts, in the loop and in the log.
    pub quantised: bool,
    /// Interpolation of the reference between its samples.
    pub interpolation: Interpolation,
}

impl Default for SimulationOptions {
    fn default() -> Self {
        Self { sensor: None, noise_scale: 1.0, quantised: true, interpolation: Interpolation::Linear }
    }
}

impl SimulationOptions {
    /// Options without run-to-run noise. Encoders are still quantised: a run is exactly repeatable
    /// but not smoothed.
    #[must_use]
    pub fn noise_free() -> Self {
        Self { noise_scale: 0.0, ..Self::default() }
    }
}
