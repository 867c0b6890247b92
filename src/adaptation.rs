//! A model adapted to another machine, or to the same one later, with a few seconds of its log.

use std::time::Instant;

use anyhow::Result;
use datasets::{Log, Severity, scored};
use models::staged::StagedPredictor;
use models::{AxisPredictor, AxisSignal, Band, Bundle, Manifest, StackedPredictor};
use training::staged::{AxisRun, StagedRecipe, adapt as adapt_axis};

use crate::evaluate::rms_max;
use crate::output::Refusal;
use crate::training_run::{check, data_hash};
use crate::units::ErrorUnit;

/// What became of one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct AdaptedAxis {
    /// Name of the axis.
    pub name: String,
    /// Unit in which its errors are shown.
    pub unit: ErrorUnit,
    /// Root mean square error of the model as it was, on the new log; mm or rad.
    pub before: f64,
    /// The same of the adapted one, on folds of the new log that it was not fitted to.
    pub held_out: f64,
    /// Whether the adapted one was taken: only where it is better.
    pub taken: bool,
}

/// An adapted model.
#[derive(Debug)]
pub struct Adapted {
    /// The model.
    pub bundle: Bundle,
    /// Every axis of it.
    pub axes: Vec<AdaptedAxis>,
    /// Time taken, s.
    pub seconds: f64,
}

/// Adapts the staged predictors of `bundle` to `logs`.
///
/// # Errors
/// When the logs are not fit, lack an axis of the model, or are sampled at another rate; when an axis has another kind of predictor.
pub fn adapt(bundle: &Bundle, logs: &[Log]) -> Result<Adapted> {
    let started = Instant::now();
    let report = check(logs);
    if report.is_refused() {
        let reasons: Vec<String> = report.of(Severity::Refuse).map(ToString::to_string).collect();
        return Err(Refusal(format!("the log is not fit for training:\n  {}", reasons.join("\n  "))).into());
    }
    let recipe = StagedRecipe::default();
    let mut predictors: Vec<Box<dyn AxisPredictor>> = Vec::new();
    let mut axes = Vec::new();
    let mut manifest = Manifest { data_sha256: data_hash(logs), ..bundle.manifest.clone() };
    for (predictor, axis) in bundle.predictors()?.into_iter().zip(&mut manifest.axes) {
        let stacked =
            (predictor.kind() == models::stacked::KIND).then(|| StackedPredictor::from_saved(&predictor.save())).transpose()?;
        if predictor.kind() != models::staged::KIND && stacked.is_none() {
            return Err(Refusal(format!(
                "axis {} has a predictor of the kind `{}`; only staged models can be adapted: train a new one",
                axis.name,
                predictor.kind()
            ))
            .into());
        }
        let staged = match &stacked {
            Some(stacked) => stacked.base().clone(),
            None => StagedPredictor::from_saved(&predictor.save())?,
        };
        let runs = runs_of(logs, &axis.name)?;
        let (adapted, report) = adapt_axis(&staged, &runs, &recipe).map_err(|error| Refusal(error.to_string()))?;
        let taken = report.held_out_rms < report.before_rms;
        let adapted = with_network(adapted, stacked, &runs)?;
        let signals = errors(adapted.as_ref(), &runs);
        axis.held_out.rms = if taken { report.held_out_rms } else { report.before_rms };
        axis.held_out.max = signals.iter().map(|(_, errors)| rms_max(errors).1).fold(0.0, f64::max);
        axis.band = Band::fit(&signals, axis.coverage.velocity);
        let unit = ErrorUnit::from(&*axis);
        axes.push(AdaptedAxis { name: axis.name.clone(), unit, before: report.before_rms, held_out: report.held_out_rms, taken });
        predictors.push(adapted);
    }
    Ok(Adapted { bundle: Bundle::new(manifest, &predictors)?, axes, seconds: started.elapsed().as_secs_f64() })
}

/// The adapted predictor, with the old one's network where that still helps on the log.
fn with_network(adapted: StagedPredictor, stacked: Option<StackedPredictor>, runs: &[AxisRun]) -> Result<Box<dyn AxisPredictor>> {
    let Some(stacked) = stacked else { return Ok(Box::new(adapted)) };
    let with = stacked.with_base(adapted.clone())?;
    let rms = |predictor: &dyn AxisPredictor| {
        let errors: Vec<f64> = errors(predictor, runs).into_iter().flat_map(|(_, errors)| errors).collect();
        rms_max(&errors).0
    };
    Ok(if rms(&with) < rms(&adapted) { Box::new(with) } else { Box::new(adapted) })
}

fn runs_of(logs: &[Log], axis: &str) -> Result<Vec<AxisRun>> {
    logs.iter()
        .map(|log| {
            let (Some(reference), Some(actual)) = (log.reference.column(axis), log.actual.column(axis)) else {
                return Err(Refusal(format!("the log {} lacks the axis {axis}, which the model has", log.name)).into());
            };
            Ok(AxisRun { reference: reference.to_vec(), actual: actual.to_vec(), period_s: log.period_s() })
        })
        .collect()
}

/// Prediction errors on the scored samples of every run.
fn errors<'a>(predictor: &dyn AxisPredictor, runs: &'a [AxisRun]) -> Vec<(AxisSignal<'a>, Vec<f64>)> {
    runs.iter()
        .map(|run| {
            let scored = scored(&run.reference, run.period_s);
            let predicted = predictor.predict(&AxisSignal::uncompensated(&run.reference, run.period_s));
            let errors = scored.clone().map(|k| predicted[k] - (run.reference[k] - run.actual[k])).collect();
            (AxisSignal::uncompensated(&run.reference[scored], run.period_s), errors)
        })
        .collect()
}
