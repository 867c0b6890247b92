//! The shortest cycle within a tolerance, and the least error within a cycle time.

use models::Bundle;

use super::adjusted::{Adjusted, Bounds, above, changed_moves, chip_loads, unlimited_s};
use super::limits::FeedLimits;
use super::search::Search;
use super::trial::{Trial, errors_mm};
use crate::error::Result;
use crate::model_based_ilc::{Settings, model_based_ilc};
use crate::part::Part;
use crate::progress::Progress;

/// Trials of the search for the shortest cycle in which factors rise and fall.
const ROUNDS: usize = 8;
/// Tolerances in the search for the least error, from the error at the highest feeds down to this share of it, and trials for each of them.
const TOLERANCES: usize = 6;
const LEAST_TOLERANCE: f64 = 0.2;
const ROUNDS_EACH: usize = 2;
/// Tolerances below the least error found so far, and their ratio to it.
const REFINEMENTS: usize = 4;
const FINER: f64 = 0.95;
/// Highest feed factor where none is stated and time is to be won back.
const KEEPING_FACTOR: f64 = 2.0;
/// Relative difference below which cycle times count as equal.
pub const SAME_TIME: f64 = 5e-4;
/// Relative increase of the cycle time that a program of fewer points may have.
const SAME_CYCLE: f64 = 2e-3;

/// Compensates `part` with the feeds of the shortest cycle whose predicted contour error stays within `tolerance_mm`.
///
/// Feeds change within `limits`, and not above the speeds of the model's training data. Moves that exceed the tolerance whatever their feed
/// get the feed of their least error; [`Adjusted::above`] names them.
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
    let (mut search, before, programmed) = begin(part, model, settings, limits, progress)?;
    let at_bounds = search.run_at_bounds(programmed)?;
    let before = before.with_bounds(&at_bounds);
    let trial = search.settle(at_bounds, tolerance_mm, ROUNDS)?;
    finish(trial, &before, tolerance_mm, model, settings, progress)
}

/// Compensates `part` with lower feeds where the predicted contour error exceeds `tolerance_mm`. A correction that takes more time is tried first:
/// larger limits of the cycle time's increase, where `settings` state none. With `keep_time` other feeds rise, and the cycle takes no longer than
/// programmed; where that is not to be had, the shortest one.
///
/// # Errors
/// As [`fastest`].
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
    let (mut search, before, mut trial) = begin(part, model, settings, limits, progress)?;
    if trial.max_mm() > tolerance_mm {
        if keep_time {
            search.most_s = Some(before.cycle_s);
        } else {
            trial = wider(&mut search, trial, tolerance_mm)?;
        }
        if trial.max_mm() > tolerance_mm {
            trial = search.settle(trial, tolerance_mm, ROUNDS)?;
        }
        let most_s = if keep_time { before.cycle_s * (1.0 + SAME_TIME) } else { f64::INFINITY };
        if (trial.max_mm() > tolerance_mm || keep_time)
            && let Some(visit) = search.least_excess(tolerance_mm, most_s).cloned()
        {
            trial = search.run_as(trial, &visit)?;
        }
    }
    let settings = &Settings { cycle_limit: search.last_limit(), ..*settings };
    finish(trial, &before, tolerance_mm, model, settings, progress)
}

/// Trials at the programmed feeds with larger limits of the correction's increase of the cycle time, until one keeps the tolerance. Takes the limit of
/// the least error for what follows.
fn wider(search: &mut Search<'_>, mut trial: Trial, tolerance_mm: f64) -> Result<Trial> {
    for cycle_limit in search.cycle_limits().into_iter().skip(1) {
        if trial.max_mm() <= tolerance_mm {
            break;
        }
        trial = search.run_within(trial.into_part()?, Some(cycle_limit))?;
    }
    if trial.max_mm() > tolerance_mm
        && let Some(best) = search.least_excess(tolerance_mm, f64::INFINITY).cloned()
    {
        trial = search.run_as(trial, &best)?;
    }
    search.limit(search.last_limit());
    Ok(trial)
}

