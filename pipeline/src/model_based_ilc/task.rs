//! Iteration on a machine, with the cost of every run.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

use compensation::laws::ContourOptimal;
use compensation::{
    CompensationError, CompensationLaw, CorrectionLimits, CutOffCandidates, Descent, Ended, ImpulseResponse, Iteration, StopRule,
    Worth, descend, learn, learn_from, spatial_candidates,
};
use machine::{Machine, MachineError};
use motion::{DesiredPath, Trajectory};

use super::acceptance::cost;
use super::outcome::BesideUnchanged;
use crate::error::{Error, Result};
use crate::input::Input;
use crate::part::Part;
use crate::progress::{Event, Progress};
use crate::statistics::{Figures, SampleErrors};

/// Range of the time around a sharp turn or stop within which the tracking error replaces the contour error, s. The
/// time is the delay of the model's response, limited to that of the fastest and of the slowest servos.
const TURN_RANGE_S: [f64; 2] = [0.01, 0.1];
/// Largest length of a model's response, s: that of a slow integrator. A response that ends earlier is cut there.
const MODEL_RESPONSE_S: f64 = 0.4;
/// Runs of Gauss–Newton steps for each requested iteration. A step takes one run, or two where part of it is taken back. With 9 instead of 3, and a
/// patience of 3 instead of 2, first runs of three curves on `random:61001` to `61010`, `70021` and `70022` had 3 % less RMS and 4 % less MAX (at best 32 and 53), none more than 2 % more
/// RMS, in 1.8 times the time. The reference of a program
/// that its control plans again is only where learning on that program starts: from 13 runs instead of 5, first runs of three programs on `ballscrew`,
/// `random:142`, `143`, `145`, `146`, `160` and `162` had 5 % more RMS and 2 % less MAX.
pub(super) const STEPS: usize = 8;
pub(super) const STEPS_OF_REPLANNED: usize = 1;
/// Largest number of candidate cut-offs, and largest number of samples over all of them. A program of hours uses the
/// first cut-off.
const CUT_OFFS: usize = 5;
const CANDIDATE_SAMPLES: usize = 400_000;
/// Largest path length for Gauss–Newton steps, samples. They hold some thirty columns of this length.
const STEPS_SAMPLES: usize = 400_000;

/// Ratio of the largest error beside moves that are not changed to the largest one elsewhere from which on it is reported.
const FAR_ABOVE: f64 = 2.0;
/// Share of a step up to which a machine has settled.
const SETTLED: f64 = 0.02;

/// Forecast at which the iteration ends, as a share of the model's error. It adds half a per cent to that error.
const FLOOR_SHARE: f64 = 0.1;

/// Share of the cost that steps without the limits of the axes have to save for learning on the program to start from them too.
const FREED: f64 = 0.05;

/// Runs on a machine with their figures.
pub(super) type Runs = Vec<(Iteration, Figures)>;

/// An iteration task: its input, correction limits and end.
pub(super) struct Task<'a> {
    input: &'a Input,
    correction_limits: CorrectionLimits,
    /// Error of the model, mm, as it stands in the error expected on the machine.
    model_error_mm: f64,
    progress: Progress<'a>,
    cancelled: AtomicBool,
    /// Responses of the machine to shifts, where Gauss–Newton steps are made.
    responses: Vec<ImpulseResponse>,
    /// The samples over which runs are evaluated; `None` for all.
    evaluated: Option<Vec<bool>>,
    /// Part of every sample's error that no correction takes away, mm; empty where that is not known.
    unavoidable_mm: Vec<f64>,
}

/// The samples over which runs of a part are evaluated: those that may be changed, or those of all feed moves where
/// none may.
fn evaluated(part: &Part) -> Vec<bool> {
    let samples = 0..part.plan.samples.len();
    let changeable: Vec<bool> = samples.clone().map(|k| part.shiftable_at(k)).collect();
    if changeable.contains(&true) { changeable } else { samples.map(|k| part.feeds_at(k)).collect() }
}

