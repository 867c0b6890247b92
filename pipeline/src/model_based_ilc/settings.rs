//! What is asked of the learning.

use compensation::CorrectionLimits;
use serde::Serialize;

use crate::refit::RefitSettings;

/// How the reference is learned on the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LawName {
    /// The contour error itself, minimised on the model: spatial learning, then Gauss-Newton steps (default)
    Virtual,
    /// One shift by the predicted contour error (Paper D)
    OneShot,
    /// Every axis driven to its desired position at its time, iterated on the model
    Tracking,
    /// Every axis's error with a bounded shift, iterated on the model (Paper E, N.O.-ILC)
    NormOptimal,
    /// The contour error alone with a bounded shift, iterated on the model (Paper E, N.O.-CCILC)
    CrossCoupled,
}

/// Settings of a compensation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// The law.
    pub law: LawName,
    /// Updates on the model; one shot has one. A program that its control plans anew gets up to three times as many more, one of hours fewer.
    pub iterations: usize,
    /// Gain of every update.
    pub gain: f64,
    /// Cut-off of the zero-phase low-pass on every update, Hz.
    pub low_pass_hz: f64,
    /// Largest correction of the tool tip, mm; that of [`shift_bound`] when `None`.
    pub max_shift: Option<f64>,
    /// Largest correction of the tool's direction, rad.
    pub max_rotation_rad: f64,
    /// How a program will be written: the last updates are then made on what a control commands when it has read it. `None` where the
    /// control takes the reference itself.
    pub written: Option<RefitSettings>,
    /// Share of the cycle time that points with times of their own may cost before the program's feeds are kept.
    pub slowest: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            law: LawName::Virtual,
            iterations: 4,
            gain: 0.9,
            low_pass_hz: 100.0,
            max_shift: None,
            max_rotation_rad: CorrectionLimits::MAX_ROTATION_DEG.to_radians(),
            written: None,
            slowest: f64::INFINITY,
        }
    }
}

/// Largest correction, as a multiple of the largest error that there is to correct: a stop or a turn of a slow loop asks for more than its error.
const SHIFT_OF_ERROR: f64 = 2.0;
/// The least and the largest bound of corrections where none is given, mm.
const SHIFT_BOUND_MM: [f64; 2] = [0.1, 1.0];

/// The bound of corrections of the tool tip where none is given, mm: of a run that is corrected by `shifted_mm` already and has a largest error of `max_mm`.
#[must_use]
pub fn shift_bound(shifted_mm: f64, max_mm: f64) -> f64 {
    let [least, most] = SHIFT_BOUND_MM;
    (shifted_mm + SHIFT_OF_ERROR * max_mm).clamp(least, most)
}
