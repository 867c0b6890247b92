//! Settings of the feed planner and their check.

use crate::{Kinematics, Limits, MotionError};

/// How a control passes a corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Corners {
    /// It rounds the corner within the tolerance.
    Blend,
    /// It passes the corner itself, at the speed at which no axis changes its speed by more, mm/s.
    SpeedJump(f64),
    /// It passes the corner itself, as fast as an arc could be run with the acceleration along the path that touches both
    /// lines and lies this far from the corner, mm: `v² = a·δ·cos(φ/2) / (1 − cos(φ/2))` for a turn by `φ`.
    JunctionDeviation(f64),
}

impl Corners {
    /// Its number, mm/s or mm; 0 for a blend.
    #[must_use]
    pub fn value(self) -> f64 {
        match self {
            Self::Blend => 0.0,
            Self::SpeedJump(value) | Self::JunctionDeviation(value) => value,
        }
    }

    /// Largest squared speed at a turn by `turn_rad` with the largest change `jump` of an axis's share of the speed, mm²/s².
    pub(super) fn squared_speed(self, turn_rad: f64, jump: f64, acceleration_mm_s2: f64) -> f64 {
        match self {
            Self::Blend => f64::INFINITY,
            Self::SpeedJump(most_mm_s) => (most_mm_s / jump).powi(2),
            Self::JunctionDeviation(off_mm) => {
                let cos = (0.5 * turn_rad).cos();
                acceleration_mm_s2 * off_mm * cos / (1.0 - cos)
            }
        }
    }
}

/// Filters of one axis after interpolation. They leave the path: corners are rounded and arcs shrink.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AxisFilter {
    /// Moving averages, s. 0 for none.
    pub averages_s: [f64; 2],
    /// Time constant of a first-order lag, s. 0 for none.
    pub time_constant_s: f64,
}

/// Settings of the feed planner.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanSettings {
    /// Sampling period, s.
    pub period_s: f64,
    /// Rounding tolerance of corners, mm. 0 stops at every corner.
    pub corner_tolerance_mm: f64,
    /// How corners are passed where the program does not ask for an exact stop.
    pub corners: Corners,
    /// Second smoothing window, s. It makes the jerk continuous.
    pub smoothing_s: f64,
    /// Filters of the axes after interpolation, one for each axis. Empty for none.
    pub filters: Vec<AxisFilter>,
    /// Pieces after the present one whose end the control knows: it can always stop there. `None` for all of the path.
    pub look_ahead: Option<usize>,
    /// Shortest time for a piece, s: a shorter one is passed slower. 0 for none.
    pub piece_time_s: f64,
    /// Fraction of the acceleration that is used on pieces whose end is not rounded as the tolerance allows: they are too short for it, the
    /// tool dwells there, or the program ends.
    pub short_line_acceleration: f64,
    /// Largest acceleration in arcs, along and across together, mm/s²: along an arc what its fastest passage leaves, and along one that
    /// begins and ends at standstill what the largest acceleration across leaves. In a plane in which the axes allow less in some direction, it
    /// and the acceleration across are as much smaller. Infinite for none.
    pub arc_acceleration_mm_s2: f64,
    /// Dwell before the first and after the last motion, s.
    pub rest_s: f64,
}

impl Default for PlanSettings {
    fn default() -> Self {
        Self {
            period_s: 0.002,
            corner_tolerance_mm: 0.01,
            corners: Corners::Blend,
            smoothing_s: 0.02,
            filters: Vec::new(),
            look_ahead: None,
            piece_time_s: 0.0,
            short_line_acceleration: 1.0,
            arc_acceleration_mm_s2: f64::INFINITY,
            rest_s: 0.2,
        }
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
        ("piece_time_s", settings.piece_time_s),
        ("corners", settings.corners.value()),
        ("rest_s", settings.rest_s),
    ];
    let of_filter = |filter: &AxisFilter| {
        let [first, second] = filter.averages_s;
        [("averages_s", first), ("averages_s", second), ("time_constant_s", filter.time_constant_s)]
    };
    if !settings.filters.is_empty() && settings.filters.len() != limits.axes.len() {
        return Err(MotionError::Mismatch(format!(
            "filters for {} axes, but the machine has {}",
            settings.filters.len(),
            limits.axes.len()
        )));
    }
    if settings.look_ahead == Some(0) {
        return Err(MotionError::BadSetting { name: "look_ahead", value: 0.0, remedy: "it must be at least 1" });
    }
    if !(settings.short_line_acceleration > 0.0 && settings.short_line_acceleration <= 1.0) {
        let (name, value) = ("short_line_acceleration", settings.short_line_acceleration);
        return Err(MotionError::BadSetting { name, value, remedy: "it must be above 0 and at most 1" });
    }
    if settings.arc_acceleration_mm_s2.is_nan() || settings.arc_acceleration_mm_s2 <= 0.0 {
        let (name, value) = ("arc_acceleration_mm_s2", settings.arc_acceleration_mm_s2);
        return Err(MotionError::BadSetting { name, value, remedy: "it must be above 0" });
    }
    let numbers = non_negative.into_iter().chain(settings.filters.iter().flat_map(of_filter));
    match numbers.into_iter().find(|(_, value)| !(value.is_finite() && *value >= 0.0)) {
        Some((name, value)) => Err(MotionError::BadSetting { name, value, remedy: "it must be finite and not negative" }),
        None => Ok(()),
    }
}