/// Candidates for the responses of a machine to shifts of a path: those of a probe, and where friction absorbs or scatters it, those of the motion of the
/// axes that move beside them.
fn responses(machine: &mut dyn Machine, path: &Trajectory, uncompensated: &Trajectory) -> Result<Vec<Vec<ImpulseResponse>>> {
    let probed = ImpulseResponse::probe_model_beside(machine, path, uncompensated, MODEL_RESPONSE_S)?;
    if probed.iter().all(ImpulseResponse::follows) {
        return Ok(vec![probed]);
    }
    let moved = ImpulseResponse::of_motion(path, uncompensated, MODEL_RESPONSE_S);
    let of_axis = |(probed, moved): (&ImpulseResponse, Option<ImpulseResponse>)| match moved {
        Some(moved) if !probed.follows() => moved,
        _ => probed.clone(),
    };
    let moved = probed.iter().zip(moved).map(of_axis).collect();
    Ok(vec![probed, moved])
}

/// Time around turns and stops that belongs to a machine with these responses, s.
fn turn_s(responses: &[ImpulseResponse], period_s: f64) -> f64 {
    let [least, most] = TURN_RANGE_S;
    (responses.iter().map(ImpulseResponse::delay_samples).fold(0.0, f64::max) * period_s).clamp(least, most)
}

impl<'a> Task<'a> {
    pub fn new(input: &'a Input, correction_limits: CorrectionLimits, model_error_mm: f64, progress: Progress<'a>) -> Self {
        Self {
            input,
            correction_limits,
            model_error_mm,
            progress,
            cancelled: AtomicBool::new(false),
            responses: Vec::new(),
            evaluated: input.part().map(evaluated),
            unavoidable_mm: Vec::new(),
        }
    }

    /// Forecast at which the iteration ends, mm.
    pub fn floor_mm(&self) -> f64 {
        FLOOR_SHARE * self.model_error_mm
    }

    /// Error of the model, mm.
    pub fn model_error_mm(&self) -> f64 {
        self.model_error_mm
    }

    /// What a run has to save to count: a share of the error expected on the machine.
    pub fn worth(&self, share: f64) -> Worth {
        Worth { share, unavoidable: self.model_error_mm, attainable: self.floor_mm() }
    }

    /// The reference with its correction within the limits.
    pub fn limited(&self, reference: &Trajectory) -> Result<Trajectory> {
        Ok(self.correction_limits.apply(self.input.desired(), reference)?)
    }

    /// Errors of a run in the path's time.
    pub fn errors(&self, actual: &Trajectory) -> Result<SampleErrors> {
        SampleErrors::of(self.input.desired(), actual)
    }

    /// Figures of a run over the moves that may be changed, with the part that no correction takes away.
    pub fn whole_figures(&self, errors: &SampleErrors) -> Result<Figures> {
        errors.figures(|k| self.evaluated.as_ref().is_none_or(|evaluated| evaluated[*k]))
    }

    /// Figures of a run over the moves that may be changed, without the part that is unavoidable. Fixed moves must not prevent the correction of the
    /// others.
    pub fn figures(&self, errors: &SampleErrors) -> Result<Figures> {
        errors.figures_above(&self.unavoidable_mm, |k| self.evaluated.as_ref().is_none_or(|evaluated| evaluated[*k]))
    }

    /// Cost of a run, mm. Its figures are appended to `known` and reported as one of at most `most` forecasts.
    fn evaluate(&self, actual: &Trajectory, known: &mut Vec<Result<Figures>>, most: usize) -> f64 {
        known.push(self.errors(actual).and_then(|errors| self.figures(&errors)));
        let cost_mm = known.last().and_then(|figures| figures.as_ref().ok()).map_or(f64::INFINITY, cost);
        let event = Event::Forecast { number: known.len(), most: known.len().max(most), cost_mm };
        if (self.progress)(event) == ControlFlow::Break(()) {
            self.cancelled.store(true, Ordering::Relaxed);
        }
        cost_mm
    }

