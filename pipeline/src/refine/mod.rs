//! Refinement: learning on a real machine, from its runs to the next reference.
//!
//! [`learn_from_runs`] learns by the model of the machine, from all runs so far. [`refine_from_run`] makes one ILC iteration without a model,
//! from a recorded run; [`refine`] takes its positions in the path's time.

mod aligned;
mod compensated;
mod decision;
mod learning;
mod observed;
mod repeated;

use compensation::laws::{Gain, SpatialIlc, TrackingIlc};
use compensation::{CompensationLaw, CorrectionLimits, LowPass};
use motion::Trajectory;

use crate::error::Result;
use crate::input::Input;
use crate::model_based_ilc::shift_bound;
use crate::statistics::Figures;

pub use aligned::Aligned;
pub use compensated::{command_apart_mm, is_compensated};
pub use decision::{Ended, Expected, best_of, last_is_worse};
pub use learning::{Learning, learn_from_runs};
pub use observed::ObservedRun;

/// Error that the refinement learns from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RefineLaw {
    /// Contour error (Papers A and B).
    Spatial,
    /// Tracking error.
    Tracking,
}

/// Default cut-off of the zero-phase low-pass on an update, Hz.
pub const LOW_PASS_HZ: f64 = 100.0;

/// Settings of a refinement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RefineSettings {
    /// Error that the law learns from.
    pub law: RefineLaw,
    /// Learning gain.
    pub gain: f64,
    /// Cut-off of the zero-phase low-pass on the update, Hz.
    pub low_pass_hz: f64,
    /// Largest correction of the tool tip, mm; `None` takes [`shift_bound`].
    pub max_shift: Option<f64>,
    /// Largest correction of the tool orientation, rad.
    pub max_rotation_rad: f64,
}

impl RefineSettings {
    /// Settings after run number `run`, from 1. The gain 1/run averages the noise of the runs.
    #[must_use]
    pub fn of_run(run: u32) -> Self {
        Self {
            law: RefineLaw::Spatial,
            gain: 1.0 / f64::from(run),
            low_pass_hz: LOW_PASS_HZ,
            max_shift: None,
            max_rotation_rad: CorrectionLimits::MAX_ROTATION_DEG.to_radians(),
        }
    }
}

/// Result of a refinement.
#[derive(Debug)]
pub struct Refined {
    /// Reference of the next run.
    pub reference: Trajectory,
    /// Figures of the last run.
    pub before: Figures,
    /// Bound of the correction of the tool tip, mm.
    pub max_shift: f64,
}

/// Computes the next reference from a run with command `reference` and positions `actual`, both in the time of the
/// path.
///
/// # Errors
/// When the runs do not match the path, or a setting is out of range.
pub fn refine(input: &Input, reference: &Trajectory, actual: &Trajectory, settings: &RefineSettings) -> Result<Refined> {
    input.check_original()?;
    let desired = input.desired();
    let before = input.figures(actual)?;
    let low_pass = LowPass::new(settings.low_pass_hz, input.trajectory().period_s())?;
    let gain = Gain::Constant(settings.gain);
    let mut law: Box<dyn CompensationLaw> = match settings.law {
        RefineLaw::Spatial => Box::new(SpatialIlc::new(gain, low_pass)?),
        RefineLaw::Tracking => Box::new(TrackingIlc::new(gain, low_pass)),
    };
    let weights = input.part().map(|part| part.taper()).unwrap_or_default();
    let max_shift = settings.max_shift.unwrap_or_else(|| shift_bound(input.largest_shift(reference), before.tip.max_mm));
    let correction_limits = input.correction_limits(max_shift, settings.max_rotation_rad, weights);
    let reference = correction_limits.apply(desired, &law.update(desired, reference, actual)?)?;
    Ok(Refined { reference, before, max_shift })
}

/// Same as [`refine`], from a recorded run, whose command is the reference.
///
/// # Errors
/// As [`refine`].
pub fn refine_from_run(input: &Input, run: &Aligned, settings: &RefineSettings) -> Result<Refined> {
    Ok(Refined { before: run.figures, ..refine(input, &run.command, &run.actual, settings)? })
}
