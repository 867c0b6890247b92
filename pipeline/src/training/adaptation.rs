//! Adaptation of a model to another machine, or to a later state of the same one, with a few seconds of log.

use datasets::{Fold, Log, Purpose, assess_runs, without_offsets};
use models::staged::StagedPredictor;
use models::{AxisPredictor, Bundle, HeldOut, Manifest, StackedPredictor};
use training::AxisRun;
use training::staged::{StagedRecipe, adapt as adapt_axis};

use super::cross_fit::{self, FoldErrors, only, without};
use super::hash::data_hash;
use crate::error::{Error, Result};
use crate::statistics::rms_max;
use crate::units::ErrorUnit;

/// Result of the adaptation of one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct AdaptedAxis {
    /// Name of the axis.
    pub name: String,
    /// Unit of its errors in reports.
    pub unit: ErrorUnit,
    /// RMS error of the unadapted model on the new log, mm or rad.
    pub before: f64,
    /// RMS error of the adapted predictor on folds of the new log to which it was not fitted, mm or rad.
    pub held_out: f64,
    /// Whether the adapted predictor is used: only where it is better.
    pub taken: bool,
}

/// An adapted model.
#[derive(Debug)]
pub struct Adapted {
    /// The model with its adapted predictors.
    pub bundle: Bundle,
    /// One result for each axis.
    pub axes: Vec<AdaptedAxis>,
}

/// Share of the new log in each held-out fold, and number of folds: together they evaluate the whole log.
const HELD_OUT: f64 = 0.25;
const FOLDS: usize = 4;

/// Adapts the grey-box predictors of `bundle` to `logs`. `seed` selects the folds.
///
/// # Errors
/// When the logs are not fit for training, lack an axis of the model, or have another sampling period; when the
/// predictor of an axis is of another kind.
pub fn adapt(bundle: &Bundle, logs: &[Log], seed: u64) -> Result<Adapted> {
    let report = assess_runs(logs, Purpose::Training);
    if report.is_refused() {
        return Err(Error::unfit(&report));
    }
    let data_sha256 = data_hash(logs);
    let corrected = without_offsets(logs);
    let logs = corrected.as_deref().unwrap_or(logs);
    let folds = datasets::folds(logs, HELD_OUT, FOLDS, seed)?;
    let mut predictors: Vec<Box<dyn AxisPredictor>> = Vec::new();
    let mut axes = Vec::new();
    let mut manifest = Manifest { date: None, data_sha256, ..bundle.manifest.clone() };
    for (predictor, axis) in bundle.predictors()?.into_iter().zip(&mut manifest.axes) {
        let unadapted = Unadapted::of(predictor.as_ref(), &axis.name)?;
        let runs = runs_of(logs, &axis.name)?;
        let fold_errors = |fold: &Fold| -> Result<FoldErrors> {
            let (training, held_out) = (without(&runs, fold), only(&runs, fold));
            let adapted = unadapted.adapted(&training)?;
            Ok(FoldErrors {
                rich: cross_fit::pieces(adapted.as_ref(), &held_out),
                simple: cross_fit::pieces(predictor.as_ref(), &held_out),
            })
        };
        let fold_errors: Vec<FoldErrors> = folds.iter().map(fold_errors).collect::<Result<_>>()?;
        let choice = cross_fit::choose(&fold_errors, true);
        let before = fold_errors.iter().flat_map(|fold| fold.simple.clone()).collect::<Vec<_>>();
        let (rms, max) = cross_fit::figures(&choice.pieces);
        let (band, band_held) = cross_fit::prediction_interval(&runs, &choice.pieces, axis.coverage.velocity);
        let raw_rms = rms_max(&cross_fit::tracking_errors(&runs, &choice.pieces)).0;
        let worst_window = cross_fit::worst_window(&choice.pieces, manifest.period_s);
        axis.held_out = HeldOut { rms, max, raw_rms, band_held, folds: fold_errors.len(), worst_window, ..axis.held_out };
        let spread = cross_fit::spread(&runs, &choice.pieces, axis.coverage.velocity, rms, &choice.pieces);
        // A few seconds show the size of the errors and not their distribution.
        let known = || Some(axis.band.spread()?.scaled_to(rms));
        axis.band = band.with_spread(spread.or_else(known));
        let (before, taken) = (cross_fit::figures(&before).0, !choice.simple);
        axes.push(AdaptedAxis { name: axis.name.clone(), unit: ErrorUnit::from(&*axis), before, held_out: rms, taken });
        predictors.push(if taken { unadapted.adapted(&runs)? } else { predictor });
    }
    Ok(Adapted { bundle: Bundle::new(manifest, &predictors)?, axes })
}

/// Unadapted predictor of an axis: a grey-box cascade, with or without a network.
struct Unadapted {
    staged: StagedPredictor,
    stacked: Option<StackedPredictor>,
}

impl Unadapted {
    fn of(predictor: &dyn AxisPredictor, axis: &str) -> Result<Self> {
        let stacked =
            (predictor.kind() == models::stacked::KIND).then(|| StackedPredictor::from_saved(&predictor.save())).transpose()?;
        if predictor.kind() != models::staged::KIND && stacked.is_none() {
            return Err(Error::NotAdaptable { axis: axis.to_owned(), kind: predictor.kind().to_owned() });
        }
        let staged = match &stacked {
            Some(stacked) => stacked.base().clone(),
            None => StagedPredictor::from_saved(&predictor.save())?,
        };
        Ok(Self { staged, stacked })
    }

    /// Adapts the predictor to `runs`. The network is kept where it still lowers the error on them.
    fn adapted(&self, runs: &[AxisRun]) -> Result<Box<dyn AxisPredictor>> {
        let (adapted, _) = adapt_axis(&self.staged, runs, &StagedRecipe::default())?;
        let Some(stacked) = &self.stacked else { return Ok(Box::new(adapted)) };
        let with = stacked.clone().with_base(adapted.clone())?;
        let rms = |predictor: &dyn AxisPredictor| cross_fit::figures(&cross_fit::pieces(predictor, runs)).0;
        Ok(if rms(&with) < rms(&adapted) { Box::new(with) } else { Box::new(adapted) })
    }
}

fn runs_of(logs: &[Log], axis: &str) -> Result<Vec<AxisRun>> {
    logs.iter()
        .map(|log| {
            let (Some(reference), Some(actual)) = (log.reference.column(axis), log.actual.column(axis)) else {
                return Err(Error::LogLacksAxis { log: log.name.clone(), axis: axis.to_owned() });
            };
            Ok(AxisRun::new(reference.to_vec(), actual.to_vec(), log.period_s()))
        })
        .collect()
}
