//! Predictor of one axis: fitted to all runs, evaluated on held-out runs.

use datasets::Fold;
use models::staged::StagedPredictor;
use models::{AxisPredictor, HeldOut, OperatingRange, PredictionInterval};
use motion::Axis;
use training::AxisRun;
use training::network::NetworkRecipe;
use training::staged::{ServoFit, StagedRecipe, StagedReport};

use super::cross_fit::{self, FoldErrors, Piece, only, without};
use super::settings::TrainSettings;
use crate::error::{Error, Result};
use crate::statistics::rms_max;
use crate::units::ErrorUnit;

/// Predictor of an axis with the data of its manifest.
pub(super) struct FittedAxis {
    pub predictor: Box<dyn AxisPredictor>,
    pub held_out: HeldOut,
    pub coverage: OperatingRange,
    pub band: PredictionInterval,
    /// Errors on held-out samples.
    pub held_out_pieces: Vec<Piece>,
    pub note: String,
}

/// Fits an axis to all runs, and to the runs without each fold to evaluate the same procedure on held-out data.
///
/// A predictor whose training takes minutes is not trained again on all runs; the one of the first fold is kept.
///
/// # Errors
/// When a fit fails, or `at`, called before every fit, cancels.
pub(super) fn fit_axis(
    runs: &[AxisRun],
    servo: Option<ServoFit>,
    folds: &[Fold],
    axis: &Axis,
    settings: &TrainSettings,
    at: &dyn Fn(&str) -> Result<()>,
) -> Result<FittedAxis> {
    let stages = Stages::find(runs, servo, axis, settings, at)?;
    let mut fold_errors = Vec::new();
    let mut kept = None;
    let mut networks_paid = 0;
    let refit = settings.recipe.staged.is_some();
    let evaluated = if refit { folds } else { &folds[..1] };
    for (index, fold) in evaluated.iter().enumerate() {
        at(&format!("{}, fold {} of {}", axis.name, index + 1, evaluated.len()))?;
        let (training, held_out) = (without(runs, fold), only(runs, fold));
        let fit = fit_recipe(&training, axis, settings, Network::Try, stages.refitted(&training, settings)?)?;
        networks_paid += usize::from(fit.network);
        let linear = fit_linear(&training, axis, settings.seed)?;
        fold_errors.push(FoldErrors {
            rich: cross_fit::pieces(fit.predictor.as_ref(), &held_out),
            simple: cross_fit::pieces(linear.predictor.as_ref(), &held_out),
        });
        kept = kept.or(Some(fit));
    }
    at(&format!("{}, all runs", axis.name))?;
    // A stage is used only where it also helps on the outer folds: data that evaluate a predictor do not choose it.
    let choice = cross_fit::choose(&fold_errors, refit);
    let Fit { predictor, note, inner_rms, .. } = match kept.filter(|_| choice.simple || !refit) {
        Some(fit) if choice.simple => {
            let note = format!("{}; worse than the linear law on held-out runs, which is taken instead", fit.note);
            Fit { note, ..fit_linear(runs, axis, settings.seed)? }
        }
        Some(fit) => fit,
        // Where all folds agree on the network, the trial is skipped. It takes longer than all other steps together.
        None => {
            let network = match networks_paid {
                0 => Network::Skip,
                paid if paid == fold_errors.len() => Network::Take,
                _ => Network::Try,
            };
            fit_recipe(runs, axis, settings, network, stages.fitted)?
        }
    };
    let covered =
        runs.iter().zip(&folds[0]).filter(|(_, rows)| refit || rows.is_empty()).map(|(run, _)| run.reference.as_slice());
    let coverage = OperatingRange::of(covered, period_of(runs));
    let (band, band_held) = cross_fit::prediction_interval(runs, &choice.pieces, coverage.velocity);
    let errors: Vec<f64> = choice.pieces.iter().flat_map(|piece| &piece.errors).copied().collect();
    let (rms, max) = rms_max(&errors);
    let linear: Vec<f64> = fold_errors.iter().flat_map(|fold| &fold.simple).flat_map(|piece| &piece.errors).copied().collect();
    let raw = cross_fit::tracking_errors(runs, &choice.pieces);
    let worst_window = cross_fit::worst_window(&choice.pieces, period_of(runs));
    // The predictor fitted to all runs gives the shape of its errors; the held-out samples give their size.
    let spread = match inner_rms.filter(|_| refit) {
        Some(inner_rms) => {
            let kept = cross_fit::pieces(predictor.as_ref(), runs);
            cross_fit::spread(runs, &kept, coverage.velocity, inner_rms, &choice.pieces)
        }
        None => cross_fit::spread(runs, &choice.pieces, coverage.velocity, rms, &choice.pieces),
    };
    let band = band.with_spread(spread);
    let (linear_rms, raw_rms) = (rms_max(&linear).0, rms_max(&raw).0);
    let held_out = HeldOut { rms, max, linear_rms, raw_rms, band_held, folds: fold_errors.len(), worst_window };
    let note = format!("{}: {note}", axis.name);
    Ok(FittedAxis { predictor, held_out, coverage, band, held_out_pieces: choice.pieces, note })
}

