//! Settings of the feed planner and their check.

use crate::{Kinematics, Limits, MotionError};

/// Settings of the feed planner.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanSettings {
    /// Sampling period, s.
    pub period_s: f64,
    /// Rounding tolerance of corners, mm. 0 stops at every corner.
    pub corner_tolerance_mm: f64,
    /// Second smoothing window, s. It makes the jerk continuous.
    pub smoothing_s: f64,
    /// Fraction of the acceleration along the path that is used on pieces too short for the
    /// rounding of their corners.
    pub short_line_acceleration: f64,
    /// Dwell before the first and after the last motion, s.
    pub rest_s: f64,
}

impl Default for PlanSettings {
    fn default() -> Self {
        Self { period_s: 0.002, corner_tolerance_mm: 0.01, smoothing_s: 0.02, short_line_acceleration: 1.0, rest_s: 0.2 }
    }
}

/// Refuses settings and limits out of range, and limits for axes other than those of `kinematics`.
pub(super) fn check(settings: &PlanSettings, limits: &Limits, kinematics: &dyn Kinematics) -> Result<(), MotionError> {
    limits.check()?;
    if limits.axes.len() != kinematics.axes().len() {
        return Err(MotionError::Mismatch(format!(
            "limits for {} axes, but the machine has {}",
            limits.axes.len(),
            kinematics.axes().len()
        )));
    }
    if !(settings.period_s.is_finite() && settings.period_s > 0.0) {
        return Err(MotionError::BadPeriod(settings.period_s));
    }
    let non_negative = [
        ("corner_tolerance_mm", settings.corner_tolerance_mm),
        ("smoothing_s", settings.smoothing_s),
        ("rest_s", settings.rest_s),
    ];
    if !(settings.short_line_acceleration > 0.0 && settings.short_line_acceleration <= 1.0) {
        let (name, value) = ("short_line_acceleration", settings.short_line_acceleration);
        return Err(MotionError::BadSetting { name, value, remedy: "it must be above 0 and at most 1" });
    }
    match non_negative.into_iter().find(|(_, value)| !(value.is_finite() && *value >= 0.0)) {
        Some((name, value)) => Err(MotionError::BadSetting { name, value, remedy: "it must be finite and not negative" }),
        None => Ok(()),
    }
}
