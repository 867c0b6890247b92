//! An axis as it stands in a machine file.

use motion::{Axis, AxisKind, AxisLimits};
use serde::{Deserialize, Serialize};

use super::DriveSpec;
use super::check::positive;
use crate::MachineError;

/// An axis: `kind = "linear"` or `"rotary"`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum AxisSpec {
    /// Moves along a line.
    Linear(LinearAxis),
    /// Turns.
    Rotary(RotaryAxis),
}

/// An axis that moves along a line.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinearAxis {
    /// Lower-case name.
    pub name: String,
    /// Largest speed, mm/s.
    pub velocity_mm_s: f64,
    /// Largest acceleration, mm/s².
    pub acceleration_mm_s2: f64,
    /// Largest jerk, mm/s³.
    pub jerk_mm_s3: f64,
    /// The drive of a simulated axis; a real machine has none here.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drive: Option<Box<DriveSpec>>,
}

/// An axis that turns.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RotaryAxis {
    /// Lower-case name.
    pub name: String,
    /// Largest speed, rad/s.
    pub velocity_rad_s: f64,
    /// Largest acceleration, rad/s².
    pub acceleration_rad_s2: f64,
    /// Largest jerk, rad/s³.
    pub jerk_rad_s3: f64,
}

impl AxisSpec {
    /// Name of the axis.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::Linear(axis) => &axis.name,
            Self::Rotary(axis) => &axis.name,
        }
    }

    /// Name and kind.
    #[must_use]
    pub fn axis(&self) -> Axis {
        let kind = match self {
            Self::Linear(_) => AxisKind::Linear,
            Self::Rotary(_) => AxisKind::Rotary,
        };
        Axis { name: self.name().to_owned(), kind }
    }

    /// Limits, mm or rad.
    #[must_use]
    pub fn limits(&self) -> AxisLimits {
        match self {
            Self::Linear(axis) => {
                AxisLimits { velocity: axis.velocity_mm_s, acceleration: axis.acceleration_mm_s2, jerk: axis.jerk_mm_s3 }
            }
            Self::Rotary(axis) => {
                AxisLimits { velocity: axis.velocity_rad_s, acceleration: axis.acceleration_rad_s2, jerk: axis.jerk_rad_s3 }
            }
        }
    }

    /// The drive, where the axis is a simulated one.
    #[must_use]
    pub fn drive(&self) -> Option<&DriveSpec> {
        match self {
            Self::Linear(axis) => axis.drive.as_deref(),
            Self::Rotary(_) => None,
        }
    }

    pub(super) fn check(&self, sampling_period_ms: f64) -> Result<(), MachineError> {
        let name = self.name();
        if name.is_empty() || name.to_ascii_lowercase() != name {
            return Err(MachineError::BadDescription(format!("`axes.name` is `{name}`; it must be a lower-case name")));
        }
        let keys = match self {
            Self::Linear(_) => ["velocity_mm_s", "acceleration_mm_s2", "jerk_mm_s3"],
            Self::Rotary(_) => ["velocity_rad_s", "acceleration_rad_s2", "jerk_rad_s3"],
        };
        let limits = self.limits();
        for (key, value) in keys.into_iter().zip([limits.velocity, limits.acceleration, limits.jerk]) {
            positive(&format!("axes.{name}.{key}"), value)?;
        }
        match self.drive() {
            Some(drive) => drive.check(&format!("axes.{name}.drive"), sampling_period_ms),
            None => Ok(()),
        }
    }
}
