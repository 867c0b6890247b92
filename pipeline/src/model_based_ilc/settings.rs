//! Settings of model-based ILC.

use compensation::CorrectionLimits;
use serde::Serialize;

use crate::refit::RefitSettings;

/// Law of the iteration on the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LawName {
    /// The contour error itself, minimised on the model by Gauss-Newton steps; spatial learning where the tool turns (default)
    ModelBased,
    /// One shift by the predicted contour error (Paper D)
    OneShot,
    /// Every axis driven to its desired position at its time, iterated on the model
    Tracking,
    /// Every axis's error with a bounded shift, iterated on the model (Paper E, N.O.-ILC)
    NormOptimal,
    /// The contour error alone with a bounded shift, iterated on the model (Paper E, N.O.-CCILC)
    CrossCoupled,
}

impl LawName {
    /// The name that the command line takes.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::ModelBased => "model-based",
            Self::OneShot => "one-shot",
            Self::Tracking => "tracking",
            Self::NormOptimal => "norm-optimal",
            Self::CrossCoupled => "cross-coupled",
        }
    }
}

/// When a program gets fewer points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FewerPoints {
    /// Never.
    Never,
    /// Where its cycle would be too long otherwise.
    WhereTooSlow,
    /// Also where its forecast stays as good.
    WhereForecastAllows,
}

/// Settings of model-based ILC.
///
/// Defaults: law [`LawName::ModelBased`], 4 iterations, 1 % of the expected error for a run to count, gain 0.9 and low-pass 100 Hz (used by the papers' laws only), bound of shifts from the
/// forecast, rotation 0.5°, no output (`written: None`), a cycle at most 1 % longer, as few points
/// as the forecast allows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// The law.
    pub law: LawName,
    /// Number of updates on the model; the one-shot law uses one. A replanned program gets up to three times as many in
    /// addition, a program of hours fewer.
    pub iterations: usize,
    /// Share of the error expected on the machine that a run of a program has to save to count; after several runs that do not, learning ends.
    pub worth: f64,
    /// Gain of every update.
    pub gain: f64,
    /// Cut-off of the zero-phase low-pass on every update, Hz.
    pub low_pass_hz: f64,
    /// Largest correction of the tool tip, mm; `None` takes [`shift_bound`].
    pub max_shift: Option<f64>,
    /// Largest correction of the tool orientation, rad.
    pub max_rotation_rad: f64,
    /// Output settings of a program, whose replanned feed profile the last updates then use. `None` where the control
    /// takes the reference itself.
    pub written: Option<RefitSettings>,
    /// Largest relative increase of the cycle time of a replanned program. Points are further apart, and have no times of their own, where
    /// that keeps within it; otherwise nothing is changed.
    pub cycle_limit: f64,
    /// Whether a program whose limit of the cycle time is larger than the usual one is also learned within that one.
    pub tries_usual_limit: bool,
    /// Whether a program is also learned within a larger limit of the cycle time, and the result taken where it keeps the own one.
    pub tries_larger_limit: bool,
    /// When a program gets fewer points than `written` says.
    pub fewer_points: FewerPoints,
    /// Whether errors beside moves that are not changed count only where they exceed what corrections reach there. Not where feeds are sought, which
    /// change all of them.
    pub unavoidable_apart: bool,
    /// Whether a program comes slowly to its stops, where the axes would pass them otherwise.
    pub slow_stops: bool,
}

/// Default share of the expected error that a run has to save.
const WORTH: f64 = 0.01;
/// Default limit of the relative increase of the cycle time.
pub(super) const CYCLE_LIMIT: f64 = 0.01;

impl Default for Settings {
    fn default() -> Self {
        Self {
            law: LawName::ModelBased,
            iterations: 4,
            worth: WORTH,
            gain: 0.9,
            low_pass_hz: 100.0,
            max_shift: None,
            max_rotation_rad: CorrectionLimits::MAX_ROTATION_DEG.to_radians(),
            written: None,
            cycle_limit: CYCLE_LIMIT,
            tries_usual_limit: true,
            tries_larger_limit: false,
            fewer_points: FewerPoints::WhereForecastAllows,
            unavoidable_apart: true,
            slow_stops: true,
        }
    }
}

/// Largest correction as a multiple of the largest error. A stop or sharp turn of a slow loop needs more than its
/// error.
const SHIFT_OF_ERROR: f64 = 2.0;
/// Least and largest default bound of corrections, mm.
const SHIFT_BOUND_MM: [f64; 2] = [0.1, 1.0];

/// Default bound of corrections of the tool tip, mm, for a run that is already shifted by up to `shifted_mm` and has a
/// largest error of `max_mm`.
#[must_use]
pub fn shift_bound(shifted_mm: f64, max_mm: f64) -> f64 {
    let [least, most] = SHIFT_BOUND_MM;
    (shifted_mm + SHIFT_OF_ERROR * max_mm).clamp(least, most)
}
