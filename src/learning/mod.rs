//! Virtual learning: a law, iterated on the model of the machine before the first run.

mod acceptance;
mod outside;

use anyhow::Result;
use clap::ValueEnum;
use compensation::laws::{ContourOptimal, Gain, NormOptimalIlc, NormOptimalSettings, OneShot, SpatialIlc, TrackingIlc};
use compensation::{
    CompensationLaw, Descent, Ended, Guard, ImpulseResponse, Ladder, LowPass, Round, StopRule, descend, learn, spatial_ladder,
};
use machine::Machine;
use models::{Bundle, Coverage, LearnedMachine, fade};
use motion::contour::Exact;
use motion::{DesiredPath, Limits, Trajectory};
use serde::Serialize;

use acceptance::{Bound, best, cost};
use outside::ranges;

use crate::control::Control;
use crate::evaluate::{self, Figures};
use crate::pipeline::{Carrier, Part, RefitSettings};

pub use outside::OutsideRange;

/// How the reference is learned on the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LawName {
    /// The contour error itself, minimised on the model: spatial learning, then Gauss-Newton steps (default)
    Virtual,
    /// One shift by the predicted contour error (Paper D)
    OneShot,
    /// Every axis driven to its desired position at its time, iterated on the model
    Tracking,
    /// Every axis's error with a bounded shift, iterated on the model (Paper E, N.O.-ILC)
    NormOptimal,
    /// The contour error alone with a bounded shift, iterated on the model (Paper E, N.O.-CCILC)
    CrossCoupled,
}

/// Size of the shifts from which impulse responses are identified, mm: far above the noise, small enough for the motor's torque.
pub const PROBE: f64 = 0.005;
/// Time after which a drive's response is over, s.
pub const RESPONSE_S: f64 = 0.2;

/// Settings of a compensation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// The law.
    pub law: LawName,
    /// Updates on the model; one shot has one. A program that its control plans anew gets up to three times as many more, one of hours fewer.
    pub iterations: usize,
    /// Gain of every update.
    pub gain: f64,
    /// Cut-off of the zero-phase low-pass on every update, Hz.
    pub low_pass_hz: f64,
    /// Largest correction of the tool tip, mm; that of [`shift_bound`] when `None`.
    pub max_shift: Option<f64>,
    /// Largest correction of the tool's direction, rad.
    pub max_turn_rad: f64,
    /// How a program will be written: the last updates are then made on what a control commands when it has read it. `None` where the
    /// control takes the reference itself.
    pub written: Option<RefitSettings>,
    /// Share of the cycle time that points with times of their own may cost before the program's feeds are kept.
    pub slowest: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            law: LawName::Virtual,
            iterations: 4,
            gain: 0.9,
            low_pass_hz: 100.0,
            max_shift: None,
            max_turn_rad: Guard::MAX_TURN_DEG.to_radians(),
            written: None,
            slowest: f64::INFINITY,
        }
    }
}

/// Largest correction, as a multiple of the largest error that there is to correct: a stop or a turn of a slow loop asks for more than its error.
const SHIFT_OF_ERROR: f64 = 2.0;
/// The least and the largest bound of corrections where none is given, mm.
const SHIFT_BOUND_MM: [f64; 2] = [0.1, 1.0];

/// The bound of corrections of the tool tip where none is given, mm: of a run that is corrected by `shifted_mm` already and has a largest error of `max_mm`.
#[must_use]
pub fn shift_bound(shifted_mm: f64, max_mm: f64) -> f64 {
    let [least, most] = SHIFT_BOUND_MM;
    (shifted_mm + SHIFT_OF_ERROR * max_mm).clamp(least, most)
}

/// Share by which an update on the reference has to lower the forecast for another to follow.
const WORTH: f64 = 0.02;
/// Difference of the forecasts on the reference itself and on what a control makes of the program, as a share, up to which the control
/// does as it is told.
const SAME: f64 = 0.02;
/// Updates on what a control makes of the program, for every one on the reference, and how many in a row may bring nothing.
const PLANNED_UPDATES: usize = 3;
const PLANNED_PATIENCE: usize = 4;
/// Samples planned anew in all of them together, and the least updates of a program of hours: planning takes most of the time.
const PLANNED_SAMPLES: usize = 12_000_000;
const LEAST_PLANNED: usize = 2;
/// Gain and cut-off (Hz) of these updates: what is learned above it comes back as kinks, at which a control slows down.
const PLANNED_GAIN: f64 = 0.7;
const PLANNED_LOW_PASS_HZ: f64 = 40.0;

