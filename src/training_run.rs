//! From logs to a model: checks, splits, one predictor an axis, figures on runs that training never saw.

use std::time::Instant;

use anyhow::Result;
use datasets::{Log, Purpose, Report, Severity, assess_runs, moving_axes, split_logs};
use machine::MachineSpec;
use models::staged::StagedPredictor;
use models::{AxisManifest, AxisPredictor, AxisSignal, Band, Bundle, Coverage, FORMAT, HeldOut, Manifest};
use motion::{Axis, AxisKind, lag_s};
use serde_json::{Map, Value, json};
use sha2::{Digest, Sha256};
use training::Recipe;
use training::network::NetworkRecipe;
use training::staged::{AxisRun, StagedRecipe};

use crate::evaluate::rms_max;
use crate::output::{Refusal, table};
use crate::progress::Progress;
use crate::units::ErrorUnit;

/// Settings of a training.
#[derive(Debug, Clone, PartialEq)]
pub struct TrainSettings {
    /// How axes are predicted.
    pub recipe: Recipe,
    /// Share of the samples that is held out, as whole runs.
    pub held_out: f64,
    /// Seed of everything random.
    pub seed: u64,
    /// Folder for the networks' checkpoints.
    pub checkpoints: Option<std::path::PathBuf>,
}

impl TrainSettings {
    /// The usual settings for a recipe.
    #[must_use]
    pub fn of(recipe: Recipe, seed: u64) -> Self {
        Self { recipe, held_out: 0.2, seed, checkpoints: None }
    }
}

/// A model and how it was found.
#[derive(Debug)]
pub struct Trained {
    /// The model.
    pub bundle: Bundle,
    /// Time taken, s.
    pub seconds: f64,
    /// Notes on every axis: stages tried, epochs run.
    pub notes: Vec<String>,
    /// Axes that the log holds but that never moved.
    pub left_out: Vec<String>,
    /// Lag of every axis of the model, s.
    pub lags_s: Vec<Option<f64>>,
}

/// Checks logs for training and reads what is wrong with them.
#[must_use]
pub fn check(logs: &[Log]) -> Report {
    assess_runs(logs, Purpose::Training)
}

/// Trains a model on `logs`; `spec` gives limits and kinematics, without it they are taken from what the logs reached.
///
/// # Errors
/// When the logs are not fit for training; says why.
pub fn train(logs: &[Log], spec: Option<&MachineSpec>, settings: &TrainSettings) -> Result<Trained> {
    let started = Instant::now();
    let report = check(logs);
    if report.is_refused() {
        let reasons: Vec<String> = report.of(Severity::Refuse).map(ToString::to_string).collect();
        return Err(Refusal(format!("the log is not fit for training:\n  {}", reasons.join("\n  "))).into());
    }
    let Some(first) = logs.first() else { return Err(Refusal("there is no log".into()).into()) };
    let (axes, period_s) = (first.axes().to_vec(), first.period_s());
    let moving: Vec<usize> = (0..axes.len()).filter(|axis| logs.iter().any(|log| moving_axes(log).contains(axis))).collect();
    let split = split_logs(logs, settings.held_out, settings.seed).map_err(|error| Refusal(error.to_string()))?;
    let progress = std::sync::Mutex::new(Progress::new("training", moving.len() as u64));
    let fitted: Vec<Result<FittedAxis>> = std::thread::scope(|scope| {
        let jobs: Vec<_> = moving
            .iter()
            .map(|&axis| {
                let (split, name, progress) = (&split, &axes[axis], &progress);
                scope.spawn(move || {
                    let fitted = fit_axis(&runs(&split.training, axis), &runs(&split.held_out, axis), name, settings);
                    if let Ok(mut progress) = progress.lock() {
                        progress.step(&name.name);
                    }
                    fitted
                })
            })
            .collect();
        jobs.into_iter().map(|job| job.join().unwrap_or_else(|_| Err(anyhow::anyhow!("a training thread failed")))).collect()
    });
    let fitted: Vec<FittedAxis> = fitted.into_iter().collect::<Result<_>>()?;
    let spec_of_model = match spec {
        Some(spec) => spec.clone(),
        None => crate::limits_from_log::spec(logs, &moving, period_s)?,
    };
    let manifest = Manifest {
        format: FORMAT,
        version: env!("CARGO_PKG_VERSION").to_owned(),
        period_s,
        seed: settings.seed,
        data_sha256: data_hash(logs),
        common_delay_s: common_delay_s(logs, &moving),
        machine_toml: spec_of_model.to_toml()?,
        limits_from_log: spec.is_none(),
        axes: moving.iter().zip(&fitted).map(|(&axis, fitted)| manifest_of(&axes[axis], fitted)).collect(),
    };
    let notes = fitted.iter().map(|fitted| fitted.note.clone()).collect();
    let predictors: Vec<Box<dyn AxisPredictor>> = fitted.into_iter().map(|fitted| fitted.predictor).collect();
    Ok(Trained {
        bundle: Bundle::new(manifest, &predictors)?,
        seconds: started.elapsed().as_secs_f64(),
        notes,
        lags_s: moving.iter().map(|&axis| axis_lag_s(logs, axis)).collect(),
        left_out: (0..axes.len()).filter(|axis| !moving.contains(axis)).map(|axis| axes[axis].name.clone()).collect(),
    })
}

