//! Feed adjustment from the forecast: lower feeds where the predicted contour error exceeds a tolerance, higher feeds
//! elsewhere to recover the cycle time.

use gcode::FeedMode;
use models::Bundle;

use crate::error::{Error, Result};
use crate::input::Input;
use crate::model_based_ilc::{Outcome, Settings, model_based_ilc};
use crate::part::Part;
use crate::progress::Progress;
use crate::statistics::{self, contour_errors};

/// Largest number of iterations of planning, compensation and feed selection.
const MAX_ITERATIONS: usize = 8;
/// Lowest feed factor.
const MIN_FACTOR: f64 = 0.1;
/// Highest feed factor.
const MAX_FACTOR: f64 = 2.0;
/// Least reduction of a move's error, as a share of the expected reduction, for which a lower feed is kept. Below it
/// speed is not the cause of the error.
const LEAST_EFFECT: f64 = 0.1;
/// Share of the tolerance below which the feed of a move may be raised.
const SPEED_UP_SHARE: f64 = 0.8;
/// Relative difference below which cycle times count as equal.
pub const SAME_TIME: f64 = 5e-4;

/// Goal of a feed adjustment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Goal {
    /// Largest predicted contour error, mm.
    pub tolerance_mm: f64,
    /// Raise other feeds until the cycle time is no longer than before.
    pub keep_time: bool,
}

/// Result of a feed adjustment.
#[derive(Debug)]
pub struct Adjusted {
    /// The program with its adjusted feeds.
    pub input: Input,
    /// Its compensation.
    pub outcome: Outcome,
    /// Cycle time before and after, s.
    pub cycle_s: (f64, f64),
    /// Number of moves with lower and with higher feeds than programmed.
    pub moves: (usize, usize),
    /// Largest predicted contour error of feed moves before and after the adjustment, both compensated, mm.
    pub max_mm: (f64, f64),
    /// Program lines, from 1, that exceed the tolerance, with their predicted error, mm; largest first.
    pub above: Vec<(usize, f64)>,
}

/// A planned and compensated program with its forecast.
struct Trial {
    input: Input,
    outcome: Outcome,
    /// Largest predicted contour error of every move, mm; zero for rapids.
    worst: Vec<f64>,
}

impl Trial {
    fn of(part: Part, model: &Bundle, settings: &Settings, progress: Progress<'_>) -> Result<Self> {
        let input = Input::from(part);
        let outcome = model_based_ilc(&input, model, settings, progress)?;
        let part = input.program()?;
        let mut worst = vec![0.0_f64; part.toolpath.moves.len()];
        for (k, error) in contour_errors(input.desired(), &outcome.forecast)?.iter().enumerate() {
            if let Some(index) = part.move_at(k).filter(|_| statistics::counts(Some(part), k)) {
                worst[index] = worst[index].max(error.vector.norm());
            }
        }
        Ok(Self { input, outcome, worst })
    }

    fn seconds(&self) -> f64 {
        self.input.trajectory().duration_s()
    }

    fn max_mm(&self) -> f64 {
        self.worst.iter().copied().fold(0.0, f64::max)
    }
}

/// Whether the feed of a move may be changed. A move in inverse time has a duration, not a feed.
fn is_adjustable(part: &Part, index: usize) -> bool {
    let step = &part.toolpath.moves[index];
    let mode = part.toolpath.modal(step).feed_mode;
    part.is_shiftable(step) && step.feed_word.is_some() && mode != FeedMode::InverseTime
}

/// State of the search over all trials.
struct Search {
    goal: Goal,
    before_s: f64,
    /// Moves whose error does not depend on speed.
    speed_independent: Vec<bool>,
    /// Factor and error, mm, of a move before its feed was last reduced.
    slowed: Vec<Option<(f64, f64)>>,
    /// Feed factor of moves whose error is clearly below the tolerance.
    speed_up: f64,
}

impl Search {
    /// Next feed factors; `None` when nothing changes.
    fn next(&mut self, trial: &Trial) -> Result<Option<Vec<f64>>> {
        let part = trial.input.program()?;
        let adjustable: Vec<usize> = (0..trial.worst.len()).filter(|index| is_adjustable(part, *index)).collect();
        let mut factors = part.feed_factors.clone();
        let mut changed = false;
        for index in &adjustable {
            changed |= self.slow(*index, trial.worst[*index], &mut factors[*index]);
        }
        let excess = trial.seconds() / self.before_s - 1.0;
        if self.goal.keep_time && !changed && excess > SAME_TIME && self.speed_up < MAX_FACTOR {
            self.speed_up = (self.speed_up * (1.0 + 2.0 * excess).min(1.25)).min(MAX_FACTOR);
            for index in adjustable {
                if trial.worst[index] < SPEED_UP_SHARE * self.goal.tolerance_mm && factors[index] >= 1.0 {
                    factors[index] = self.speed_up;
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
/// The error of a move grows at most with the square of its speed (centripetal and inertial forces). The feed of a move
/// above the tolerance is reduced by the square root of the ratio, and restored where that has no effect. With
/// `keep_time` the feeds of moves clearly below the tolerance are then raised.
///
/// # Errors
/// When planning fails, or the path does not fit the model.
pub fn adjust(part: Part, model: &Bundle, settings: &Settings, goal: Goal, progress: Progress<'_>) -> Result<Adjusted> {
    let count = part.toolpath.moves.len();
    // Replanning of the written program differs from trial to trial and would hide the effect of a feed.
    let unwritten = Settings { written: None, ..*settings };
    let mut trial = Trial::of(part, model, &unwritten, progress)?;
    let (before_s, before_mm) = (trial.seconds(), trial.max_mm());
    let (speed_independent, slowed) = (vec![false; count], vec![None; count]);
    let mut search = Search { goal, before_s, speed_independent, slowed, speed_up: 1.0 };
    for _ in 0..MAX_ITERATIONS {
        let Some(factors) = search.next(&trial)? else { break };
        let Input::Program(part) = trial.input else { return Err(Error::NoProgram) };
        trial = Trial::of(part.with_feeds(factors)?, model, &unwritten, progress)?;
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
    goal: Goal,
    progress: Progress<'_>,
) -> Result<Adjusted> {
    let (cycle_s, max_mm) = ((before_s, trial.seconds()), (before_mm, trial.max_mm()));
    let part = trial.input.program()?;
    let factors = &part.feed_factors;
    let moves = (factors.iter().filter(|f| **f < 1.0).count(), factors.iter().filter(|f| **f > 1.0).count());
    let worst = trial.worst.iter().zip(&part.toolpath.moves).filter(|(worst, _)| **worst > goal.tolerance_mm);
    let mut above: Vec<(usize, f64)> = worst.map(|(worst, step)| (step.block as usize + 1, *worst)).collect();
    above.sort_by(|a, b| b.1.total_cmp(&a.1));
    let Trial { input, mut outcome, .. } = trial;
    if settings.written.is_some() {
        outcome = model_based_ilc(&input, model, settings, progress)?;
    }
    Ok(Adjusted { cycle_s, moves, max_mm, above, input, outcome })
}
