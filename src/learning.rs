//! Virtual learning: a law, iterated on the model of the machine before the first run.

use std::collections::BTreeMap;

use anyhow::Result;
use clap::ValueEnum;
use compensation::laws::{Gain, NormOptimalIlc, NormOptimalSettings, OneShot, SpatialIlc, TrackingIlc};
use compensation::{CompensationLaw, Guard, ImpulseResponse, LowPass, Round, StopRule, learn};
use machine::{Machine, MachineError};
use models::{Bundle, Coverage, LearnedMachine, Outside, fade};
use motion::contour::Exact;
use motion::{DesiredPath, Limits, Trajectory};
use serde::Serialize;

use crate::evaluate::{self, Figures};
use crate::pipeline::Part;

/// How the reference is learned on the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LawName {
    /// Spatial learning iterated on the model, foot points on the path (default)
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
    /// Updates on the model; one shot has one.
    pub iterations: usize,
    /// Gain of every update.
    pub gain: f64,
    /// Cut-off of the zero-phase low-pass on every update, Hz.
    pub low_pass_hz: f64,
    /// Largest correction of an axis, or of the tip on a machine that turns tool or workpiece, mm.
    pub max_shift: f64,
    /// Largest correction of the tool's direction, rad.
    pub max_turn_rad: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { law: LawName::Virtual, iterations: 4, gain: 0.9, low_pass_hz: 100.0, max_shift: 0.1, max_turn_rad: 0.01 }
    }
}

/// Least predicted gain for which a path is changed at all, as a share of its RMS contour error.
const LEAST_GAIN: f64 = 0.05;

/// Time within which a turn or a stop hands over from the contour error to the tracking error, s: about a servo's time constant.
const TURN_S: f64 = 0.01;

/// What came out.
#[derive(Debug)]
pub struct Outcome {
    /// The learned reference; the desired path itself where nothing is gained.
    pub reference: Trajectory,
    /// What the model expects of it.
    pub forecast: Trajectory,
    /// Predicted figures without compensation.
    pub before: Figures,
    /// Predicted figures of `reference`.
    pub after: Figures,
    /// Updates taken.
    pub updates: usize,
    /// Whether the model predicts a gain worth having.
    pub gained: bool,
    /// Where the model is out of its depth: axis, reason, samples.
    pub outside: Vec<OutsideRange>,
}

/// A stretch of samples in which an axis leaves what the model was trained on.
#[derive(Debug, Clone, PartialEq)]
pub struct OutsideRange {
    /// Name of the axis.
    pub axis: String,
    /// Why.
    pub reason: Outside,
    /// First sample.
    pub first: usize,
    /// Last sample.
    pub last: usize,
    /// Samples in between that lie outside.
    pub samples: usize,
    /// Whether the correction fades there; else only what the model knows of single places does.
    pub fades: bool,
}

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
    let path = desired.trajectory();
    let command = part.and_then(|part| part.command.as_ref()).unwrap_or(path);
    model.freeze_flags(command);
    let (mut weights, reasons) = fade(coverage, model.predictors(), command);
    let outside = ranges(path, &reasons, &weights);
    let model = &mut Controlled { machine: model, part };
    if let Some(part) = part {
        for (weight, allowed) in weights.iter_mut().zip(part.weights(FADE_S)) {
            *weight *= allowed;
        }
    }
    let low_pass = LowPass::new(settings.low_pass_hz, path.period_s())?;
    let mut law: Box<dyn CompensationLaw> = match settings.law {
        LawName::Virtual => {
            let spatial = SpatialIlc::new(Gain::Constant(settings.gain), low_pass)?.with_estimator(Box::new(Exact::default()));
            // A control plans a program's time anew: it takes a shift along the path for another place to slow down at.
            Box::new(if part.is_some() { spatial } else { spatial.with_tracking_in_turns(TURN_S) })
        }
        LawName::OneShot => Box::new(OneShot::default()),
        LawName::Tracking => Box::new(TrackingIlc::new(Gain::Constant(settings.gain), low_pass)),
        LawName::NormOptimal => Box::new(norm_optimal(0.0, ImpulseResponse::probe(model, path, PROBE, RESPONSE_S)?)?),
        LawName::CrossCoupled => Box::new(norm_optimal(1.0, ImpulseResponse::probe(model, path, PROBE, RESPONSE_S)?)?),
    };
    let Settings { max_shift, max_turn_rad, .. } = *settings;
    let guard = Guard { max_shift, max_turn_rad, limits: limits.cloned(), weights, ..Guard::default() };
    let updates = if settings.law == LawName::OneShot { 1 } else { settings.iterations };
    let stop = StopRule { updates, stall: 0.0 };
    let mut figures = Vec::new();
    let mut measure = |desired: &DesiredPath, actual: &Trajectory| {
        figures.push(evaluate::figures(desired, part, actual));
        figures.last().and_then(|figures| figures.as_ref().ok()).map_or(f64::INFINITY, Figures::judged_mm)
    };
    let learned = learn(model, law.as_mut(), desired, None, &guard, &stop, &mut measure)?;
    let figures: Vec<Figures> = figures.into_iter().collect::<Result<_>>()?;
    let Some(best) = learned.best() else { anyhow::bail!("the path has no samples") };
    let mut rounds = learned.rounds;
    let gained = rounds[best].measure < (1.0 - LEAST_GAIN) * rounds[0].measure;
    let (updates, chosen) = (rounds.len() - 1, if gained { best } else { 0 });
    let Round { reference, actual: forecast, .. } = rounds.swap_remove(chosen);
    Ok(Outcome { reference, forecast, before: figures[0], after: figures[chosen], updates, gained, outside })
}

/// A machine behind a control that leaves the path of its program, by as much as it did in a recorded run.
struct Controlled<'a> {
    machine: &'a mut LearnedMachine,
    part: Option<&'a Part>,
}

impl Machine for Controlled<'_> {
    fn run(&mut self, reference: &Trajectory) -> Result<Trajectory, MachineError> {
        match self.part {
            Some(part) => self.machine.run(&part.commanded(reference)?),
            None => self.machine.run(reference),
        }
    }
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
    compensate(&mut bundle.machine()?, &bundle.coverage(), Some(limits), desired, part, settings)
}

/// A correction of which this share is kept, over a stretch, does not count as faded.
const MOSTLY: f64 = 0.95;

/// One entry an axis and reason.
fn ranges(path: &Trajectory, reasons: &[Vec<Option<Outside>>], weights: &[f64]) -> Vec<OutsideRange> {
    let mut found = Vec::new();
    for (axis, reasons) in path.axes().iter().zip(reasons) {
        let mut by_reason: BTreeMap<String, OutsideRange> = BTreeMap::new();
        let mut kept: BTreeMap<String, f64> = BTreeMap::new();
        for (k, reason) in reasons.iter().enumerate() {
            if let Some(reason) = reason {
                let entry = by_reason.entry(reason.to_string()).or_insert_with(|| OutsideRange {
                    axis: axis.name.clone(),
                    reason: *reason,
                    first: k,
                    last: k,
                    samples: 0,
                    fades: false,
                });
                entry.last = k;
                entry.samples += 1;
                kept.entry(reason.to_string()).and_modify(|sum| *sum += weights[k]).or_insert(weights[k]);
            }
        }
        for (reason, kept) in kept {
            if let Some(range) = by_reason.get_mut(&reason) {
                range.fades = kept < MOSTLY * range.samples as f64;
            }
        }
        found.extend(by_reason.into_values());
    }
    found
}
