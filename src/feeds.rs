//! Feeds chosen by the forecast: slower where the predicted contour error exceeds a tolerance, and faster elsewhere to win the time back.

use anyhow::Result;
use gcode::FeedMode;
use models::Bundle;
use motion::Limits;

use crate::evaluate::{self, contour_errors};
use crate::learning::{self, Outcome, Settings, Watch};
use crate::pipeline::Part;

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
    pub part: Part,
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
    part: Part,
    outcome: Outcome,
    /// Largest predicted contour error of every move that counts, mm; zero of rapids.
    worst: Vec<f64>,
}

impl Trial {
    fn of(part: Part, bundle: &Bundle, limits: &Limits, settings: &Settings, watch: Watch) -> Result<Self> {
        let outcome = learning::compensate_watched(bundle, limits, &part.plan.desired, Some(&part), settings, watch)?;
        let mut worst = vec![0.0_f64; part.toolpath.moves.len()];
        for (k, error) in contour_errors(&part.plan.desired, &outcome.forecast)?.iter().enumerate() {
            if let Some(index) = part.move_at(k).filter(|_| evaluate::counts(Some(&part), k)) {
                worst[index] = worst[index].max(error.vector.norm());
            }
        }
        Ok(Self { part, outcome, worst })
    }

    fn seconds(&self) -> f64 {
        self.part.plan.desired.trajectory().duration_s()
    }

    /// Whether a move's feed is the program's to change: inverse time holds a duration, not a feed.
    fn adjustable(&self, index: usize) -> bool {
        let step = &self.part.toolpath.moves[index];
        let mode = self.part.toolpath.modal(step).feed_mode;
        self.part.is_shiftable(step) && step.feed_word.is_some() && mode != FeedMode::InverseTime
    }
}

/// Compensates `part` with feeds that keep the predicted contour error within the goal's tolerance.
///
/// An error grows with speed squared (centripetal and inertial forces) or less; a move above the tolerance is slowed by the root of the
/// ratio, and keeps its feed where that does not help. With `keep_time` the moves with room to spare are sped up afterwards.
///
/// # Errors
/// When a plan fails, or the model does not fit.
pub fn adjust(part: Part, bundle: &Bundle, limits: &Limits, settings: &Settings, goal: Goal, watch: Watch) -> Result<Adjusted> {
    let count = part.toolpath.moves.len();
    // What planning the written program anew changes from trial to trial would hide what a feed does.
    let wanted = settings;
    let settings = &Settings { written: None, ..*wanted };
    let mut trial = Trial::of(part, bundle, limits, settings, watch)?;
    let before_s = trial.seconds();
    let before_mm = trial.worst.iter().copied().fold(0.0, f64::max);
    let mut hopeless = vec![false; count];
    let mut slowed: Vec<Option<(f64, f64)>> = vec![None; count];
    let mut base = 1.0_f64;
    for _ in 0..ROUNDS {
        let mut factors = trial.part.feed_factors.clone();
        let mut changed = false;
        for index in (0..count).filter(|index| trial.adjustable(*index)) {
            let worst = trial.worst[index];
            if let Some((factor, error)) = slowed[index].take() {
                // What slowing promised was `1 − share`; far less says that speed is not the cause.
                let share = factors[index] / factor;
                if worst > goal.tolerance_mm && 1.0 - worst / error < LEAST_EFFECT * (1.0 - share) {
                    hopeless[index] = true;
                    factors[index] = factor;
                    changed = true;
                }
            }
            if worst > goal.tolerance_mm && !hopeless[index] && factors[index] > SLOWEST {
                slowed[index] = Some((factors[index], worst));
                let share = (0.95 * (goal.tolerance_mm / worst).sqrt()).clamp(0.5, 0.95);
                factors[index] = (factors[index] * share).max(SLOWEST);
                changed = true;
            }
        }
        let excess = trial.seconds() / before_s - 1.0;
        if goal.keep_time && !changed && excess > SAME_TIME && base < FASTEST {
            base = (base * (1.0 + 2.0 * excess).min(1.25)).min(FASTEST);
            for index in (0..count).filter(|index| trial.adjustable(*index)) {
                if trial.worst[index] < ROOM * goal.tolerance_mm && factors[index] >= 1.0 {
                    factors[index] = base;
                    changed = true;
                }
            }
        }
        if !changed {
            break;
        }
        trial = Trial::of(trial.part.with_feeds(factors, limits)?, bundle, limits, settings, watch)?;
    }
    let max_mm = (before_mm, trial.worst.iter().copied().fold(0.0, f64::max));
    let factors = &trial.part.feed_factors;
    let moves = (factors.iter().filter(|f| **f < 1.0).count(), factors.iter().filter(|f| **f > 1.0).count());
    let mut above: Vec<(usize, f64)> = (0..count)
        .filter(|index| trial.worst[*index] > goal.tolerance_mm)
        .map(|index| (trial.part.toolpath.moves[index].block as usize + 1, trial.worst[index]))
        .collect();
    above.sort_by(|a, b| b.1.total_cmp(&a.1));
    let cycle_s = (before_s, trial.seconds());
    let Trial { part, mut outcome, .. } = trial;
    if wanted.written.is_some() {
        outcome = learning::compensate_watched(bundle, limits, &part.plan.desired, Some(&part), wanted, watch)?;
    }
    Ok(Adjusted { cycle_s, moves, max_mm, above, part, outcome })
}
