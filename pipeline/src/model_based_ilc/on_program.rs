//! Iteration on the replanned program, and the choice of its points.

use compensation::{Iteration, LowPass, StopRule};
use machine::Machine;
use models::LearnedMachine;
use motion::Trajectory;

use super::acceptance::{SAME_FORECAST, cost};
use super::laws::spatial;
use super::settings::{FewerPoints, LawName, Settings};
use super::task::{Runs, Task};
use crate::control::ControlledMachine;
use crate::error::Result;
use crate::input::Input;
use crate::refit::{RefitSettings, TimeEncoding};
use crate::statistics::Figures;

/// Updates on the replanned program for each update on the reference, and largest number of consecutive updates without improvement.
const REPLANNED_UPDATES: usize = 3;
const REPLANNED_PATIENCE: usize = 4;
/// The same after the first choice of points: the start is nearly learned.
const COARSER_UPDATES: usize = 5;
const COARSER_PATIENCE: usize = 2;
/// Largest number of replanned samples over all updates, and least number of updates for a program of hours: replanning takes most of the
/// time.
const REPLANNED_SAMPLES: usize = 12_000_000;
const LEAST_REPLANNED: usize = 2;
/// Gain and cut-off, Hz, of updates on the replanned program. Corrections above the cut-off become kinks, at which a control slows down.
const REPLANNED_GAIN: f64 = 0.7;
const REPLANNED_LOW_PASS_HZ: f64 = 40.0;

/// Increase of the cost for which fewer points are taken: a share, and mm.
const COST_OF_FEWER: (f64, f64) = (0.02, 2e-5);
/// Cost of the first run with fewer points, as a multiple of what is allowed, from which on further updates are not tried.
const HOPELESS: f64 = 2.0;
/// Increase of the cycle time of the first run, as a multiple of its limit, from which on the points are not tried.
const HOPELESS_CYCLE: f64 = 4.0;
/// Largest number of doublings of the time between points, and of the chord tolerance.
const DOUBLINGS: usize = 4;

/// Candidate for the result, on the feed profile that the control uses.
#[derive(Default)]
pub(super) struct OnProgram {
    pub(super) run: Option<(Iteration, Figures)>,
    /// Updates so far, on the reference and on the replanned program.
    pub(super) updates: usize,
    /// Cycle time before and after, s, where the control replans the program.
    pub(super) cycle_s: Option<(f64, f64)>,
    /// Relative increase of the cycle time by timed points, where it is too large and the program therefore keeps its feeds.
    pub(super) kept_feeds: Option<f64>,
    /// Least relative increase of the cycle time that was found, where it is beyond its limit whatever the points.
    pub(super) too_slow: Option<f64>,
    /// Settings of the points, where the control replans the program.
    pub(super) written: Option<RefitSettings>,
}

/// A run of the program with these points, and its cycle time.
struct Candidate {
    run: (Iteration, Figures),
    cycle_s: f64,
    written: RefitSettings,
}

/// What came of points: a candidate, or the relative increase of the cycle time beyond its limit.
enum Tried {
    Runs(Box<Candidate>),
    TooSlow(f64),
}

/// Continues the iteration from `ideal`, the best run on the reference, on the replanned program. The points are as few as the forecast
/// allows; the cycle stays within its limit. With the command of an earlier run, `resumed`, the iteration also continues from there, and the
/// better result is taken.
pub(super) fn relearn_on_program(
    task: &Task<'_>,
    control: &mut ControlledMachine<'_, LearnedMachine>,
    input: &Input,
    settings: &Settings,
    written: RefitSettings,
    ideal: Iteration,
    resumed: Option<&Trajectory>,
) -> Result<OnProgram> {
    let mut search = Search { task, control, path: input.trajectory(), settings, ideal, updates: 0 };
    let mut kept_feeds = None;
    let mut found = search.points(written)?;
    if let Tried::TooSlow(slowdown) = found
        && written.encoding != TimeEncoding::Keep
        && search.control.replans(RefitSettings { encoding: TimeEncoding::Keep, ..written })
    {
        kept_feeds = Some(slowdown);
        found = search.points(RefitSettings { encoding: TimeEncoding::Keep, ..written })?;
    }
    if let Some(command) = resumed {
        found = search.resume(found, command)?;
    }
    let updates = search.updates;
    Ok(match found {
        Tried::Runs(found) => OnProgram {
            run: Some(found.run),
            updates,
            cycle_s: Some((input.trajectory().duration_s(), found.cycle_s)),
            kept_feeds,
            written: Some(found.written),
            ..OnProgram::default()
        },
        Tried::TooSlow(slowdown) => OnProgram { updates, too_slow: Some(slowdown), ..OnProgram::default() },
    })
}

/// Search of the fewest points.
struct Search<'a, 'b, 'm> {
    task: &'a Task<'b>,
    control: &'a mut ControlledMachine<'m, LearnedMachine>,
    path: &'a Trajectory,
    settings: &'a Settings,
    ideal: Iteration,
    updates: usize,
}

