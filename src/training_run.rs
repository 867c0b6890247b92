//! From logs to a model: checks, splits, one predictor an axis, figures on runs that training never saw.

use std::time::Instant;

use anyhow::Result;
use datasets::{Fold, Log, Purpose, Report, Severity, assess_runs, moving_axes};
use machine::MachineSpec;
use models::{AxisManifest, AxisPredictor, Band, Bundle, Coverage, FORMAT, HeldOut, Manifest};
use motion::{Axis, AxisKind, lag_s};
use serde_json::{Map, Value, json};
use sha2::{Digest, Sha256};
use training::network::NetworkRecipe;
use training::staged::StagedRecipe;
use training::{AxisRun, Recipe};

use crate::cross_fit::{self, Judged, only, without};
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

/// Samples that the folds of a cross-fit go over together, and most folds: a short log, of which one part says little, is judged in three, a
/// long one, whose fit takes a minute, in one. Only time speaks against more.
const FOLD_SAMPLES: usize = 60_000;
const MOST_FOLDS: usize = 3;

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
    let samples: usize = logs.iter().map(Log::len).sum();
    let most = (FOLD_SAMPLES / samples.max(1)).clamp(1, MOST_FOLDS);
    let folds = datasets::folds(logs, settings.held_out, most, settings.seed).map_err(|error| Refusal(error.to_string()))?;
    let progress = std::sync::Mutex::new(Progress::new("training", moving.len() as u64));
    let fitted: Vec<Result<FittedAxis>> = std::thread::scope(|scope| {
        let jobs: Vec<_> = moving
            .iter()
            .map(|&axis| {
                let (folds, name, progress) = (&folds, &axes[axis], &progress);
                scope.spawn(move || {
                    let fitted = fit_axis(&runs(logs, axis), folds, name, settings);
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
        .map(|log| AxisRun::new(log.reference.columns()[axis].clone(), log.actual.columns()[axis].clone(), log.period_s()))
        .collect()
}

struct FittedAxis {
    predictor: Box<dyn AxisPredictor>,
    held_out: HeldOut,
    coverage: Coverage,
    band: Band,
    note: String,
}

/// Fits an axis to all runs, and to the runs without each fold, whose errors then judge the same procedure.
///
/// A predictor that takes minutes to train is not trained again on all runs: that of the first fold is kept.
fn fit_axis(runs: &[AxisRun], folds: &[Fold], axis: &Axis, settings: &TrainSettings) -> Result<FittedAxis> {
    let mut judged = Vec::new();
    let mut kept = None;
    let mut networks_paid = 0;
    let again = settings.recipe.staged.is_some();
    for fold in if again { folds } else { &folds[..1] } {
        let (training, held_out) = (without(runs, fold), only(runs, fold));
        let fit = fit_recipe(&training, axis, settings, Network::Try)?;
        networks_paid += usize::from(fit.network);
        let linear = fit_linear(&training, axis, settings.seed)?;
        judged.push(Judged {
            rich: cross_fit::pieces(fit.predictor.as_ref(), &held_out),
            simple: cross_fit::pieces(linear.predictor.as_ref(), &held_out),
        });
        kept = kept.or(Some(fit));
    }
    // Stages that pay on folds within the log and not on others are not shipped; who judges does not choose.
    let choice = cross_fit::choose(&judged, again);
    let Fit { predictor, note, inner_rms, .. } = match kept.filter(|_| choice.simple || !again) {
        Some(fit) if choice.simple => {
            let note = format!("{}; worse than the linear law on held-out runs, which is taken instead", fit.note);
            Fit { note, ..fit_linear(runs, axis, settings.seed)? }
        }
        Some(fit) => fit,
        // Where the folds agree whether a network pays, it need not be found out again: that takes longer than all the rest.
        None => {
            let network = match networks_paid {
                0 => Network::Skip,
                paid if paid == judged.len() => Network::Take,
                _ => Network::Try,
            };
            fit_recipe(runs, axis, settings, network)?
        }
    };
    let covered =
        runs.iter().zip(&folds[0]).filter(|(_, rows)| again || rows.is_empty()).map(|(run, _)| run.reference.as_slice());
    let coverage = Coverage::of(covered, period_of(runs));
    let (band, band_held) = cross_fit::bands(runs, &choice.pieces, coverage.velocity);
    let errors: Vec<f64> = choice.pieces.iter().flat_map(|piece| &piece.errors).copied().collect();
    let (rms, max) = rms_max(&errors);
    let linear: Vec<f64> = judged.iter().flat_map(|judged| &judged.simple).flat_map(|piece| &piece.errors).copied().collect();
    let raw = cross_fit::tracking_errors(runs, &choice.pieces);
    let worst_window = cross_fit::worst_window(&choice.pieces, period_of(runs));
    // What was fitted to all runs says what its errors are like in all of them; how large they are is for rows that were left out to say.
    let spread = match inner_rms.filter(|_| again) {
        Some(inner_rms) => {
            let kept = cross_fit::pieces(predictor.as_ref(), runs);
            cross_fit::spread(runs, &kept, coverage.velocity, inner_rms, &choice.pieces)
        }
        None => cross_fit::spread(runs, &choice.pieces, coverage.velocity, rms, &choice.pieces),
    };
    let band = band.with_spread(spread);
    let (linear_rms, raw_rms) = (rms_max(&linear).0, rms_max(&raw).0);
    let held_out = HeldOut { rms, max, linear_rms, raw_rms, band_held, folds: judged.len(), worst_window };
    Ok(FittedAxis { predictor, held_out, coverage, band, note: format!("{}: {note}", axis.name) })
}

fn period_of(runs: &[AxisRun]) -> f64 {
    runs.first().map_or(0.002, |run| run.period_s)
}

/// A predictor fitted to runs.
struct Fit {
    predictor: Box<dyn AxisPredictor>,
    /// What it is made of.
    note: String,
    /// Whether a network on what the stages leave is part of it.
    network: bool,
    /// What its stages leave in the cross-validation by which they were chosen, mm or rad; `None` of a network alone.
    inner_rms: Option<f64>,
}

/// What becomes of a network on what the stages leave.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Network {
    /// It is trained on a part of the rows, and again on all of them if it pays on the others.
    Try,
    Take,
    Skip,
}

fn fit_recipe(runs: &[AxisRun], axis: &Axis, settings: &TrainSettings, network: Network) -> Result<Fit> {
    match (&settings.recipe.staged, &settings.recipe.network) {
        (Some(staged), recipe) => fit_stages(runs, staged, recipe.as_ref().map(|recipe| (recipe, network)), axis, settings.seed),
        (None, Some(network)) => fit_network(runs, network, axis, settings),
        (None, None) => anyhow::bail!(Refusal("the recipe has no stage".into())),
    }
}

/// The linear law alone.
fn fit_linear(runs: &[AxisRun], axis: &Axis, seed: u64) -> Result<Fit> {
    let law = StagedRecipe { stop_half_widths: Vec::new(), ..StagedRecipe::default() };
    fit_stages(runs, &law, None, axis, seed)
}

/// The staged predictor, with a network on what it leaves where that pays.
fn fit_stages(
    runs: &[AxisRun],
    recipe: &StagedRecipe,
    network: Option<(&NetworkRecipe, Network)>,
    axis: &Axis,
    seed: u64,
) -> Result<Fit> {
    let (staged, report) = training::staged::fit(runs, recipe)?;
    let mut note = format!("{} ({} columns, {} lines)", report.chosen, report.columns, report.lines.len());
    let mut kept = None;
    if let Some((network, wanted)) = network {
        let paid = match wanted {
            Network::Try => {
                let trial = training::stacked::try_out(&staged, runs, network, seed)?;
                let verdict = if trial.accepted { "kept" } else { "does not pay" };
                let unit = ErrorUnit::from(axis);
                note += &format!("; network on the rest: {} → {}, {verdict}", unit.number(trial.without), unit.text(trial.with));
                trial.accepted
            }
            Network::Take => {
                note += "; network on the rest, which paid on held-out runs";
                true
            }
            Network::Skip => {
                note += "; network on the rest did not pay on held-out runs";
                false
            }
        };
        kept = paid.then_some(network);
    }
    let predictor = match kept {
        Some(network) => training::stacked::fit(&staged, runs, network, seed)?,
        None => Box::new(staged),
    };
    Ok(Fit { predictor, note, network: kept.is_some(), inner_rms: report.held_out_rms() })
}

/// A network on the papers' features. Early stopping chooses by runs of its own, so that the held-out figures stay honest.
fn fit_network(runs: &[AxisRun], recipe: &NetworkRecipe, axis: &Axis, settings: &TrainSettings) -> Result<Fit> {
    let (fitted, validation) = validation_split(runs);
    let trained = match &settings.checkpoints {
        Some(folder) => {
            let go_on = &mut |_| std::ops::ControlFlow::Continue(());
            training::network::train_resumable(&fitted, &validation, recipe, settings.seed, &folder.join(&axis.name), go_on)?
        }
        None => training::network::train(&fitted, &validation, recipe, settings.seed, &mut |_| {})?,
    };
    let note = format!("{} epochs, best after {}", trained.epochs, trained.best_epoch);
    Ok(Fit { predictor: trained.predictor, note, network: false, inner_rms: None })
}

/// One run in six, at least one, to stop early by; of a single run a sixth of its rows.
fn validation_split(runs: &[AxisRun]) -> (Vec<AxisRun>, Vec<AxisRun>) {
    if let [run] = runs {
        let rows = run.scored();
        let (first, last) = (rows.first().map_or(0, |rows| rows.start), rows.last().map_or(0, |rows| rows.end));
        let tail = std::slice::from_ref(&(last - (last - first) / 6..last)).to_vec();
        return (vec![run.without(&tail)], vec![run.only(&tail)]);
    }
    let every = runs.len().min(6);
    let (mut fitted, mut validation) = (Vec::new(), Vec::new());
    for (index, run) in runs.iter().enumerate() {
        if index % every == every - 1 { validation.push(run.clone()) } else { fitted.push(run.clone()) }
    }
    (fitted, validation)
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

/// Share of the tracking error from which on what a model leaves is worth a warning.
const LEAVES_MUCH: f64 = 0.5;

impl Trained {
    /// What speaks against the model: axes of which it leaves more than half of the error on data that it never saw.
    ///
    /// # Errors
    /// When an axis is predicted worse than by no model at all: such a model must not be written.
    pub fn doubts(&self) -> Result<Vec<String>, Refusal> {
        let mut doubts = Vec::new();
        for axis in &self.bundle.manifest.axes {
            let HeldOut { rms, raw_rms, .. } = axis.held_out;
            let unit = ErrorUnit::from(axis);
            let figures = format!("{} of {} RMS on held-out data", unit.number(rms), unit.text(raw_rms));
            if rms.is_nan() || rms >= raw_rms {
                return Err(Refusal(format!(
                    "axis {}: the model leaves {figures}, no better than no model; nothing is written. Look for exchanged columns, lost rows or \
                     too little motion, or leave the axis out with --columns",
                    axis.name
                )));
            }
            if rms > LEAVES_MUCH * raw_rms {
                doubts.push(format!(
                    "axis {}: the model leaves {figures}; most of this axis's error is noise or has a cause that the log does not show",
                    axis.name
                ));
            }
        }
        Ok(doubts)
    }

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
                let HeldOut { rms, max, linear_rms, raw_rms, band_held, .. } = axis.held_out;
                std::iter::once(unit.label(&axis.name))
                    .chain([rms, max, linear_rms, raw_rms].map(|value| unit.number(value)))
                    .chain([format!("{:.1} %", band_held * 100.0), axis.predictor.clone()])
                    .collect()
            })
            .collect();
        let folds = self.bundle.manifest.axes.iter().map(|axis| axis.held_out.folds).max().unwrap_or_default();
        let title = format!("held out, {folds} fold{}", if folds == 1 { "" } else { "s" });
        table(&[&title, "RMS", "MAX", "linear RMS", "tracking error RMS", "95 % band holds", "predictor"], &rows)
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
                let HeldOut { rms, max, linear_rms, raw_rms, band_held, .. } = axis.held_out;
                let figures = json!({
                    unit.key("held_out_rms"): unit.value(rms),
                    unit.key("held_out_max"): unit.value(max),
                    unit.key("linear_rms"): unit.value(linear_rms),
                    unit.key("raw_rms"): unit.value(raw_rms),
                    "band_held_share": band_held,
                    "folds": axis.held_out.folds,
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
