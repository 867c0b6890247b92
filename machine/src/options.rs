//! Which sensor a machine reads, and how it is simulated.

use serde::{Deserialize, Serialize};

/// Where the position loop and the log take an axis's position from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Sensor {
    /// The encoder on the motor's shaft; it cannot see backlash and the screw's stretch.
    #[default]
    Motor,
    /// A scale on the table.
    Table,
}

impl Sensor {
    /// Whether it is the motor's encoder, which a machine file need not state.
    pub(crate) fn is_motor(&self) -> bool {
        *self == Self::Motor
    }
}

/// The reference between its samples.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// Straight lines.
    #[default]
    Linear,
    /// Cubic Hermite segments with central-difference slopes.
    Cubic,
}

/// How a machine is simulated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SimulationOptions {
    /// Feedback of the position loop, and the view that [`Machine::run`](crate::Machine::run) returns; the machine's own where it is `None`.
    pub sensor: Option<Sensor>,
    /// Factor on all run-to-run noise: torque and force noise, each run's friction level, drift. 1 as described; at 0 nothing is drawn and
    /// every run is the same.
    pub noise_scale: f64,
    /// Whether encoder and scale read whole counts, in the loop and in the log.
    pub quantised: bool,
    /// The reference between its samples.
    pub interpolation: Interpolation,
}

impl Default for SimulationOptions {
    fn default() -> Self {
        Self { sensor: None, noise_scale: 1.0, quantised: true, interpolation: Interpolation::Linear }
    }
}

impl SimulationOptions {
    /// The machine without run-to-run noise; encoders still count, so a run is exactly repeatable but not smoothed.
    #[must_use]
    pub fn noise_free() -> Self {
        Self { noise_scale: 0.0, ..Self::default() }
    }
}