fn period_of(runs: &[AxisRun]) -> f64 {
    runs.first().map_or(0.002, |run| run.period_s)
}

/// Servo models of the axes, for their runs; none for a recipe that does not ask for friction.
pub(super) fn servo_models(axes: &[(Vec<AxisRun>, bool)], settings: &TrainSettings) -> Vec<Option<ServoFit>> {
    match &settings.recipe.staged {
        Some(recipe) if !recipe.stop_half_widths.is_empty() => ServoFit::identify_all(axes),
        _ => vec![None; axes.len()],
    }
}

/// A predictor fitted to runs.
struct Fit {
    predictor: Box<dyn AxisPredictor>,
    /// Summary of its structure.
    note: String,
    /// Whether it includes a network on the residual of the stages.
    network: bool,
    /// RMS residual of its stages in their own cross-validation, mm or rad; `None` for a network alone.
    inner_rms: Option<f64>,
}

/// Treatment of the network on the residual of the stages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Network {
    /// Train it on part of the samples; train it again on all of them if it lowers the error on the others.
    Try,
    Take,
    Skip,
}

/// Least-squares stages fitted to runs, and a note on what they start from.
type FittedStages = (StagedPredictor, StagedReport, &'static str);

/// The stages of an axis: fitted to all its runs, on a servo model where it is better on held-out runs.
struct Stages {
    /// `None` for a network without stages.
    fitted: Option<FittedStages>,
    /// The servo model, where the stages start from it.
    servo: Option<ServoFit>,
}

impl Stages {
    fn find(
        runs: &[AxisRun],
        servo: Option<ServoFit>,
        axis: &Axis,
        settings: &TrainSettings,
        at: &dyn Fn(&str) -> Result<()>,
    ) -> Result<Self> {
        let Some(recipe) = &settings.recipe.staged else { return Ok(Self { fitted: None, servo: None }) };
        at(&format!("{}, stages", axis.name))?;
        let (predictor, report, taken) = training::staged::fit_best(runs, servo.as_ref(), recipe)?;
        Ok(Self { fitted: Some((predictor, report, note_of(taken))), servo: servo.filter(|_| taken) })
    }

    /// The same procedure on a part of the runs.
    fn refitted(&self, runs: &[AxisRun], settings: &TrainSettings) -> Result<Option<FittedStages>> {
        let Some(recipe) = &settings.recipe.staged else { return Ok(None) };
        let servo = self.servo.as_ref().and_then(|servo| servo.refit(runs));
        let base = servo.as_ref().map(ServoFit::base);
        let (predictor, report) = training::staged::fit_on(runs, base.as_ref(), recipe)?;
        Ok(Some((predictor, report, note_of(base.is_some()))))
    }
}

fn note_of(on_servo: bool) -> &'static str {
    if on_servo { "servo model, then " } else { "" }
}

fn fit_recipe(
    runs: &[AxisRun],
    axis: &Axis,
    settings: &TrainSettings,
    network: Network,
    stages: Option<FittedStages>,
) -> Result<Fit> {
    match (stages, &settings.recipe.network) {
        (Some(stages), recipe) => {
            with_network(stages, runs, recipe.as_ref().map(|recipe| (recipe, network)), axis, settings.seed)
        }
        (None, Some(network)) => fit_network(runs, network, axis, settings),
        (None, None) => Err(Error::EmptyRecipe),
    }
}

/// Linear stage alone.
fn fit_linear(runs: &[AxisRun], axis: &Axis, seed: u64) -> Result<Fit> {
    let law = StagedRecipe { stop_half_widths: Vec::new(), ..StagedRecipe::default() };
    let (predictor, report) = training::staged::fit(runs, &law)?;
    with_network((predictor, report, ""), runs, None, axis, seed)
}

/// Grey-box cascade, with a network on its residual where that lowers the error.
fn with_network(
    (staged, report, base): FittedStages,
    runs: &[AxisRun],
    network: Option<(&NetworkRecipe, Network)>,
    axis: &Axis,
    seed: u64,
) -> Result<Fit> {
    let mut note = format!("{base}{} ({} columns, {} lines)", report.chosen, report.columns, report.lines.len());
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

/// Network on the papers' features. Early stopping uses runs of its own, so that the held-out figures stay unbiased.
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

/// Split for early stopping: one run in six, at least one; of a single run its last sixth.
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