/// Compensates `part` with the feeds of the least predicted MAX whose cycle takes at most `1 + change` times as long as programmed.
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
    let (mut search, before, programmed) = begin(part, model, settings, limits, progress)?;
    let most_s = before.cycle_s * (1.0 + change);
    search.most_s = Some(most_s);
    // With all of the time left to the correction.
    let programmed = if change > settings.cycle_limit { search.run(programmed.into_part()?)? } else { programmed };
    let at_bounds = search.run_at_bounds(programmed)?;
    let before = before.with_bounds(&at_bounds);
    let most_mm = at_bounds.max_mm();
    let mut trial = search.sweep(at_bounds, (most_mm, LEAST_TOLERANCE * most_mm), TOLERANCES, ROUNDS_EACH)?;
    for _ in 0..REFINEMENTS {
        let Some(least_mm) = search.least_max_mm(most_s) else { break };
        trial = search.settle(trial, FINER * least_mm, ROUNDS_EACH)?;
        if search.least_max_mm(most_s).is_none_or(|next_mm| next_mm >= least_mm) {
            break;
        }
    }
    let shortest = || search.visits.iter().min_by(|a, b| a.cycle_s.total_cmp(&b.cycle_s));
    if let Some(visit) = search.best_within(most_s).or_else(shortest).cloned() {
        trial = search.run_as(trial, &visit)?;
    }
    let settings = &Settings { cycle_limit: search.last_limit(), ..*settings };
    finish(trial, &before, f64::INFINITY, model, settings, progress)
}

/// What a program comes to at its programmed feeds, and the bounds of its cycle.
struct Before {
    cycle_s: f64,
    max_mm: f64,
    machine_s: f64,
    bounds: Option<Bounds>,
}

impl Before {
    /// The same with the bounds of the cycle.
    fn with_bounds(self, at_bounds: &Trial) -> Self {
        Self { bounds: Some(Bounds { allowed_s: at_bounds.planned_s(), machine_s: self.machine_s }), ..self }
    }
}

/// Begins a search: a trial at the programmed feeds.
fn begin<'a>(
    part: Part,
    model: &'a Bundle,
    settings: &Settings,
    limits: &FeedLimits,
    progress: Progress<'a>,
) -> Result<(Search<'a>, Before, Trial)> {
    let programmed_s = part.plan.desired.trajectory().duration_s();
    let allowed: Vec<bool> = (0..part.toolpath.moves.len()).map(|index| limits.allows(&part, index)).collect();
    let (part, machine_s) = unlimited_s(part, |index| allowed[index])?;
    let (search, trial) = Search::begin(part, model, settings, limits, progress)?;
    let max_mm = trial.max_mm();
    Ok((search, Before { cycle_s: programmed_s, max_mm, machine_s, bounds: None }, trial))
}

/// The result of a search, learned with `settings` where that neither exceeds the tolerance nor takes longer.
fn finish(
    trial: Trial,
    before: &Before,
    tolerance_mm: f64,
    model: &Bundle,
    settings: &Settings,
    progress: Progress<'_>,
) -> Result<Adjusted> {
    let (cycle_s, max_mm) = (trial.cycle_s(), trial.max_mm());
    let Trial { input, mut outcome, errors_mm: mut errors } = trial;
    if settings.written.is_some() {
        let whole = model_based_ilc(&input, model, settings, progress)?;
        let of_whole = errors_mm(&input, &whole)?;
        let is_short = whole.cycle_s.is_some_and(|(_, after_s)| after_s <= cycle_s * (1.0 + SAME_CYCLE));
        if is_short && of_whole.iter().all(|error| *error <= tolerance_mm.min(max_mm)) {
            (outcome, errors) = (whole, of_whole);
        }
    }
    let trial = Trial { input, outcome, errors_mm: errors };
    let (cycle_s, max_mm, worst_mm) = (trial.cycle_s(), trial.max_mm(), trial.worst_mm()?);
    let part = trial.part()?;
    Ok(Adjusted {
        cycle_s: (before.cycle_s, cycle_s),
        bounds: before.bounds,
        moves: changed_moves(part),
        max_mm: (before.max_mm, max_mm),
        above: above(part, &worst_mm, tolerance_mm),
        chip_loads: chip_loads(part),
        input: trial.input,
        outcome: trial.outcome,
    })
}