fn runs(logs: &[Log], axis: usize) -> Vec<AxisRun> {
    logs.iter()
        .map(|log| AxisRun {
            reference: log.reference.columns()[axis].clone(),
            actual: log.actual.columns()[axis].clone(),
            period_s: log.period_s(),
        })
        .collect()
}

struct FittedAxis {
    predictor: Box<dyn AxisPredictor>,
    held_out: HeldOut,
    coverage: Coverage,
    band: Band,
    note: String,
}

fn fit_axis(training: &[AxisRun], held_out: &[AxisRun], axis: &Axis, settings: &TrainSettings) -> Result<FittedAxis> {
    let law = StagedRecipe { stop_half_widths: Vec::new(), ..StagedRecipe::default() };
    let linear = fit_stages(training, &law, None, axis, settings.seed)?;
    let linear_errors = held_out_errors(linear.predictor.as_ref(), held_out);
    let fit = match (&settings.recipe.staged, &settings.recipe.network) {
        (Some(staged), network) => fit_stages(training, staged, network.as_ref(), axis, settings.seed)?,
        (None, Some(network)) => fit_network(training, network, axis, settings)?,
        (None, None) => anyhow::bail!(Refusal("the recipe has no stage".into())),
    };
    let errors = held_out_errors(fit.predictor.as_ref(), held_out);
    let rms_of = |errors: &[Vec<f64>]| rms_max(&errors.concat()).0;
    // Stages that paid within the training runs and do not on others are not shipped.
    let (Fit { predictor, note, again }, errors) = if settings.recipe.staged.is_some() && rms_of(&errors) > rms_of(&linear_errors)
    {
        let note = format!("{}; worse than the linear law on held-out runs, which is taken instead", fit.note);
        (Fit { note, ..linear }, linear_errors.clone())
    } else {
        (fit, errors)
    };
    // What was held out has done its work: the model that is kept learns from it as well, where that takes seconds.
    let covered = if again.is_some() { held_out } else { &[] };
    let predictor = match again {
        Some(again) => again(&[training, held_out].concat())?,
        None => predictor,
    };
    let note = format!("{}: {note}", axis.name);
    let coverage = Coverage::of(training.iter().chain(covered).map(|run| run.reference.as_slice()), period_of(training));
    let (band, band_held) = bands(held_out, &errors, coverage.velocity);
    let flat: Vec<f64> = errors.iter().flatten().copied().collect();
    let (rms, max) = rms_max(&flat);
    let raw: Vec<f64> = held_out.iter().flat_map(|run| scored(run).map(|k| run.reference[k] - run.actual[k])).collect();
    let linear_flat: Vec<f64> = linear_errors.into_iter().flatten().collect();
    Ok(FittedAxis {
        predictor,
        held_out: HeldOut { rms, max, linear_rms: rms_max(&linear_flat).0, raw_rms: rms_max(&raw).0, band_held },
        coverage,
        band,
        note,
    })
}

/// Fits a predictor to runs.
type Refit<'a> = Box<dyn Fn(&[AxisRun]) -> Result<Box<dyn AxisPredictor>> + 'a>;

/// A predictor fitted to the training runs.
struct Fit<'a> {
    predictor: Box<dyn AxisPredictor>,
    /// What it is made of.
    note: String,
    /// Fits the same stages to more runs, where that is quick.
    again: Option<Refit<'a>>,
}

