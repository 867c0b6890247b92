//! One iteration of learning on a real machine: the next reference from the last run.

use compensation::laws::{Gain, SpatialIlc, TrackingIlc};
use compensation::{CompensationLaw, CorrectionLimits, LowPass};
use datasets::Log;
use motion::Trajectory;

use crate::error::Result;
use crate::input::Input;
use crate::measure::{Match, in_path_time, match_run, without_approach};
use crate::model_based_ilc::shift_bound;
use crate::statistics::Figures;

/// What is learned from a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RefineLaw {
    /// The contour error (Papers A and B).
    Spatial,
    /// The tracking error.
    Tracking,
}

/// Cut-off of the zero-phase low-pass on an update where none is given, Hz.
pub const LOW_PASS_HZ: f64 = 100.0;

/// How much is learned from a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RefineSettings {
    /// What is learned.
    pub law: RefineLaw,
    /// Learning gain.
    pub gain: f64,
    /// Cut-off of the zero-phase low-pass on the update, Hz.
    pub low_pass_hz: f64,
    /// Largest correction of the tool tip, mm; that of [`shift_bound`] when `None`.
    pub max_shift: Option<f64>,
    /// Largest correction of the tool's direction, rad.
    pub max_rotation_rad: f64,
}

impl RefineSettings {
    /// The settings after the run with this number, from 1: gain 1/run averages the noise of the runs away.
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

/// The next run.
#[derive(Debug)]
pub struct Refined {
    /// Its reference.
    pub reference: Trajectory,
    /// Figures of the run before.
    pub before: Figures,
    /// Bound of the correction of the tool tip that was kept to, mm.
    pub max_shift: f64,
}

/// The next reference from a run of `reference` that came to `actual`, both in the time of `input`'s path.
///
/// # Errors
/// When the runs do not match the path, or a setting is out of range.
pub fn refine(input: &Input, reference: &Trajectory, actual: &Trajectory, settings: &RefineSettings) -> Result<Refined> {
    let desired = input.desired();
    let before = input.figures(actual)?;
    let low_pass = LowPass::new(settings.low_pass_hz, input.trajectory().period_s())?;
    let gain = Gain::Constant(settings.gain);
    let mut law: Box<dyn CompensationLaw> = match settings.law {
        RefineLaw::Spatial => Box::new(SpatialIlc::new(gain, low_pass)?),
        RefineLaw::Tracking => Box::new(TrackingIlc::new(gain, low_pass)),
    };
    let weights = input.part().map(|part| part.weights()).unwrap_or_default();
    let max_shift = settings.max_shift.unwrap_or_else(|| shift_bound(input.largest_shift(reference), before.tip.max_mm));
    let limits = input.limits().cloned();
    let guard = CorrectionLimits {
        max_shift,
        max_rotation_rad: settings.max_rotation_rad,
        limits,
        weights,
        ..CorrectionLimits::default()
    };
    let reference = guard.apply(desired, &law.update(desired, reference, actual)?)?;
    Ok(Refined { reference, before, max_shift })
}

/// As [`refine`], from the log of a run: its command says what was run. With how the log lies over the path.
///
/// # Errors
/// As [`refine`], and when the log is not of a run of the path.
pub fn refine_from_log(input: &Input, log: &Log, settings: &RefineSettings) -> Result<(Refined, Match)> {
    let desired = input.desired();
    desired.trajectory().check_axes(log.axes())?;
    let (log, _) = without_approach(log, desired)?;
    let matched = match_run(desired, &desired.tips_of(&log.reference)?, log.period_s())?;
    let (reference, actual) = in_path_time(desired, &log, &matched)?;
    Ok((refine(input, &reference, &actual, settings)?, matched))
}
