//! Learning on a machine, with every run judged.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

use compensation::laws::ContourOptimal;
use compensation::{
    CompensationError, CompensationLaw, CorrectionLimits, CutOffCandidates, Descent, Ended, ImpulseResponse, Iteration, StopRule,
    descend, learn, spatial_candidates,
};
use machine::{Machine, MachineError};
use motion::{DesiredPath, Trajectory};

use super::acceptance::cost;
use crate::error::{Error, Result};
use crate::input::Input;
use crate::part::Part;
use crate::progress::{Event, Progress};
use crate::statistics::{self, Figures};

/// Least and largest time within which a turn or a stop hands over from the contour error to the tracking error, s: by how much the model's response comes late,
/// but as long as the shortest of servos and no longer than the slowest.
const TURN_RANGE_S: [f64; 2] = [0.01, 0.1];
/// Time after which a model's response counts as over, s: that of a slow integrator; a response that ends before is cut there.
const MODEL_RESPONSE_S: f64 = 0.4;
/// Runs of the Gauss–Newton steps from the best run so far, for every iteration asked for: a step takes one, or two where part of it is taken back.
const STEPS: usize = 3;
/// Updates of the spatial law with one cut-off where Gauss–Newton steps follow: the first two bring all but a tenth of what it gains.
const SPATIAL_UPDATES: usize = 2;
/// Most cut-offs that are tried, and samples of all of them together: a program of hours keeps the first.
const CUT_OFFS: usize = 5;
const LADDER_SAMPLES: usize = 400_000;
/// Samples up to which Gauss–Newton steps are made: they hold some thirty columns as long as the path.
const STEPS_SAMPLES: usize = 400_000;

/// Runs on a machine, each with its figures.
pub(super) type Runs = Vec<(Iteration, Figures)>;

/// What is learned, and within which bounds.
pub(super) struct Task<'a> {
    input: &'a Input,
    guard: CorrectionLimits,
    /// Forecast at which nothing is gained by going on, mm.
    floor_mm: f64,
    progress: Progress<'a>,
    cancelled: AtomicBool,
    /// The samples by which runs are judged; all where there is no program.
    judged: Option<Vec<bool>>,
}

/// The samples of a part's plan that its runs are judged by: those that may be changed, or those of all feed moves where none may.
fn judged(part: &Part) -> Vec<bool> {
    let samples = 0..part.plan.samples.len();
    let changeable: Vec<bool> = samples.clone().map(|k| part.shiftable_at(k)).collect();
    if changeable.contains(&true) { changeable } else { samples.map(|k| part.feeds_at(k)).collect() }
}

impl<'a> Task<'a> {
    pub fn new(input: &'a Input, guard: CorrectionLimits, floor_mm: f64, progress: Progress<'a>) -> Self {
        Self { input, guard, floor_mm, progress, cancelled: AtomicBool::new(false), judged: input.part().map(judged) }
    }

    /// What a run is judged by: the moves that may be changed. What has to stay as it is must not keep the rest from being corrected.
    pub fn figures(&self, actual: &Trajectory) -> Result<Figures> {
        let counts = |k: &usize| self.judged.as_ref().is_none_or(|judged| judged[*k]);
        statistics::figures_where(self.input.desired(), actual, counts)
    }

    /// The cost of a run; its figures are kept in `known`, and reported as one of at most `most`.
    fn judge(&self, actual: &Trajectory, known: &mut Vec<Result<Figures>>, most: usize) -> f64 {
        known.push(self.figures(actual));
        let cost_mm = known.last().and_then(|figures| figures.as_ref().ok()).map_or(f64::INFINITY, cost);
        let event = Event::Forecast { number: known.len(), most: known.len().max(most), cost_mm };
        if (self.progress)(event) == ControlFlow::Break(()) {
            self.cancelled.store(true, Ordering::Relaxed);
        }
        cost_mm
    }