/// Least predicted gain for which a path is changed at all, as a share of its RMS contour error.
const LEAST_GAIN: f64 = 0.05;

/// Least and largest time within which a turn or a stop hands over from the contour error to the tracking error, s: by how much the model's response comes late,
/// but as long as the shortest of servos and no longer than the slowest.
const TURN_RANGE_S: [f64; 2] = [0.01, 0.1];
/// Time after which a model's response counts as over, s: that of a slow integrator; a response that ends before is cut there.
const MODEL_RESPONSE_S: f64 = 0.4;
/// Runs of the Gauss–Newton steps from the best run so far, for every iteration asked for: a step takes one, or two where part of it is taken back.
const STEPS: usize = 3;
/// Updates of the spatial law with one cut-off where Gauss–Newton steps follow: the first two bring all but a tenth of what it gains.
const SPATIAL_UPDATES: usize = 2;
/// Forecast at which learning ends, as a share of the error that the model leaves on data held out: it adds half a per cent to that error.
const FLOOR_SHARE: f64 = 0.1;
/// Most cut-offs that are tried, and samples of all of them together: a program of hours keeps the first.
const CUT_OFFS: usize = 5;
const LADDER_SAMPLES: usize = 400_000;
/// Samples up to which Gauss–Newton steps are made: they hold some thirty columns as long as the path.
const STEPS_SAMPLES: usize = 400_000;

/// What came out.
#[derive(Debug)]
pub struct Outcome {
    /// The learned reference; the desired path itself where nothing is gained.
    pub reference: Trajectory,
    /// What the model expects of it.
    pub forecast: Trajectory,
    /// Bound of the correction of the tool tip that was kept to, mm.
    pub max_shift: f64,
    /// Predicted figures without compensation.
    pub before: Figures,
    /// Predicted figures of `reference`.
    pub after: Figures,
    /// Updates taken.
    pub updates: usize,
    /// Why learning on the reference ended; `None` for the papers' laws and where the spatial law alone learns.
    pub ended: Option<Ended>,
    /// Whether the model predicts a gain worth having.
    pub gained: bool,
    /// How long the program takes before and after, as the control is expected to plan it, s; `None` where it takes the reference.
    pub cycle_s: Option<(f64, f64)>,
    /// Where the program keeps its feeds because the times of its points would cost too much: how much, as a share of the cycle time.
    pub kept_feeds: Option<f64>,
    /// Where the model is out of its depth: axis, reason, samples.
    pub outside: Vec<OutsideRange>,
}

/// A forecast on the way to a reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Forecast {
    /// Its number in its series, from 1; a program that is planned anew begins a second series.
    pub number: usize,
    /// Forecasts that the series has at most.
    pub most: usize,
    /// What the learning lowers, mm.
    pub cost_mm: f64,
}

/// Is told of every forecast.
pub type Watch<'a> = &'a (dyn Fn(Forecast) + Sync);

/// Learns a reference for `desired` on `model`.
///
/// # Errors
/// When the path does not fit the model (axes, sampling period).
pub fn compensate(
    model: &mut LearnedMachine,
    coverage: &[Coverage],
    limits: Option<&Limits>,
    desired: &DesiredPath,
    part: Option<&Part>,
    settings: &Settings,
) -> Result<Outcome> {
    compensate_on(model, coverage, limits, desired, part, settings, Aim { floor_mm: 0.0, watch: &|_| {} })
}

/// How far learning goes, and who is told of the way.
struct Aim<'a> {
    /// Forecast at which nothing is gained by going on, mm.
    floor_mm: f64,
    watch: Watch<'a>,
}