/// The staged predictor, with a network on what it leaves where that pays.
fn fit_stages<'a>(
    runs: &[AxisRun],
    recipe: &'a StagedRecipe,
    network: Option<&'a NetworkRecipe>,
    axis: &Axis,
    seed: u64,
) -> Result<Fit<'a>> {
    let (staged, report) = training::staged::fit(runs, recipe)?;
    let mut note = format!("{} ({} columns, {} lines)", report.chosen, report.columns, report.lines.len());
    let mut kept = None;
    if let Some(network) = network {
        let trial = training::stacked::try_out(&staged, runs, network, seed)?;
        let verdict = if trial.accepted { "kept" } else { "does not pay" };
        let unit = ErrorUnit::from(axis);
        note += &format!("; network on the rest: {} → {}, {verdict}", unit.number(trial.without), unit.text(trial.with));
        kept = trial.accepted.then_some(network);
    }
    let stack = move |staged: StagedPredictor, runs: &[AxisRun]| -> Result<Box<dyn AxisPredictor>> {
        Ok(match kept {
            Some(network) => training::stacked::fit(&staged, runs, network, seed)?,
            None => Box::new(staged),
        })
    };
    let predictor = stack(staged, runs)?;
    let again = move |runs: &[AxisRun]| stack(training::staged::fit(runs, recipe)?.0, runs);
    Ok(Fit { predictor, note, again: Some(Box::new(again)) })
}

/// A network on the papers' features. Early stopping chooses by runs of its own, so that the held-out figures stay honest.
fn fit_network<'a>(runs: &[AxisRun], recipe: &NetworkRecipe, axis: &Axis, settings: &TrainSettings) -> Result<Fit<'a>> {
    let (fitted, validation) = validation_split(runs);
    let trained = match &settings.checkpoints {
        Some(folder) => {
            let go_on = &mut |_| std::ops::ControlFlow::Continue(());
            training::network::train_resumable(&fitted, &validation, recipe, settings.seed, &folder.join(&axis.name), go_on)?
        }
        None => training::network::train(&fitted, &validation, recipe, settings.seed, &mut |_| {})?,
    };
    let note = format!("{} epochs, best after {}", trained.epochs, trained.best_epoch);
    Ok(Fit { predictor: trained.predictor, note, again: None })
}

/// One run in six, at least one, to stop early by; a single run serves as both.
fn validation_split(runs: &[AxisRun]) -> (Vec<AxisRun>, Vec<AxisRun>) {
    if runs.len() < 2 {
        return (runs.to_vec(), runs.to_vec());
    }
    let every = runs.len().min(6);
    let (mut fitted, mut validation) = (Vec::new(), Vec::new());
    for (index, run) in runs.iter().enumerate() {
        if index % every == every - 1 { validation.push(run.clone()) } else { fitted.push(run.clone()) }
    }
    (fitted, validation)
}

fn period_of(runs: &[AxisRun]) -> f64 {
    runs.first().map_or(0.002, |run| run.period_s)
}

fn scored(run: &AxisRun) -> std::ops::Range<usize> {
    datasets::scored(&run.reference, run.period_s)
}

/// Prediction minus measurement on the scored samples of every run.
fn held_out_errors(predictor: &dyn AxisPredictor, runs: &[AxisRun]) -> Vec<Vec<f64>> {
    runs.iter()
        .map(|run| {
            let predicted = predictor.predict(&AxisSignal::uncompensated(&run.reference, run.period_s));
            scored(run).map(|k| predicted[k] - (run.reference[k] - run.actual[k])).collect()
        })
        .collect()
}

/// The band of all held-out runs, and the share of errors in a quarter of each run that a band of the other three holds, over all four.
fn bands(runs: &[AxisRun], errors: &[Vec<f64>], top_speed: f64) -> (Band, f64) {
    let part = |from: f64, to: f64| -> Vec<(AxisSignal<'_>, Vec<f64>)> {
        runs.iter()
            .zip(errors)
            .map(|(run, errors)| {
                let range = scored(run);
                let cut = |share: f64| (errors.len() as f64 * share) as usize;
                let samples = range.start + cut(from)..range.start + cut(to);
                (AxisSignal::uncompensated(&run.reference[samples], run.period_s), errors[cut(from)..cut(to)].to_vec())
            })
            .collect()
    };
    let (mut held, mut all) = (0.0, 0.0);
    for quarter in [0.0, 0.25, 0.5, 0.75] {
        let others = [part(0.0, quarter), part(quarter + 0.25, 1.0)].concat();
        let check = Band::fit(&others, top_speed);
        for (signal, errors) in part(quarter, quarter + 0.25) {
            held += check.held(&signal, &errors) * errors.len() as f64;
            all += errors.len() as f64;
        }
    }
    (Band::fit(&part(0.0, 1.0), top_speed), if all > 0.0 { held / all } else { 0.0 })
}

