//! Lower feeds where the predicted contour error exceeds a tolerance.

use models::Bundle;

use super::adjusted::Adjusted;
use super::adjustment::{Adjustment, ROUNDS, wider};
use super::limits::FeedLimits;
use crate::error::Result;
use crate::model_based_ilc::Settings;
use crate::part::Part;
use crate::progress::Progress;

/// Highest feed factor where none is stated and time is to be won back.
const KEEPING_FACTOR: f64 = 2.0;
/// Relative difference below which cycle times count as equal.
pub const SAME_TIME: f64 = 5e-4;

/// Compensates `part` with lower feeds where the predicted contour error exceeds `tolerance_mm`. A correction that takes more time is tried first:
/// larger limits of the cycle time's increase, where `settings` state none. With `keep_time` other feeds rise, and the cycle takes no longer than
/// programmed; where that is not to be had, the shortest one.
///
/// # Errors
/// When `limits` leave no feed to change, planning fails, or the path does not fit the model.
pub(super) fn slower(
    part: Part,
    model: &Bundle,
    settings: &Settings,
    (tolerance_mm, keep_time): (f64, bool),
    limits: &FeedLimits,
    progress: Progress<'_>,
) -> Result<Adjusted> {
    let highest_factor = limits.highest_factor.or(keep_time.then_some(KEEPING_FACTOR)).filter(|_| keep_time);
    let limits = &FeedLimits { highest_factor, ..limits.clone() };
    let (mut task, mut trial) = Adjustment::begin(part, model, settings, limits, progress)?;
    if trial.max_mm() > tolerance_mm {
        let programmed_s = task.programmed_s;
        let search = &mut task.search;
        if keep_time {
            search.most_s = Some(programmed_s);
        } else {
            trial = wider(search, trial, tolerance_mm)?;
        }
        if trial.max_mm() > tolerance_mm {
            trial = search.settle(trial, tolerance_mm, ROUNDS)?;
        }
        let most_s = if keep_time { programmed_s * (1.0 + SAME_TIME) } else { f64::INFINITY };
        if (trial.max_mm() > tolerance_mm || keep_time)
            && let Some(visit) = search.least_excess(tolerance_mm, most_s).or_else(|| search.shortest()).cloned()
        {
            trial = search.run_as(trial, &visit)?;
        }
    }
    task.finish(trial, tolerance_mm)
}