impl Search<'_, '_, '_> {
    /// Doubles the time between points, then the chord tolerance, for as long as the cost stays within [`COST_OF_FEWER`] of the least one,
    /// and the former also until the cycle is short enough.
    fn points(&mut self, written: RefitSettings) -> Result<Tried> {
        let mut best = self.learn(written, None, f64::INFINITY)?;
        let mut least = measure_of(&best);
        let fewer = if written.spacing_s.is_finite() { self.settings.fewer_points } else { FewerPoints::Never };
        let finer = |at: RefitSettings| RefitSettings { spacing_s: 2.0 * at.spacing_s, ..at };
        let looser = |at: RefitSettings| RefitSettings { chord_tolerance_mm: 2.0 * at.chord_tolerance_mm, ..at };
        let steps: [&dyn Fn(RefitSettings) -> RefitSettings; 2] = [&finer, &looser];
        let mut at = written;
        for step in steps.into_iter().filter(|_| fewer != FewerPoints::Never) {
            for _ in 0..DOUBLINGS {
                if fewer == FewerPoints::WhereTooSlow && matches!(best, Tried::Runs(_)) {
                    break;
                }
                let (start, allowed) = match &best {
                    Tried::Runs(best) => (Some(best.run.0.reference.clone()), allowed(least)),
                    Tried::TooSlow(_) => (None, f64::INFINITY),
                };
                let next = self.learn(step(at), start, allowed)?.or_shorter(&best);
                if measure_of(&next) > allowed {
                    break;
                }
                at = step(at);
                least = least.min(measure_of(&next));
                best = next;
            }
        }
        Ok(best)
    }

    /// The better one of `found` and what is learned with the same points from the command of an earlier run.
    fn resume(&mut self, found: Tried, command: &Trajectory) -> Result<Tried> {
        let Tried::Runs(candidate) = &found else { return Ok(found) };
        let resumed = self.learn(candidate.written, Some(command.clone()), f64::INFINITY)?;
        Ok(if measure_of(&resumed) < measure_of(&found) { resumed } else { found })
    }

    /// Learns on the program with these points from `start`, or from the best reference. Gives up where a cost of `allowed` mm is out of
    /// reach.
    fn learn(&mut self, written: RefitSettings, start: Option<Trajectory>, allowed: f64) -> Result<Tried> {
        self.control.replans(written);
        let (is_ideal, is_first) = (start.is_none(), allowed.is_infinite());
        let reference = start.unwrap_or_else(|| self.ideal.reference.clone());
        let seen = self.control.run(&reference)?;
        let cycle_s = self.control.last_s();
        let figures = self.task.figures(&self.task.errors(&seen)?)?;
        let measure = cost(&figures);
        let slowdown = self.slowdown(cycle_s);
        if slowdown > HOPELESS_CYCLE * self.settings.cycle_limit {
            return Ok(Tried::TooSlow(slowdown));
        }
        // The papers' laws are not iterated again; only their forecast is that of the replanned program.
        let is_same = is_ideal && (measure / self.ideal.measure - 1.0).abs() <= SAME_FORECAST;
        let iterates = self.settings.law == LawName::ModelBased && !is_same && measure <= HOPELESS * allowed;
        let first = (Iteration { reference: reference.clone(), actual: seen, measure }, figures);
        if !iterates {
            return Ok(self.best(vec![first], &[cycle_s], written));
        }
        let from = self.control.durations_s().len();
        let runs = self.iterate(reference, is_first)?;
        let durations_s = self.control.durations_s()[from..].to_vec();
        Ok(self.best(runs, &durations_s, written))
    }

    fn iterate(&mut self, start: Trajectory, is_first: bool) -> Result<Runs> {
        let mut law = spatial(REPLANNED_GAIN, LowPass::new(REPLANNED_LOW_PASS_HZ, self.path.period_s())?)?;
        let affordable = (REPLANNED_SAMPLES / self.path.len().max(1)).max(LEAST_REPLANNED);
        let (updates, patience) = if is_first {
            (affordable.min(REPLANNED_UPDATES * self.settings.iterations), REPLANNED_PATIENCE)
        } else {
            (affordable.min(COARSER_UPDATES), COARSER_PATIENCE)
        };
        let runs = self.task.iterate(self.control, &mut law, Some(start), StopRule { updates, patience, worth: 0.0 })?;
        self.updates += runs.len() - 1;
        Ok(runs)
    }

    /// The run of the least cost among those whose cycle is short enough.
    fn best(&self, runs: Runs, durations_s: &[f64], written: RefitSettings) -> Tried {
        let timed = runs.into_iter().zip(durations_s.iter().copied());
        let (short, long): (Vec<_>, Vec<_>) =
            timed.partition(|(_, cycle_s)| self.slowdown(*cycle_s) <= self.settings.cycle_limit);
        let least = short.into_iter().min_by(|((a, _), _), ((b, _), _)| a.measure.total_cmp(&b.measure));
        match least {
            Some((run, cycle_s)) => Tried::Runs(Box::new(Candidate { run, cycle_s, written })),
            None => Tried::TooSlow(long.iter().map(|(_, cycle_s)| self.slowdown(*cycle_s)).fold(f64::INFINITY, f64::min)),
        }
    }

    /// Relative increase of the cycle time.
    fn slowdown(&self, cycle_s: f64) -> f64 {
        cycle_s / self.path.duration_s() - 1.0
    }
}

impl Tried {
    /// The same; where both are too slow, the shorter cycle of both.
    fn or_shorter(self, other: &Self) -> Self {
        match (self, other) {
            (Self::TooSlow(own), Self::TooSlow(other)) => Self::TooSlow(own.min(*other)),
            (found, _) => found,
        }
    }
}

fn measure_of(tried: &Tried) -> f64 {
    match tried {
        Tried::Runs(candidate) => candidate.run.0.measure,
        Tried::TooSlow(_) => f64::INFINITY,
    }
}

/// Largest cost of a program with fewer points, mm, where the least one is `least`.
fn allowed(least: f64) -> f64 {
    let (share, more) = COST_OF_FEWER;
    (least * (1.0 + share)).max(least + more)
}