    /// Makes Gauss–Newton steps on the contour error, where the axes are coordinates of the tip. Where that is not so, or gains nothing, the
    /// spatial law is iterated with the cut-off of the best forecast. Returns every run with its figures, and why the steps ended.
    /// The time around turns and stops follows from the machine's own response. The uncompensated run is made where it is not given. There are
    /// `steps_each` runs of steps for each of the `iterations`.
    pub fn descend(
        &mut self,
        machine: &mut dyn Machine,
        uncompensated: Option<Trajectory>,
        [iterations, steps_each]: [usize; 2],
        worth: Worth,
    ) -> Result<(Runs, Option<Ended>)> {
        let (desired, path) = (self.input.desired(), self.input.trajectory());
        let steps = !desired.kinematics().has_rotary_axes() && path.axes().len() <= 3 && path.len() <= STEPS_SAMPLES;
        let uncompensated = match uncompensated {
            Some(known) => known,
            None => machine.run(path)?,
        };
        let runs = 1 + steps_each * iterations;
        let descent = Descent { runs, floor: self.floor_mm(), worth, ..Descent::default() };
        if steps {
            let candidates = responses(machine, path, &uncompensated)?;
            self.responses = self.best_of(machine, &uncompensated, candidates, &descent)?;
        }
        let turn_s = turn_s(&self.responses, path.period_s());
        self.correction_limits.settle_s = self.correction_limits.settle_s.max(turn_s);
        let most_runs = if steps { runs } else { 1 + CUT_OFFS * iterations };
        let mut known = Vec::new();
        let mut measure = |_: &DesiredPath, actual: &Trajectory| self.evaluate(actual, &mut known, most_runs);
        let first = Iteration { measure: measure(desired, &uncompensated), reference: path.clone(), actual: uncompensated };
        let machine = &mut Cancellable { machine, cancelled: &self.cancelled };
        let limits = &self.correction_limits;
        let (mut tried, mut ended) = (vec![first.clone()], None);
        if steps {
            let mut law = ContourOptimal::new(self.responses.clone(), descent.damping[0])?;
            let (found, why) =
                self.checked(descend(machine, &mut law, desired, first.clone(), limits, &descent, &mut measure))?;
            (tried, ended) = (found, Some(why));
        }
        if tried.iter().all(|run| run.measure >= first.measure) {
            // A replanning control takes a correction along the path as another position at which to slow down.
            let turn_s = self.input.part().is_none().then_some(turn_s);
            let cut_offs = (CANDIDATE_SAMPLES / path.len().max(1)).clamp(1, CUT_OFFS);
            let candidates = CutOffCandidates { turn_s, updates: iterations, cut_offs };
            let found = spatial_candidates(machine, desired, limits, &candidates, Some(first), &mut measure);
            tried.extend(self.checked(found)?.into_iter().skip(1));
        }
        Ok((with_figures(tried, known)?, ended))
    }

    /// The responses with which the steps of a descent come to the least cost, where there are several.
    fn best_of(
        &self,
        machine: &mut dyn Machine,
        uncompensated: &Trajectory,
        mut candidates: Vec<Vec<ImpulseResponse>>,
        descent: &Descent,
    ) -> Result<Vec<ImpulseResponse>> {
        let (desired, path) = (self.input.desired(), self.input.trajectory());
        let mut best = f64::INFINITY;
        let mut found = candidates.len().saturating_sub(1);
        if found == 0 {
            return Ok(candidates.pop().unwrap_or_default());
        }
        let machine = &mut Cancellable { machine, cancelled: &self.cancelled };
        for (number, responses) in candidates.iter().enumerate() {
            let mut known = Vec::new();
            let mut measure = |_: &DesiredPath, actual: &Trajectory| self.evaluate(actual, &mut known, descent.runs);
            let first =
                Iteration { measure: measure(desired, uncompensated), reference: path.clone(), actual: uncompensated.clone() };
            let mut limits = self.correction_limits.clone();
            limits.settle_s = limits.settle_s.max(turn_s(responses, path.period_s()));
            let mut law = ContourOptimal::new(responses.clone(), descent.damping[0])?;
            let (runs, _) = self.checked(descend(machine, &mut law, desired, first, &limits, descent, &mut measure))?;
            let least = runs.iter().map(|run| run.measure).fold(f64::INFINITY, f64::min);
            if least < best {
                (best, found) = (least, number);
            }
        }
        Ok(candidates.swap_remove(found))
    }

