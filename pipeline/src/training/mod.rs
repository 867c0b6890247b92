//! Training: from logs to a model.
//!
//! [`train`] checks the logs, splits them into folds, fits one predictor for each axis, and evaluates it on held-out
//! runs. [`adapt`] refits a model to another machine with a few seconds of log.

mod adaptation;
mod axis;
mod cross_fit;
mod hash;
mod lags;
mod limits_from_log;
mod settings;
mod swings;

use std::collections::BTreeSet;
use std::fmt;
use std::ops::Range;

use datasets::{Check, Log, Purpose, Recording, Report, Severity, assess_runs, moving_axes, without_offsets};
use machine::MachineSpec;
use models::{AxisManifest, AxisPredictor, Bundle, FORMAT, HeldOut, Manifest};
use motion::{Axis, AxisKind};
use training::AxisRun;

use axis::{FittedAxis, fit_axis, servo_models};
use hash::data_hash;
use lags::{axis_lag_s, common_delay_s};
use limits_from_log::Reached;

use crate::error::{Error, Result};
use crate::progress::{Job, Progress, Steps};
use crate::units::ErrorUnit;

pub use adaptation::{Adapted, AdaptedAxis, adapt};
pub use cross_fit::Piece as HeldOutPiece;
pub use settings::{HELD_OUT, MOST_SAMPLES, TrainSettings};

/// Total samples over which cross-fit folds run, and the largest number of folds. A short log gets three folds, since
/// one part gives a poor estimate; a long log, whose fit takes a minute, gets one. The bound limits computing time.
const FOLD_SAMPLES: usize = 60_000;
const MOST_FOLDS: usize = 3;

/// A trained model with notes on its axes.
#[derive(Debug)]
pub struct Trained {
    /// The model.
    pub bundle: Bundle,
    /// One note for each axis: stages tried, epochs run.
    pub notes: Vec<String>,
    /// Names of the axes in the log that never moved.
    pub left_out: Vec<String>,
    /// Lag of every axis of the model, s; `None` where it cannot be determined.
    pub lags_s: Vec<Option<f64>>,
    /// Errors of every axis of the model on held-out samples, each predicted by a model that was fitted without it.
    pub held_out: Vec<Vec<HeldOutPiece>>,
    /// What was taken of the logs, where not all of their samples were.
    pub stretches: Option<Stretches>,
}

/// What was taken of long logs.
#[derive(Debug, Clone, PartialEq)]
pub struct Stretches {
    /// The stretches, each behind up to two seconds of what came before it.
    pub runs: Vec<Log>,
    /// Samples in them.
    pub samples: usize,
    /// Samples of the logs.
    pub of: usize,
}

/// An axis whose logs come nowhere near its limit of acceleration.
#[derive(Debug, Clone, PartialEq)]
pub struct Unreached {
    /// Name of the axis.
    pub axis: String,
    /// Largest acceleration of its command in the logs, mm/s².
    pub reached_mm_s2: f64,
    /// Its limit, mm/s².
    pub limit_mm_s2: f64,
}

/// Share of the limits of acceleration that commands of a control with these limits exceed: the product's excitation reaches 0.6 to 0.96 of them, and every
/// program that stops reaches them where its jerk allows.
const REACHED_SHARE: f64 = 0.5;

/// The linear axes, where the commands of none of them exceed half of its limit in `machine`: its limits may not be those of the control.
#[must_use]
pub fn unreached(bundle: &Bundle, machine: &MachineSpec) -> Option<Vec<Unreached>> {
    let ranges = bundle.coverage();
    let of_axis = |axis: &AxisManifest, reached: f64| {
        let spec = machine.axes.iter().find(|of| of.name() == axis.name && of.axis().kind == AxisKind::Linear)?;
        Some(Unreached { axis: axis.name.clone(), reached_mm_s2: reached, limit_mm_s2: spec.limits().acceleration })
    };
    let axes = bundle.manifest.axes.iter().zip(&ranges).filter_map(|(axis, range)| of_axis(axis, range.acceleration));
    let axes: Vec<Unreached> = axes.collect();
    let none = axes.iter().all(|axis| axis.reached_mm_s2 < REACHED_SHARE * axis.limit_mm_s2);
    (none && !axes.is_empty()).then_some(axes)
}