fn compensate_on(
    model: &mut LearnedMachine,
    coverage: &[Coverage],
    limits: Option<&Limits>,
    desired: &DesiredPath,
    part: Option<&Part>,
    settings: &Settings,
    aim: Aim,
) -> Result<Outcome> {
    let path = desired.trajectory();
    let command = part.and_then(|part| part.command.as_ref()).unwrap_or(path);
    model.freeze_flags(command);
    if part.is_some_and(|part| !part.placement.known()) {
        model.leave_out_position();
    }
    let (mut weights, reasons) = fade(coverage, model, command);
    let outside = ranges(path, &reasons, &weights);
    if let Some(part) = part {
        for (weight, allowed) in weights.iter_mut().zip(part.weights(FADE_S)) {
            *weight *= allowed;
        }
    }
    let mut control = Control::new(model, part);
    let max_shift = bound_of(settings, &mut control, desired, part)?;
    let guard = Guard { max_shift, max_turn_rad: settings.max_turn_rad, limits: limits.cloned(), weights, ..Guard::default() };
    let mut task = Task { desired, part, guard, aim, judged: part.map(judged) };
    let (mut runs, ended) = if settings.law == LawName::Virtual {
        task.descend(&mut control, settings.iterations)?
    } else {
        let mut law = law(settings, path, &mut control)?;
        let updates = if settings.law == LawName::OneShot { 1 } else { settings.iterations };
        (task.practise(&mut control, law.as_mut(), None, StopRule::while_better(updates, WORTH))?, None)
    };
    let mut updates = runs.len() - 1;
    let most = Bound::of(&runs[0], LEAST_GAIN);
    let mut chosen = best(&runs, most).map(|run| runs.swap_remove(run));
    let (mut cycle_s, mut kept_feeds) = (None, None);
    if let (Some((ideal, _)), Some(written), Some(limits)) = (&chosen, settings.written, limits)
        && control.plans(written, limits)
    {
        let reference = ideal.reference.clone();
        let mut seen = control.run(&reference)?;
        let slowdown = control.last_s() / path.duration_s() - 1.0;
        let keep = RefitSettings { carrier: Carrier::Keep, ..written };
        if slowdown > settings.slowest && written.carrier != Carrier::Keep && control.plans(keep, limits) {
            kept_feeds = Some(slowdown);
            seen = control.run(&reference)?;
        }
        let mut after_s = control.last_s();
        let figures = task.figures(&seen)?;
        let measure = cost(&figures);
        // The papers' laws are left as they are; only the forecast is the control's.
        if settings.law == LawName::Virtual && (measure / ideal.measure - 1.0).abs() > SAME {
            let mut law = spatial(PLANNED_GAIN, LowPass::new(PLANNED_LOW_PASS_HZ, path.period_s())?)?;
            let affordable = (PLANNED_SAMPLES / path.len().max(1)).max(LEAST_PLANNED);
            let most_updates = affordable.min(PLANNED_UPDATES * settings.iterations);
            let stop = StopRule { updates: most_updates, patience: PLANNED_PATIENCE, worth: 0.0 };
            let first = control.durations_s.len();
            let mut planned = task.practise(&mut control, &mut law, Some(reference), stop)?;
            updates += planned.len() - 1;
            let run = best(&planned, most);
            after_s = run.map_or(after_s, |run| control.durations_s[first + run]);
            chosen = run.map(|run| planned.swap_remove(run));
        } else {
            chosen = most.holds(measure, &figures).then_some((Round { reference, actual: seen, measure }, figures));
        }
        cycle_s = Some((path.duration_s(), after_s)).filter(|_| chosen.is_some());
    }
    let (first, _) = runs.swap_remove(0);
    let before = evaluate::figures(desired, part, &first.actual)?;
    // What may not be changed must not come out worse for what is changed beside it either.
    let overall = |(round, _): (Round, Figures)| -> Result<(Figures, Round)> {
        Ok((evaluate::figures(desired, part, &round.actual)?, round))
    };
    let kept = chosen.map(overall).transpose()?.filter(|(after, _)| {
        let most = |before: f64| before * (1.0 + SAME);
        after.judged_mm() <= most(before.judged_mm()) && after.tip.max_mm <= most(before.tip.max_mm)
    });
    let gained = kept.is_some();
    let cycle_s = cycle_s.filter(|_| gained);
    let (after, Round { reference, actual: forecast, .. }) = kept.unwrap_or((before, first));
    Ok(Outcome { reference, forecast, max_shift, before, after, updates, ended, gained, cycle_s, kept_feeds, outside })
}

/// The bound of corrections that is given, or that of a run of `machine` without any, mm.
fn bound_of(settings: &Settings, machine: &mut dyn Machine, desired: &DesiredPath, part: Option<&Part>) -> Result<f64> {
    Ok(match settings.max_shift {
        Some(given) => given,
        None => shift_bound(0.0, evaluate::contour(desired, part, &machine.run(desired.trajectory())?)?.max_mm),
    })
}