    /// Counts from here on, beside moves that are not changed, only what exceeds the errors of `ideal`, and returns that run with its new cost. The
    /// machine arrives with the error of a rapid, and corrections fade towards the next one. What none takes away would outweigh what they do elsewhere.
    pub fn leave_out_unavoidable(&mut self, ideal: Iteration) -> Result<(Iteration, Figures)> {
        let errors = self.errors(&ideal.actual)?;
        let settling = self.responses.iter().map(|response| response.settled_samples(SETTLED)).max().unwrap_or_default();
        let mut since = settling;
        let of = |(weight, error_mm): (&f64, f64)| {
            since = if *weight < 1.0 { 0 } else { since + 1 };
            if since <= settling { error_mm } else { 0.0 }
        };
        self.unavoidable_mm = self.correction_limits.weights.iter().zip(errors.magnitudes_mm()).map(of).collect();
        let figures = self.figures(&errors)?;
        Ok((Iteration { measure: cost(&figures), ..ideal }, figures))
    }

    /// The largest error of a run over all feed moves, where it is at a move that is changed beside one that is not, and far above all others.
    pub fn beside_unchanged(&self, actual: &Trajectory) -> Result<Option<BesideUnchanged>> {
        let Some(part) = self.input.part().filter(|_| !self.unavoidable_mm.is_empty()) else { return Ok(None) };
        let (mut beside, mut elsewhere_mm) = ((0, 0.0), 0.0_f64);
        for (k, error_mm) in self.errors(actual)?.magnitudes_mm().enumerate().filter(|(k, _)| part.feeds_at(*k)) {
            if self.unavoidable_mm.get(k).is_none_or(|unavoidable| *unavoidable == 0.0) || !part.shiftable_at(k) {
                elsewhere_mm = elsewhere_mm.max(error_mm);
            } else if error_mm > beside.1 {
                beside = (k, error_mm);
            }
        }
        let (at, max_mm) = beside;
        let beside = |line| BesideUnchanged { line, max_mm, elsewhere_mm };
        Ok(part.line_at(at).filter(|_| elsewhere_mm > 0.0 && max_mm > FAR_ABOVE * elsewhere_mm).map(beside))
    }

    /// From here on, the control plans every run and keeps the limits of the axes itself. Limits on the correction would take it out of corners
    /// that a control without a limit of jerk passes at its largest acceleration: a turn by 135 degrees kept 17.9 of 19.8 µm, and 2.6 without them.
    pub fn leave_limits_to_control(&mut self) {
        self.correction_limits.limits = None;
    }