/// Delay that the moving axes share, s: the mean of their lags, each over all runs. It hardly hurts a contour; differences between axes do.
fn common_delay_s(logs: &[Log], moving: &[usize]) -> f64 {
    let lags: Vec<f64> = moving.iter().filter_map(|&axis| axis_lag_s(logs, axis)).collect();
    lags.iter().sum::<f64>() / lags.len().max(1) as f64
}

/// Mean lag of one axis over the runs, weighted by their length, s.
fn axis_lag_s(logs: &[Log], axis: usize) -> Option<f64> {
    let lags: Vec<(f64, f64)> = logs
        .iter()
        .filter_map(|log| {
            let lag = lag_s(&log.reference.columns()[axis], &log.actual.columns()[axis], log.period_s())?;
            Some((lag, log.len() as f64))
        })
        .collect();
    let samples: f64 = lags.iter().map(|(_, samples)| samples).sum();
    (samples > 0.0).then(|| lags.iter().map(|(lag, samples)| lag * samples).sum::<f64>() / samples)
}

fn manifest_of(axis: &Axis, fitted: &FittedAxis) -> AxisManifest {
    AxisManifest {
        name: axis.name.clone(),
        rotary: axis.kind == AxisKind::Rotary,
        predictor: String::new(),
        settings: Value::Null,
        held_out: fitted.held_out,
        coverage: fitted.coverage,
        band: fitted.band.clone(),
    }
}

pub(crate) fn data_hash(logs: &[Log]) -> String {
    let mut hash = Sha256::new();
    for column in logs.iter().flat_map(|log| log.reference.columns().iter().chain(log.actual.columns())) {
        for value in column {
            hash.update(value.to_le_bytes());
        }
    }
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

impl Trained {
    /// Held-out figures of every axis; µm, or µrad for rotary axes.
    #[must_use]
    pub fn table(&self) -> String {
        let rows: Vec<Vec<String>> = self
            .bundle
            .manifest
            .axes
            .iter()
            .map(|axis| {
                let unit = ErrorUnit::from(axis);
                let HeldOut { rms, max, linear_rms, raw_rms, band_held } = axis.held_out;
                std::iter::once(unit.label(&axis.name))
                    .chain([rms, max, linear_rms, raw_rms].map(|value| unit.number(value)))
                    .chain([format!("{:.1} %", band_held * 100.0), axis.predictor.clone()])
                    .collect()
            })
            .collect();
        table(&["held-out runs", "RMS", "MAX", "linear RMS", "tracking error RMS", "95 % band holds", "predictor"], &rows)
    }

    /// The figures as JSON.
    #[must_use]
    pub fn json(&self) -> Value {
        let axes: Map<String, Value> = self
            .bundle
            .manifest
            .axes
            .iter()
            .zip(&self.lags_s)
            .map(|(axis, lag)| {
                let unit = ErrorUnit::from(axis);
                let HeldOut { rms, max, linear_rms, raw_rms, band_held } = axis.held_out;
                let figures = json!({
                    unit.key("held_out_rms"): unit.value(rms),
                    unit.key("held_out_max"): unit.value(max),
                    unit.key("linear_rms"): unit.value(linear_rms),
                    unit.key("raw_rms"): unit.value(raw_rms),
                    "band_held_share": band_held,
                    "lag_ms": lag.map(|lag| lag * 1e3),
                    "predictor": axis.predictor,
                    "coverage": axis.coverage,
                });
                (axis.name.clone(), figures)
            })
            .collect();
        json!({ "seconds": self.seconds, "axes": axes, "common_lag_ms": self.bundle.manifest.common_delay_s * 1e3, "left_out": self.left_out, "notes": self.notes })
    }
}