/// The law that `settings` name.
fn law(settings: &Settings, path: &Trajectory, machine: &mut dyn Machine) -> Result<Box<dyn CompensationLaw>> {
    let low_pass = LowPass::new(settings.low_pass_hz, path.period_s())?;
    Ok(match settings.law {
        LawName::Virtual => Box::new(spatial(settings.gain, low_pass)?),
        LawName::OneShot => Box::new(OneShot::default()),
        LawName::Tracking => Box::new(TrackingIlc::new(Gain::Constant(settings.gain), low_pass)),
        LawName::NormOptimal => Box::new(norm_optimal(0.0, ImpulseResponse::probe(machine, path, PROBE, RESPONSE_S)?)?),
        LawName::CrossCoupled => Box::new(norm_optimal(1.0, ImpulseResponse::probe(machine, path, PROBE, RESPONSE_S)?)?),
    })
}

fn spatial(gain: f64, low_pass: Option<LowPass>) -> Result<SpatialIlc> {
    Ok(SpatialIlc::new(Gain::Constant(gain), low_pass)?.with_estimator(Box::new(Exact::default())))
}

/// What is learned, and within which bounds.
struct Task<'a> {
    desired: &'a DesiredPath,
    part: Option<&'a Part>,
    guard: Guard,
    aim: Aim<'a>,
    /// The samples by which runs are judged; all where there is no program.
    judged: Option<Vec<bool>>,
}

/// The samples of a part's plan that its runs are judged by: those that may be changed, or those of all feed moves where none may.
fn judged(part: &Part) -> Vec<bool> {
    let samples = 0..part.plan.samples.len();
    let changeable: Vec<bool> = samples.clone().map(|k| part.shiftable_at(k)).collect();
    if changeable.contains(&true) { changeable } else { samples.map(|k| part.feeds_at(k)).collect() }
}

/// Runs on a model, each with its figures.
type Runs = Vec<(Round, Figures)>;

impl Task<'_> {
    /// What a run is judged by: the moves that may be changed. What has to stay as it is must not keep the rest from being corrected.
    fn figures(&self, actual: &Trajectory) -> Result<Figures> {
        evaluate::figures_where(self.desired, actual, |k| self.judged.as_ref().is_none_or(|judged| judged[*k]))
    }

    /// The spatial law with the cut-off that makes the best forecast, then Gauss–Newton steps on the contour error from there, where the axes are coordinates of
    /// the tip: every run with its figures. Times of turns and stops are the machine's own response's.
    fn descend(&mut self, machine: &mut dyn Machine, iterations: usize) -> Result<(Runs, Option<Ended>)> {
        let mut ended = None;
        let path = self.desired.trajectory();
        let steps = !self.desired.kinematics().turns() && path.axes().len() <= 3 && path.len() <= STEPS_SAMPLES;
        let responses = if steps { ImpulseResponse::probe_model(machine, path, MODEL_RESPONSE_S)? } else { Vec::new() };
        let late = responses.iter().map(ImpulseResponse::delay_samples).fold(0.0, f64::max) * path.period_s();
        let [least, most] = TURN_RANGE_S;
        let turn_s = late.clamp(least, most);
        self.guard.settle_s = self.guard.settle_s.max(turn_s);
        let updates = if steps { iterations.min(SPATIAL_UPDATES) } else { iterations };
        let most_runs = 1 + CUT_OFFS * updates + if steps { 2 + (1 + STEPS) * iterations } else { 0 };
        let mut figures = Vec::new();
        let mut measure = |_: &DesiredPath, actual: &Trajectory| {
            figures.push(self.figures(actual));
            let cost_mm = figures.last().and_then(|figures| figures.as_ref().ok()).map_or(f64::INFINITY, cost);
            (self.aim.watch)(Forecast { number: figures.len(), most: figures.len().max(most_runs), cost_mm });
            cost_mm
        };
        // A control plans a program's time anew: it takes a shift along the path for another place to slow down at.
        let turn_s = self.part.is_none().then_some(turn_s);
        let ladder = Ladder { turn_s, updates, cut_offs: (LADDER_SAMPLES / path.len().max(1)).clamp(1, CUT_OFFS) };
        let mut rounds = spatial_ladder(machine, self.desired, &self.guard, &ladder, &mut measure)?;
        if steps {
            let mut law = ContourOptimal::new(responses, Descent::default().damping[0])?;
            // From the desired path the steps see no roughness that the spatial law has learned; from the best run of both they go on.
            for (from_best, runs) in [(false, 1 + iterations), (true, 1 + STEPS * iterations)] {
                let best = rounds.iter().min_by(|a, b| a.measure.total_cmp(&b.measure)).filter(|_| from_best);
                let Some(start) = best.or(rounds.first()).cloned() else { break };
                let descent = Descent { runs, floor: self.aim.floor_mm, ..Descent::default() };
                let (more, why) = descend(machine, &mut law, self.desired, start, &self.guard, &descent, &mut measure)?;
                rounds.extend(more.into_iter().skip(1));
                ended = Some(why);
            }
        }
        let runs = rounds.into_iter().zip(figures).map(|(round, figures)| Ok((round, figures?))).collect::<Result<_>>()?;
        Ok((runs, ended))
    }

    /// Lets `law` learn on `machine` from `start`, or from the desired path: every run with its figures.
    fn practise(
        &self,
        machine: &mut dyn Machine,
        law: &mut dyn CompensationLaw,
        start: Option<Trajectory>,
        stop: StopRule,
    ) -> Result<Runs> {
        let mut figures = Vec::new();
        let mut measure = |_: &DesiredPath, actual: &Trajectory| {
            figures.push(self.figures(actual));
            let cost_mm = figures.last().and_then(|figures| figures.as_ref().ok()).map_or(f64::INFINITY, cost);
            (self.aim.watch)(Forecast { number: figures.len(), most: stop.updates + 1, cost_mm });
            cost_mm
        };
        let learned = learn(machine, law, self.desired, start, &self.guard, &stop, &mut measure)?;
        learned.rounds.into_iter().zip(figures).map(|(round, figures)| Ok((round, figures?))).collect()
    }
}

