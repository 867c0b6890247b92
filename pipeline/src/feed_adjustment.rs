//! Feeds chosen by the forecast: slower where the predicted contour error exceeds a tolerance, and faster elsewhere to win the time back.

use gcode::FeedMode;
use models::Bundle;

use crate::error::{Error, Result};
use crate::input::Input;
use crate::model_based_ilc::{Outcome, Settings, model_based_ilc};
use crate::part::Part;
use crate::progress::Progress;
use crate::statistics::{self, contour_errors};

/// Rounds of planning, compensating and choosing.
const ROUNDS: usize = 8;
/// No feed becomes less than this share of the programmed one.
const SLOWEST: f64 = 0.1;
/// No feed becomes more than this multiple of the programmed one.
const FASTEST: f64 = 2.0;
/// A slower feed has to lower a move's error by this share of what speed would, or the move keeps its feed: the error is not one of speed.
const LEAST_EFFECT: f64 = 0.1;
/// Share of the tolerance up to which a move may be sped up.
const ROOM: f64 = 0.8;
/// Cycle times that differ by less than this share are the same.
pub const SAME_TIME: f64 = 5e-4;

/// What is wanted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Goal {
    /// Largest predicted contour error, mm.
    pub tolerance_mm: f64,
    /// Raise feeds elsewhere until the cycle takes no longer than before.
    pub keep_time: bool,
}

/// What came out.
#[derive(Debug)]
pub struct Adjusted {
    /// The program with its feeds.
    pub input: Input,
    /// Its compensation.
    pub outcome: Outcome,
    /// Cycle time before and after, s.
    pub cycle_s: (f64, f64),
    /// Moves that are slower than programmed, and that are faster.
    pub moves: (usize, usize),
    /// Largest predicted contour error of feed moves, mm, before and after feeds were changed; both compensated.
    pub max_mm: (f64, f64),
    /// Lines that stay above the tolerance, with their predicted error, mm; worst first.
    pub above: Vec<(usize, f64)>,
}

/// A plan with its forecast.
struct Trial {
    input: Input,
    outcome: Outcome,
    /// Largest predicted contour error of every move that counts, mm; zero of rapids.
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

/// Whether a move's feed is the program's to change: inverse time holds a duration, not a feed.
fn is_adjustable(part: &Part, index: usize) -> bool {
    let step = &part.toolpath.moves[index];
    let mode = part.toolpath.modal(step).feed_mode;
    part.is_shiftable(step) && step.feed_word.is_some() && mode != FeedMode::InverseTime
}

/// What is known of every move from the trials so far.
struct Search {
    goal: Goal,
    before_s: f64,
    /// Moves whose error is not one of speed.
    hopeless: Vec<bool>,
    /// Factor and error, mm, before a move was slowed last.
    slowed: Vec<Option<(f64, f64)>>,
    /// What moves with room to spare are sped up by.
    speed_up: f64,
}

impl Search {
    /// The next factors; `None` where nothing is left to change.
    fn next(&mut self, trial: &Trial) -> Result<Option<Vec<f64>>> {
        let part = trial.input.program()?;
        let adjustable: Vec<usize> = (0..trial.worst.len()).filter(|index| is_adjustable(part, *index)).collect();
        let mut factors = part.feed_factors.clone();
        let mut changed = false;
        for index in &adjustable {
            changed |= self.slow(*index, trial.worst[*index], &mut factors[*index]);
        }
        let excess = trial.seconds() / self.before_s - 1.0;
        if self.goal.keep_time && !changed && excess > SAME_TIME && self.speed_up < FASTEST {
            self.speed_up = (self.speed_up * (1.0 + 2.0 * excess).min(1.25)).min(FASTEST);
            for index in adjustable {
                if trial.worst[index] < ROOM * self.goal.tolerance_mm && factors[index] >= 1.0 {
                    factors[index] = self.speed_up;
                    changed = true;
                }
            }
        }
        Ok(changed.then_some(factors))
    }

    /// Slows a move whose error, mm, is above the tolerance, or takes that back where it did not help. Whether the factor changed.
    fn slow(&mut self, index: usize, worst: f64, factor: &mut f64) -> bool {
        let mut changed = false;
        if let Some((before, error)) = self.slowed[index].take() {
            // What slowing promised was `1 − share`; far less says that speed is not the cause.
            let share = *factor / before;
            if worst > self.goal.tolerance_mm && 1.0 - worst / error < LEAST_EFFECT * (1.0 - share) {
                self.hopeless[index] = true;
                *factor = before;
                changed = true;
            }
        }
        if worst > self.goal.tolerance_mm && !self.hopeless[index] && *factor > SLOWEST {
            self.slowed[index] = Some((*factor, worst));
            let share = (0.95 * (self.goal.tolerance_mm / worst).sqrt()).clamp(0.5, 0.95);
            *factor = (*factor * share).max(SLOWEST);
            changed = true;
        }
        changed
    }
}

/// Compensates `part` with feeds that keep the predicted contour error within the goal's tolerance.
///
/// An error grows with speed squared (centripetal and inertial forces) or less; a move above the tolerance is slowed by the root of the
/// ratio, and keeps its feed where that does not help. With `keep_time` the moves with room to spare are sped up afterwards.
///
/// # Errors
/// When a plan fails, or the model does not fit.
pub fn adjust(part: Part, model: &Bundle, settings: &Settings, goal: Goal, progress: Progress<'_>) -> Result<Adjusted> {
    let count = part.toolpath.moves.len();
    // What planning the written program anew changes from trial to trial would hide what a feed does.
    let unwritten = Settings { written: None, ..*settings };
    let mut trial = Trial::of(part, model, &unwritten, progress)?;
    let (before_s, before_mm) = (trial.seconds(), trial.max_mm());
    let (hopeless, slowed) = (vec![false; count], vec![None; count]);
    let mut search = Search { goal, before_s, hopeless, slowed, speed_up: 1.0 };
    for _ in 0..ROUNDS {
        let Some(factors) = search.next(&trial)? else { break };
        let Input::Program(part) = trial.input else { return Err(Error::NoProgram) };
        trial = Trial::of(part.with_feeds(factors)?, model, &unwritten, progress)?;
    }
    adjusted(trial, model, settings, (before_s, before_mm), goal, progress)
}

/// The last trial, compensated as it is written, beside the first one's cycle time, s, and largest error, mm.
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