    /// The best run of further Gauss–Newton steps from `ideal`, the best run within the limits of the axes, where steps without them lower its
    /// cost: the limits took a correction out of corners.
    pub fn freed(&self, machine: &mut dyn Machine, ideal: &Iteration, iterations: usize) -> Result<Option<Iteration>> {
        if !self.knows_responses() {
            return Ok(None);
        }
        let descent = Descent {
            runs: 1 + STEPS_OF_REPLANNED * iterations,
            floor: self.floor_mm(),
            worth: Worth::of_cost(FREED),
            patience: 1,
            ..Descent::default()
        };
        let mut known = Vec::new();
        let mut measure = |_: &DesiredPath, actual: &Trajectory| self.evaluate(actual, &mut known, descent.runs);
        let mut law = ContourOptimal::new(self.responses.clone(), descent.damping[0])?;
        let machine = &mut Cancellable { machine, cancelled: &self.cancelled };
        let (desired, limits) = (self.input.desired(), &self.correction_limits);
        let (runs, _) = self.checked(descend(machine, &mut law, desired, ideal.clone(), limits, &descent, &mut measure))?;
        let best = runs.into_iter().min_by(|a, b| a.measure.total_cmp(&b.measure));
        Ok(best.filter(|best| best.measure < (1.0 - FREED) * ideal.measure))
    }

    /// Whether [`Task::steps`] can be made: only after [`Task::descend`], of a path for which that makes them.
    pub fn knows_responses(&self) -> bool {
        !self.responses.is_empty()
    }

    /// Gauss–Newton steps from `start` with shifts below `cut_off_hz`. Returns every further run with its figures.
    pub fn steps(
        &self,
        machine: &mut dyn Machine,
        start: Iteration,
        cut_off_hz: f64,
        updates: usize,
        worth: Worth,
    ) -> Result<Runs> {
        let mut known = Vec::new();
        let mut measure = |_: &DesiredPath, actual: &Trajectory| self.evaluate(actual, &mut known, updates);
        let descent =
            Descent { runs: 1 + updates, floor: self.floor_mm(), cut_off_hz: Some(cut_off_hz), worth, ..Descent::default() };
        let mut law = ContourOptimal::new(self.responses.clone(), descent.damping[0])?;
        let machine = &mut Cancellable { machine, cancelled: &self.cancelled };
        let (desired, limits) = (self.input.desired(), &self.correction_limits);
        let (mut runs, _) = self.checked(descend(machine, &mut law, desired, start, limits, &descent, &mut measure))?;
        with_figures(runs.split_off(1), known)
    }

    /// Iterates `law` on `machine` from the run `first`. Returns every further run with its figures.
    pub fn iterate_from(
        &self,
        machine: &mut dyn Machine,
        law: &mut dyn CompensationLaw,
        first: Iteration,
        stop: StopRule,
    ) -> Result<Runs> {
        let mut known = Vec::new();
        let mut measure = |_: &DesiredPath, actual: &Trajectory| self.evaluate(actual, &mut known, stop.updates);
        let machine = &mut Cancellable { machine, cancelled: &self.cancelled };
        let learned =
            self.checked(learn_from(machine, law, self.input.desired(), first, &self.correction_limits, &stop, &mut measure))?;
        with_figures(learned.iterations.into_iter().skip(1), known)
    }

    /// Iterates `law` on `machine` from the desired path. Returns every run with its figures.
    pub fn iterate(&self, machine: &mut dyn Machine, law: &mut dyn CompensationLaw, stop: StopRule) -> Result<Runs> {
        let mut known = Vec::new();
        let mut measure = |_: &DesiredPath, actual: &Trajectory| self.evaluate(actual, &mut known, stop.updates + 1);
        let machine = &mut Cancellable { machine, cancelled: &self.cancelled };
        let learned =
            self.checked(learn(machine, law, self.input.desired(), None, &self.correction_limits, &stop, &mut measure))?;
        with_figures(learned.iterations, known)
    }

    /// Result of an iteration; [`Error::Cancelled`] where the caller cancelled it.
    fn checked<T>(&self, result: Result<T, CompensationError>) -> Result<T> {
        if self.cancelled.load(Ordering::Relaxed) { Err(Error::Cancelled) } else { Ok(result?) }
    }
}

fn with_figures(tried: impl IntoIterator<Item = Iteration>, known: Vec<Result<Figures>>) -> Result<Runs> {
    tried.into_iter().zip(known).map(|(iteration, figures)| Ok((iteration, figures?))).collect()
}

/// A machine that refuses to run after a cancellation.
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