/// Checks logs for training; the report lists their faults.
#[must_use]
pub fn check(logs: &[Log]) -> Report {
    assess_runs(logs, Purpose::Training)
}

/// Trains a model on `logs`. `spec` gives limits and kinematics; without it the limits are the largest speeds and
/// accelerations in the logs. Of long logs it takes the stretches that show most of their motion. The README's figures are those of two minutes of motion; on them training takes less than a minute on two cores.
///
/// Findings of [`check`] that do not refuse the logs are not repeated here.
///
/// # Errors
/// When the logs are not fit for training, with the reasons, or `progress` cancels.
pub fn train(logs: &[Log], spec: Option<&MachineSpec>, settings: &TrainSettings, progress: Progress<'_>) -> Result<Trained> {
    check_fit(logs)?;
    let samples: usize = logs.iter().map(Log::len).sum();
    if samples > settings.most_samples {
        let recordings: Vec<Recording> = logs.iter().cloned().map(Recording::from).collect();
        return train_on_stretches(&recordings, spec, settings, progress);
    }
    let rows: Vec<Range<usize>> = logs.iter().map(|log| 0..log.len()).collect();
    let spec = match spec {
        Some(spec) => Limits::Given(spec),
        None => Limits::Reached(Reached::of(logs)),
    };
    fit(logs, &rows, spec, settings, progress)
}

/// As [`train`], on the stretches of recordings of any length that show most of their motion; of a file only these are held. The chosen
/// stretches are checked.
///
/// # Errors
/// As [`train`], and when a file cannot be read.
pub fn train_on_stretches(
    recordings: &[Recording],
    spec: Option<&MachineSpec>,
    settings: &TrainSettings,
    progress: Progress<'_>,
) -> Result<Trained> {
    let of: usize = recordings.iter().map(Recording::len).sum();
    let chosen = datasets::stretches(recordings, settings.most_samples.min(of.saturating_sub(1)))?.unwrap_or_default();
    let (runs, rows): (Vec<Log>, Vec<Range<usize>>) = chosen.into_iter().map(|stretch| (stretch.log, stretch.rows)).unzip();
    check_stretches(&runs)?;
    let limits = match spec {
        Some(spec) => Limits::Given(spec),
        None => Limits::Reached(Reached::of_recordings(recordings)?),
    };
    let trained = fit(&runs, &rows, limits, settings, progress)?;
    let samples = rows.iter().map(ExactSizeIterator::len).sum();
    Ok(Trained { stretches: Some(Stretches { runs, samples, of }), ..trained })
}

fn check_fit(logs: &[Log]) -> Result<()> {
    let report = check(logs);
    if report.is_refused() { Err(Error::unfit(&report)) } else { Ok(()) }
}

/// Refuses stretches that are not fit as a set, or of which most are not fit: a single one may show a standstill and nothing else.
fn check_stretches(runs: &[Log]) -> Result<()> {
    let report = check(runs);
    let (mut unfit, mut of_set) = (BTreeSet::new(), false);
    for finding in report.of(Severity::Refuse) {
        match &finding.place.run {
            Some(run) if finding.check != Check::Runs => drop(unfit.insert(run.as_str())),
            _ => of_set = true,
        }
    }
    if of_set || 2 * unfit.len() > runs.len() { Err(Error::unfit(&report)) } else { Ok(()) }
}

/// Largest relative difference of sampling periods that are the same.
const SAME_PERIOD: f64 = 1e-6;

/// Where the limits of a model come from.
enum Limits<'a> {
    Given(&'a MachineSpec),
    Reached(Reached),
}

/// A model of another period than that of the machine file compensates nothing that is planned with it.
fn check_period(limits: &Limits<'_>, period_s: f64) -> Result<()> {
    let Limits::Given(spec) = limits else { return Ok(()) };
    let (log_ms, file_ms) = (1e3 * period_s, spec.sampling_period_ms);
    if (log_ms / file_ms - 1.0).abs() <= SAME_PERIOD { Ok(()) } else { Err(Error::OtherPeriod { log_ms, file_ms }) }
}

/// Ratio of the speed in logs to the limit of the machine file from which on they are not of one unit, or not of one machine: 25.4 and 57.3 for inches and
/// degrees; a file that states the half of an axis's speed is still used.
const OTHER_UNIT: f64 = 10.0;

