//! The shortest cycle within a tolerance, and the least error within a cycle time.

use models::Bundle;

use super::adjusted::Adjusted;
use super::adjustment::{Adjustment, ROUNDS, wider};
use super::limits::FeedLimits;
use crate::error::Result;
use crate::model_based_ilc::Settings;
use crate::part::Part;
use crate::progress::Progress;

/// Tolerances in the search for the least error, from the error at the highest feeds down to this share of it, and trials for each of them.
const TOLERANCES: usize = 6;
const LEAST_TOLERANCE: f64 = 0.2;
const ROUNDS_EACH: usize = 2;
/// Tolerances below the least error found so far, and their ratio to it.
const REFINEMENTS: usize = 4;
const FINER: f64 = 0.95;

/// Compensates `part` with the feeds of the shortest cycle whose predicted contour error stays within `tolerance_mm`.
///
/// Feeds change within `limits`, and not above the speeds of the model's training data. Moves that exceed the tolerance whatever their feed
/// get the feed of their least error, no higher than programmed; [`Adjusted::above`] names them.
///
/// # Errors
/// When `limits` leave no feed to change, planning fails, or the path does not fit the model.
pub(super) fn fastest(
    part: Part,
    model: &Bundle,
    settings: &Settings,
    tolerance_mm: f64,
    limits: &FeedLimits,
    progress: Progress<'_>,
) -> Result<Adjusted> {
    let (mut task, mut trial) = Adjustment::begin(part, model, settings, limits, progress)?;
    task.search.prefer_short();
    if trial.max_mm() > tolerance_mm {
        trial = wider(&mut task.search, trial, tolerance_mm)?;
    }
    let at_bounds = task.at_bounds(trial)?;
    let search = &mut task.search;
    let mut trial = search.settle(at_bounds, tolerance_mm, ROUNDS)?;
    if trial.max_mm() > tolerance_mm
        && let Some(visit) = search.least_excess(tolerance_mm, f64::INFINITY).cloned()
    {
        trial = search.run_as(trial, &visit)?;
    }
    task.finish(trial, tolerance_mm)
}

/// Compensates `part` with the feeds of the least predicted MAX whose cycle takes at most `1 + change` times as long as programmed. The program at
/// its own feeds is one of the choices, also with all of the time left to the correction.
///
/// Where no feeds within `limits` are fast enough, the shortest cycle is taken; [`Adjusted::cycle_s`] shows it.
///
/// # Errors
/// As [`fastest`].
pub(super) fn within_time(
    part: Part,
    model: &Bundle,
    settings: &Settings,
    change: f64,
    limits: &FeedLimits,
    progress: Progress<'_>,
) -> Result<Adjusted> {
    let (mut task, mut trial) = Adjustment::begin(part, model, settings, limits, progress)?;
    let most_s = task.programmed_s * (1.0 + change);
    task.search.most_s = Some(most_s);
    if change > settings.cycle_limit {
        trial = task.search.run(trial.into_part()?)?;
    }
    let at_bounds = task.at_bounds(trial)?;
    let search = &mut task.search;
    let most_mm = at_bounds.max_mm();
    let mut trial = search.sweep(at_bounds, (most_mm, LEAST_TOLERANCE * most_mm), TOLERANCES, ROUNDS_EACH)?;
    for _ in 0..REFINEMENTS {
        let Some(least_mm) = search.least_max_mm(most_s) else { break };
        trial = search.settle(trial, FINER * least_mm, ROUNDS_EACH)?;
        if search.least_max_mm(most_s).is_none_or(|next_mm| next_mm >= least_mm) {
            break;
        }
    }
    if let Some(visit) = search.best_within(most_s).or_else(|| search.shortest()).cloned() {
        trial = search.run_as(trial, &visit)?;
    }
    task.finish(trial, f64::INFINITY)
}