/// Learns a reference for `desired` on any machine, as [`compensate`] does on a learned one: on the noise-free simulated machine this is what a perfect model
/// would give.
///
/// # Errors
/// When the path does not fit the machine.
pub fn on_machine(machine: &mut dyn Machine, limits: &Limits, desired: &DesiredPath, settings: &Settings) -> Result<Trajectory> {
    let max_shift = bound_of(settings, machine, desired, None)?;
    let guard = Guard { max_shift, max_turn_rad: settings.max_turn_rad, limits: Some(limits.clone()), ..Guard::default() };
    let (runs, _) = Task { desired, part: None, guard, aim: Aim { floor_mm: 0.0, watch: &|_| {} }, judged: None }
        .descend(machine, settings.iterations)?;
    let most = Bound::of(&runs[0], 0.0);
    Ok(best(&runs, most).map_or_else(|| desired.trajectory().clone(), |run| runs[run].0.reference.clone()))
}

/// Paper E's law with its printed weights; `a` is the share of the contour error.
///
/// # Errors
/// When `a` is not within 0…1.
pub fn norm_optimal(a: f64, responses: Vec<ImpulseResponse>) -> Result<NormOptimalIlc> {
    Ok(NormOptimalIlc::new(NormOptimalSettings { a, ..NormOptimalSettings::default() }, responses)?)
}

/// Time over which a correction begins and ends beside moves that must not be shifted, s.
pub const FADE_S: f64 = 0.03;

/// As [`compensate`], with what a bundle says of its machine.
///
/// # Errors
/// As [`compensate`]; when a predictor of the bundle is not usable.
pub fn compensate_with(
    bundle: &Bundle,
    limits: &Limits,
    desired: &DesiredPath,
    part: Option<&Part>,
    settings: &Settings,
) -> Result<Outcome> {
    compensate_watched(bundle, limits, desired, part, settings, &|_| {})
}

/// As [`compensate_with`], with every forecast reported to `watch`.
///
/// # Errors
/// As [`compensate_with`].
pub fn compensate_watched(
    bundle: &Bundle,
    limits: &Limits,
    desired: &DesiredPath,
    part: Option<&Part>,
    settings: &Settings,
    watch: Watch,
) -> Result<Outcome> {
    let held_out = bundle.manifest.axes.iter().map(|axis| axis.held_out.rms.powi(2)).sum::<f64>().sqrt();
    let floor_mm = FLOOR_SHARE * held_out;
    compensate_on(&mut bundle.machine()?, &bundle.coverage(), Some(limits), desired, part, settings, Aim { floor_mm, watch })
}