/// Refuses logs that are far faster than the machine file allows.
fn check_speeds(limits: &Limits<'_>, logs: &[Log]) -> Result<()> {
    let Limits::Given(spec) = limits else { return Ok(()) };
    check_reached(spec, |name| {
        let columns = logs.iter().filter_map(|log| Some((log.reference.column(name)?, log.period_s())));
        columns.map(|(column, period_s)| limits_from_log::speed(column, period_s)).fold(0.0, f64::max)
    })
}

/// Refuses a machine for a model whose logs were far faster than the machine allows.
///
/// # Errors
/// [`Error::OtherSpeed`].
pub fn check_machine(model: &Bundle, spec: &MachineSpec) -> Result<()> {
    let (axes, coverage) = (model.axes(), model.coverage());
    check_reached(spec, |name| {
        let of_axis = axes.iter().zip(&coverage).filter(|(axis, _)| axis.name == name);
        of_axis.map(|(_, range)| range.velocity).fold(0.0, f64::max)
    })
}

/// Refuses axes that were far faster, mm/s or rad/s, than the machine allows.
fn check_reached(spec: &MachineSpec, reached: impl Fn(&str) -> f64) -> Result<()> {
    for axis in &spec.axes {
        let (name, allowed) = (axis.name(), axis.limits().velocity);
        let reached = reached(name);
        if reached > OTHER_UNIT * allowed {
            let unit = if axis.axis().kind == AxisKind::Linear { "mm/s" } else { "rad/s" };
            return Err(Error::OtherSpeed { axis: name.to_owned(), reached, allowed, unit });
        }
    }
    Ok(())
}

/// Trains on the samples `rows` of `logs`.
fn fit(
    logs: &[Log],
    rows: &[Range<usize>],
    limits: Limits<'_>,
    settings: &TrainSettings,
    progress: Progress<'_>,
) -> Result<Trained> {
    let data_sha256 = data_hash(logs);
    let corrected = without_offsets(logs);
    let logs = corrected.as_deref().unwrap_or(logs);
    let Some(first) = logs.first() else { return Err(Error::NoLog) };
    let (axes, period_s) = (first.axes().to_vec(), first.period_s());
    check_period(&limits, period_s)?;
    check_speeds(&limits, logs)?;
    let moving: Vec<usize> = (0..axes.len()).filter(|axis| logs.iter().any(|log| moving_axes(log).contains(axis))).collect();
    let samples: usize = rows.iter().map(ExactSizeIterator::len).sum();
    let most = (FOLD_SAMPLES / samples.max(1)).clamp(1, MOST_FOLDS);
    let folds = datasets::folds(logs, settings.held_out, most, settings.seed)?;
    let steps = Steps::new(progress, Job::Training, moving.len());
    let runs: Vec<(Vec<AxisRun>, bool)> =
        moving.iter().map(|&axis| (runs(logs, rows, axis), axes[axis].kind == AxisKind::Rotary)).collect();
    steps.at("servo models")?;
    let servos = servo_models(&runs, settings);
    let fitted: Vec<Result<FittedAxis>> = std::thread::scope(|scope| {
        let jobs: Vec<_> = moving
            .iter()
            .zip(&runs)
            .zip(servos)
            .map(|((&axis, (runs, _)), servo)| {
                let (folds, name, steps) = (&folds, &axes[axis], &steps);
                scope.spawn(move || {
                    let fitted = fit_axis(runs, servo, folds, name, settings, &|note| steps.at(note))?;
                    steps.step(&name.name)?;
                    Ok(fitted)
                })
            })
            .collect();
        jobs.into_iter().map(|job| job.join().unwrap_or_else(|_| Err(Error::Thread))).collect()
    });
    let mut fitted: Vec<FittedAxis> = fitted.into_iter().collect::<Result<_>>()?;
    let (spec_of_model, limits_from_log) = match limits {
        Limits::Given(spec) => (spec.clone(), false),
        Limits::Reached(reached) => (reached.spec(&moving, period_s)?, true),
    };
    let manifest = Manifest {
        format: FORMAT,
        version: env!("CARGO_PKG_VERSION").to_owned(),
        date: None,
        period_s,
        seed: settings.seed,
        data_sha256,
        common_delay_s: common_delay_s(logs, &moving),
        machine_toml: spec_of_model.to_toml()?,
        limits_from_log,
        control: None,
        axes: moving.iter().zip(&fitted).map(|(&axis, fitted)| manifest_of(&axes[axis], fitted)).collect(),
    };
    let held_out = fitted.iter_mut().map(|fitted| std::mem::take(&mut fitted.held_out_pieces)).collect();
    let notes = fitted.iter().map(|fitted| fitted.note.clone()).collect();
    let predictors: Vec<Box<dyn AxisPredictor>> = fitted.into_iter().map(|fitted| fitted.predictor).collect();
    Ok(Trained {
        bundle: Bundle::new(manifest, &predictors)?,
        notes,
        held_out,
        lags_s: moving.iter().map(|&axis| axis_lag_s(logs, axis)).collect(),
        left_out: (0..axes.len()).filter(|axis| !moving.contains(axis)).map(|axis| axes[axis].name.clone()).collect(),
        stretches: None,
    })
}

