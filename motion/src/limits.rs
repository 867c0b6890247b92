//! Limits of the axes and of the path.

use serde::{Deserialize, Serialize};

use crate::MotionError;

/// Limits of one axis, in mm or rad, per s, s², s³.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxisLimits {
    /// Largest speed, mm/s or rad/s.
    pub velocity: f64,
    /// Largest acceleration, mm/s² or rad/s².
    pub acceleration: f64,
    /// Largest jerk, mm/s³ or rad/s³.
    pub jerk: f64,
}

/// Limits of a machine: every axis, and the path.
#[derive(Debug, Clone, PartialEq)]
pub struct Limits {
    /// One per axis, in axis order.
    pub axes: Vec<AxisLimits>,
    /// Largest speed along the path, mm/s. Also the speed of rapids.
    pub path_velocity_mm_s: f64,
    /// Largest acceleration along the path, mm/s².
    pub path_acceleration_mm_s2: f64,
    /// Largest jerk along the path, mm/s³.
    pub path_jerk_mm_s3: f64,
    /// Largest acceleration across the path, mm/s²: a curve of radius r is limited to `√(a·r)`.
    pub centripetal_mm_s2: f64,
}

impl Limits {
    /// The same limits for `axes` axes and the path. The jerk allows a change from one acceleration
    /// limit to the other in `rise_s`.
    #[must_use]
    pub fn uniform(axes: usize, velocity_mm_s: f64, acceleration_mm_s2: f64, rise_s: f64) -> Self {
        let jerk = 2.0 * acceleration_mm_s2 / rise_s;
        Self {
            axes: vec![AxisLimits { velocity: velocity_mm_s, acceleration: acceleration_mm_s2, jerk }; axes],
            path_velocity_mm_s: velocity_mm_s,
            path_acceleration_mm_s2: acceleration_mm_s2,
            path_jerk_mm_s3: jerk,
            centripetal_mm_s2: acceleration_mm_s2,
        }
    }

    /// Checks that every limit is positive and finite.
    ///
    /// # Errors
    /// Names the invalid limit.
    pub fn check(&self) -> Result<(), MotionError> {
        let path = [
            ("path_velocity_mm_s", self.path_velocity_mm_s),
            ("path_acceleration_mm_s2", self.path_acceleration_mm_s2),
            ("path_jerk_mm_s3", self.path_jerk_mm_s3),
            ("centripetal_mm_s2", self.centripetal_mm_s2),
        ];
        let axes = self.axes.iter().flat_map(|axis| {
            [
                ("an axis's velocity limit", axis.velocity),
                ("an axis's acceleration limit", axis.acceleration),
                ("an axis's jerk limit", axis.jerk),
            ]
        });
        match path.into_iter().chain(axes).find(|(_, value)| !(value.is_finite() && *value > 0.0)) {
            Some((name, value)) => Err(MotionError::BadSetting { name, value, remedy: "it must be positive and finite" }),
            None => Ok(()),
        }
    }
}
