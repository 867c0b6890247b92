//! Feed adjustment from the forecast: lower feeds where the predicted contour error exceeds a tolerance, higher feeds
//! elsewhere to recover the cycle time.

use models::Bundle;

use super::adjusted::{Adjusted, above, changed_moves, chip_loads};
use super::limits::FeedLimits;
use super::trial::Trial;
use crate::error::Result;
use crate::model_based_ilc::Settings;
use crate::part::Part;
use crate::progress::Progress;

/// Largest number of iterations of planning, compensation and feed selection.
const MAX_ITERATIONS: usize = 8;
/// Lowest feed factor.
const MIN_FACTOR: f64 = 0.1;
/// Highest feed factor where none is stated.
const MAX_FACTOR: f64 = 2.0;
/// Least reduction of a move's error, as a share of the expected reduction, for which a lower feed is kept. Below it
/// speed is not the cause of the error.
const LEAST_EFFECT: f64 = 0.1;
/// Share of the tolerance below which the feed of a move may be raised.
const SPEED_UP_SHARE: f64 = 0.8;
/// Relative difference below which cycle times count as equal.
pub const SAME_TIME: f64 = 5e-4;

/// The tolerance, mm, and whether other feeds are raised until the cycle time is no longer than before.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tolerance {
    pub tolerance_mm: f64,
    pub keep_time: bool,
}

/// State of the search over all trials.
struct Search<'a> {
    goal: Tolerance,
    limits: &'a FeedLimits,
    before_s: f64,
    /// Moves whose error does not depend on speed.
    speed_independent: Vec<bool>,
    /// Factor and error, mm, of a move before its feed was last reduced.
    slowed: Vec<Option<(f64, f64)>>,
    /// Feed factor of moves whose error is clearly below the tolerance.
    speed_up: f64,
}

impl Search<'_> {
    /// Next feed factors; `None` when nothing changes.
    fn next(&mut self, trial: &Trial) -> Result<Option<Vec<f64>>> {
        let (part, worst_mm) = (trial.part()?, trial.worst_mm()?);
        let adjustable: Vec<usize> = (0..worst_mm.len()).filter(|index| self.limits.allows(part, *index)).collect();
        let mut factors = part.feed_factors.clone();
        let mut changed = false;
        for index in &adjustable {
            changed |= self.slow(*index, worst_mm[*index], &mut factors[*index]);
        }
        let excess = trial.planned_s() / self.before_s - 1.0;
        if self.goal.keep_time && !changed && excess > SAME_TIME && self.speed_up < MAX_FACTOR {
            self.speed_up = (self.speed_up * (1.0 + 2.0 * excess).min(1.25)).min(MAX_FACTOR);
            for index in adjustable {
                let raised = self.speed_up.min(self.limits.highest(part, index, MAX_FACTOR));
                if worst_mm[index] < SPEED_UP_SHARE * self.goal.tolerance_mm && factors[index] >= 1.0 && raised > factors[index] {
                    factors[index] = raised;
                    changed = true;
                }
            }
        }
        Ok(changed.then_some(factors))
    }

    /// Reduces the feed of a move whose error `worst`, mm, exceeds the tolerance, or restores it where the reduction
    /// had no effect. Returns whether the factor changed.
    fn slow(&mut self, index: usize, worst: f64, factor: &mut f64) -> bool {
        let mut changed = false;
        if let Some((before, error)) = self.slowed[index].take() {
            // The expected reduction is `1 − share`. A much smaller one shows that speed is not the cause.
            let share = *factor / before;
            if worst > self.goal.tolerance_mm && 1.0 - worst / error < LEAST_EFFECT * (1.0 - share) {
                self.speed_independent[index] = true;
                *factor = before;
                changed = true;
            }
        }
        if worst > self.goal.tolerance_mm && !self.speed_independent[index] && *factor > MIN_FACTOR {
            self.slowed[index] = Some((*factor, worst));
            let share = (0.95 * (self.goal.tolerance_mm / worst).sqrt()).clamp(0.5, 0.95);
            *factor = (*factor * share).max(MIN_FACTOR);
            changed = true;
        }
        changed
    }
}

/// Compensates `part` with feeds that keep the predicted contour error within the tolerance.
///
/// # Errors
/// When `limits` leave no feed to change, planning fails, or the path does not fit the model.
pub(super) fn slower(
    part: Part,
    model: &Bundle,
    settings: &Settings,
    goal: Tolerance,
    limits: &FeedLimits,
    progress: Progress<'_>,
) -> Result<Adjusted> {
    limits.check(&part)?;
    let count = part.toolpath.moves.len();
    // Replanning of the written program differs from trial to trial and would hide the effect of a feed.
    let unwritten = Settings { written: None, ..*settings };
    let mut trial = Trial::of(part, model, &unwritten, progress)?;
    let (before_s, before_mm) = (trial.planned_s(), trial.max_mm());
    let (speed_independent, slowed) = (vec![false; count], vec![None; count]);
    let mut search = Search { goal, limits, before_s, speed_independent, slowed, speed_up: 1.0 };
    for _ in 0..MAX_ITERATIONS {
        let Some(factors) = search.next(&trial)? else { break };
        trial = Trial::of(trial.into_part()?.with_feeds(factors)?, model, &unwritten, progress)?;
    }
    adjusted(trial, model, settings, (before_s, before_mm), goal, progress)
}

/// Result: the last trial, compensated in its output format, with the first trial's cycle time, s, and largest error,
/// mm.
fn adjusted(
    trial: Trial,
    model: &Bundle,
    settings: &Settings,
    (before_s, before_mm): (f64, f64),
    goal: Tolerance,
    progress: Progress<'_>,
) -> Result<Adjusted> {
    let cycle_s = (before_s, trial.planned_s());
    let trial = match settings.written {
        // What is written is judged.
        Some(_) => Trial::of(trial.into_part()?, model, settings, progress)?,
        None => trial,
    };
    let max_mm = (before_mm, trial.max_mm());
    let (part, worst_mm) = (trial.part()?, trial.worst_mm()?);
    let (moves, above, chip_loads) = (changed_moves(part), above(part, &worst_mm, goal.tolerance_mm), chip_loads(part));
    let Trial { input, outcome, .. } = trial;
    Ok(Adjusted { cycle_s, bounds: None, moves, max_mm, above, chip_loads, input, outcome })
}