/// A machine description with the limits that the moving axes reached in `logs`.
///
/// # Errors
/// When there is no log, or no axis moved.
pub fn limits_of_logs(logs: &[&Log]) -> Result<MachineSpec> {
    let first = logs.first().ok_or(Error::NoLog)?;
    let moving: Vec<usize> =
        (0..first.axes().len()).filter(|axis| logs.iter().any(|log| moving_axes(log).contains(axis))).collect();
    Reached::of(logs.iter().copied()).spec(&moving, first.period_s())
}

fn runs(logs: &[Log], rows: &[Range<usize>], axis: usize) -> Vec<AxisRun> {
    let run = |log: &Log| AxisRun::new(log.reference.columns()[axis].clone(), log.actual.columns()[axis].clone(), log.period_s());
    logs.iter().zip(rows).map(|(log, rows)| run(log).only(std::slice::from_ref(rows))).collect()
}

fn manifest_of(axis: &Axis, fitted: &FittedAxis) -> AxisManifest {
    AxisManifest {
        name: axis.name.clone(),
        rotary: axis.kind == AxisKind::Rotary,
        predictor: String::new(),
        settings: Default::default(),
        held_out: fitted.held_out,
        coverage: fitted.coverage,
        band: fitted.band.clone(),
    }
}

impl Trained {
    /// The runs that [`Trained::held_out`] counts: `logs`, those of the training, or the stretches taken of them.
    #[must_use]
    pub fn runs<'a>(&'a self, logs: &'a [Log]) -> &'a [Log] {
        self.stretches.as_ref().map_or(logs, |stretches| &stretches.runs)
    }
}

/// An axis whose model leaves more than half of the tracking error on held-out data.
#[derive(Debug, Clone, PartialEq)]
pub struct Doubt {
    /// Name of the axis.
    pub axis: String,
    /// Unit in which its errors are shown.
    pub unit: ErrorUnit,
    /// RMS error of the model on held-out data, mm or rad.
    pub rms: f64,
    /// RMS tracking error on the same data, mm or rad.
    pub raw_rms: f64,
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { axis, unit, rms, raw_rms } = self;
        write!(
            f,
            "axis {axis}: the model leaves {} of {} RMS on held-out data; most of this axis's error is noise or has a cause that the log does not show",
            unit.number(*rms),
            unit.text(*raw_rms)
        )
    }
}

/// Share of the tracking error above which the residual error raises a warning.
const DOUBTFUL_SHARE: f64 = 0.5;

impl Trained {
    /// Axes whose model leaves more than half of the tracking error on held-out data.
    ///
    /// # Errors
    /// [`Error::NoBetterThanNoModel`] when an axis is predicted no better than without a model. Such a model must not
    /// be written.
    pub fn doubts(&self) -> Result<Vec<Doubt>> {
        let mut doubts = Vec::new();
        for axis in &self.bundle.manifest.axes {
            let HeldOut { rms, raw_rms, .. } = axis.held_out;
            let unit = ErrorUnit::from(axis);
            if rms.is_nan() || rms >= raw_rms {
                return Err(Error::NoBetterThanNoModel { axis: axis.name.clone(), unit, rms, raw_rms });
            }
            if rms > DOUBTFUL_SHARE * raw_rms {
                doubts.push(Doubt { axis: axis.name.clone(), unit, rms, raw_rms });
            }
        }
        Ok(doubts)
    }
}