    /// The spatial law with the cut-off that makes the best forecast, then Gauss–Newton steps on the contour error from there, where the axes are
    /// coordinates of the tip: every run with its figures, and why the steps ended. Times of turns and stops are the machine's own response's.
    pub fn descend(&mut self, machine: &mut dyn Machine, iterations: usize) -> Result<(Runs, Option<Ended>)> {
        let (desired, path) = (self.input.desired(), self.input.trajectory());
        let steps = !desired.kinematics().has_rotary_axes() && path.axes().len() <= 3 && path.len() <= STEPS_SAMPLES;
        let responses = if steps { ImpulseResponse::probe_model(machine, path, MODEL_RESPONSE_S)? } else { Vec::new() };
        let late = responses.iter().map(ImpulseResponse::delay_samples).fold(0.0, f64::max) * path.period_s();
        let [least, most] = TURN_RANGE_S;
        let turn_s = late.clamp(least, most);
        self.guard.settle_s = self.guard.settle_s.max(turn_s);
        let updates = if steps { iterations.min(SPATIAL_UPDATES) } else { iterations };
        let most_runs = 1 + CUT_OFFS * updates + if steps { 2 + (1 + STEPS) * iterations } else { 0 };
        // A control plans a program's time anew: it takes a shift along the path for another place to slow down at.
        let turn_s = self.input.part().is_none().then_some(turn_s);
        let ladder = CutOffCandidates { turn_s, updates, cut_offs: (LADDER_SAMPLES / path.len().max(1)).clamp(1, CUT_OFFS) };
        let mut known = Vec::new();
        let mut measure = |_: &DesiredPath, actual: &Trajectory| self.judge(actual, &mut known, most_runs);
        let machine = &mut Cancellable { machine, cancelled: &self.cancelled };
        let mut rounds = self.checked(spatial_candidates(machine, desired, &self.guard, &ladder, &mut measure))?;
        let mut ended = None;
        if steps {
            let mut law = ContourOptimal::new(responses, Descent::default().damping[0])?;
            // From the desired path the steps see no roughness that the spatial law has learned; from the best run of both they go on.
            for (from_best, runs) in [(false, 1 + iterations), (true, 1 + STEPS * iterations)] {
                let best = rounds.iter().min_by(|a, b| a.measure.total_cmp(&b.measure)).filter(|_| from_best);
                let Some(start) = best.or(rounds.first()).cloned() else { break };
                let descent = Descent { runs, floor: self.floor_mm, ..Descent::default() };
                let steps = descend(machine, &mut law, desired, start, &self.guard, &descent, &mut measure);
                let (more, why) = self.checked(steps)?;
                rounds.extend(more.into_iter().skip(1));
                ended = Some(why);
            }
        }
        Ok((with_figures(rounds, known)?, ended))
    }

    /// Lets `law` learn on `machine` from `start`, or from the desired path: every run with its figures.
    pub fn iterate(
        &self,
        machine: &mut dyn Machine,
        law: &mut dyn CompensationLaw,
        start: Option<Trajectory>,
        stop: StopRule,
    ) -> Result<Runs> {
        let mut known = Vec::new();
        let mut measure = |_: &DesiredPath, actual: &Trajectory| self.judge(actual, &mut known, stop.updates + 1);
        let machine = &mut Cancellable { machine, cancelled: &self.cancelled };
        let learned = self.checked(learn(machine, law, self.input.desired(), start, &self.guard, &stop, &mut measure))?;
        with_figures(learned.iterations, known)
    }

    /// The result of a loop, which ends with an error of the machine where the caller asked to stop.
    fn checked<T>(&self, result: Result<T, CompensationError>) -> Result<T> {
        if self.cancelled.load(Ordering::Relaxed) { Err(Error::Cancelled) } else { Ok(result?) }
    }
}

fn with_figures(rounds: Vec<Iteration>, known: Vec<Result<Figures>>) -> Result<Runs> {
    rounds.into_iter().zip(known).map(|(round, figures)| Ok((round, figures?))).collect()
}

/// Runs nothing more once the caller asked to stop.
struct Cancellable<'a> {
    machine: &'a mut dyn Machine,
    cancelled: &'a AtomicBool,
}

impl Machine for Cancellable<'_> {
    fn run(&mut self, reference: &Trajectory) -> Result<Trajectory, MachineError> {
        if self.cancelled.load(Ordering::Relaxed) {
            return Err(MachineError::Misfit("cancelled".to_owned()));
        }
        self.machine.run(reference)
    }
}
