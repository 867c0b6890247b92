//! Axes in a machine file.

use motion::{Axis, AxisKind, AxisLimits};
use serde::{Deserialize, Serialize};

use super::check::{Names, finite, not_negative, positive, within};
use super::rotary_drive::MRAD;
use super::{DriveSpec, RotaryDriveSpec};
use crate::MachineError;

/// Shortest travel, mm or degrees. Shorter values are typing errors.
const SHORTEST_TRAVEL: f64 = 1e-3;

/// An axis: `kind = "linear"` or `"rotary"`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum AxisSpec {
    /// Linear axis.
    Linear(LinearAxis),
    /// Rotary axis.
    Rotary(RotaryAxis),
}

/// A linear axis.
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
    /// Lowest and highest position, mm. Unlimited if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub travel_mm: Option<[f64; 2]>,
    /// Moving averages of this axis after interpolation, ms, where they are not those of `[control]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub filters_ms: Option<[f64; 2]>,
    /// Time constant of the lag of this axis after interpolation, ms, where it is not that of `[control]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_constant_ms: Option<f64>,
    /// Drive of a simulated axis. A real machine has none here.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drive: Option<Box<DriveSpec>>,
}

/// A rotary axis.
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
    /// Lowest and highest position, degrees. Unlimited if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub travel_deg: Option<[f64; 2]>,
    /// Moving averages of this axis after interpolation, ms, where they are not those of `[control]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub filters_ms: Option<[f64; 2]>,
    /// Time constant of the lag of this axis after interpolation, ms, where it is not that of `[control]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_constant_ms: Option<f64>,
    /// Drive of a simulated axis. A real machine has none here.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drive: Option<Box<RotaryDriveSpec>>,
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

    /// Replaces the limits.
    pub fn set_limits(&mut self, limits: AxisLimits) {
        let AxisLimits { velocity, acceleration, jerk } = limits;
        match self {
            Self::Linear(axis) => {
                (axis.velocity_mm_s, axis.acceleration_mm_s2, axis.jerk_mm_s3) = (velocity, acceleration, jerk);
            }
            Self::Rotary(axis) => {
                (axis.velocity_rad_s, axis.acceleration_rad_s2, axis.jerk_rad_s3) = (velocity, acceleration, jerk);
            }
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

    /// Lowest and highest position, mm or rad, if limited.
    #[must_use]
    pub fn travel(&self) -> Option<[f64; 2]> {
        match self {
            Self::Linear(axis) => axis.travel_mm,
            Self::Rotary(axis) => axis.travel_deg.map(|travel| travel.map(f64::to_radians)),
        }
    }

    /// Its own moving averages and time constant after interpolation, ms, where it states them.
    #[must_use]
    pub fn filters(&self) -> (Option<[f64; 2]>, Option<f64>) {
        match self {
            Self::Linear(axis) => (axis.filters_ms, axis.time_constant_ms),
            Self::Rotary(axis) => (axis.filters_ms, axis.time_constant_ms),
        }
    }

    /// Replaces them.
    pub fn set_filters(&mut self, filters_ms: Option<[f64; 2]>, time_constant_ms: Option<f64>) {
        match self {
            Self::Linear(axis) => (axis.filters_ms, axis.time_constant_ms) = (filters_ms, time_constant_ms),
            Self::Rotary(axis) => (axis.filters_ms, axis.time_constant_ms) = (filters_ms, time_constant_ms),
        }
    }

    /// Drive of a linear axis, if simulated.
    #[must_use]
    pub fn drive(&self) -> Option<&DriveSpec> {
        match self {
            Self::Linear(axis) => axis.drive.as_deref(),
            Self::Rotary(_) => None,
        }
    }

    /// Drive of a rotary axis, if simulated.
    #[must_use]
    pub fn rotary_drive(&self) -> Option<&RotaryDriveSpec> {
        match self {
            Self::Linear(_) => None,
            Self::Rotary(axis) => axis.drive.as_deref(),
        }
    }

    /// The drive to simulate, in mm or mrad, and the number of these per trajectory unit (mm, rad).
    pub(crate) fn simulated(&self) -> Option<(DriveSpec, f64)> {
        match self {
            Self::Linear(axis) => axis.drive.as_deref().map(|drive| (drive.clone(), 1.0)),
            Self::Rotary(axis) => axis.drive.as_deref().map(|drive| (drive.in_mrad(), MRAD)),
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
        let (key, travel) = match self {
            Self::Linear(axis) => ("travel_mm", axis.travel_mm),
            Self::Rotary(axis) => ("travel_deg", axis.travel_deg),
        };
        if let Some([low, high]) = travel {
            finite(&format!("axes.{name}.{key}[0]"), low)?;
            within(&format!("axes.{name}.{key}[1]"), high, low < high, &format!("finite and above {low}; write [low, high]"))?;
            finite(&format!("axes.{name}.{key}[1]"), high)?;
            within(&format!("axes.{name}.{key}"), high - low, high - low >= SHORTEST_TRAVEL, "longer than 0.001")?;
        }
        let (filters_ms, time_constant_ms) = self.filters();
        for filter_ms in filters_ms.iter().flatten() {
            not_negative(&format!("axes.{name}.filters_ms"), *filter_ms)?;
        }
        not_negative(&format!("axes.{name}.time_constant_ms"), time_constant_ms.unwrap_or(0.0))?;
        let at = format!("axes.{name}.drive");
        match self {
            Self::Linear(LinearAxis { drive: Some(drive), .. }) => drive.check(&at, Names::LINEAR, sampling_period_ms),
            Self::Rotary(RotaryAxis { drive: Some(drive), .. }) => drive.check(&at, sampling_period_ms),
            _ => Ok(()),
        }
    }
}
