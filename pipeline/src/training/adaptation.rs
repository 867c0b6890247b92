//! A model adapted to another machine, or to the same one later, with a few seconds of its log.

use datasets::{Fold, Log, Purpose, assess_runs};
use models::staged::StagedPredictor;
use models::{AxisPredictor, Bundle, HeldOut, Manifest, StackedPredictor};
use training::AxisRun;
use training::staged::{StagedRecipe, adapt as adapt_axis};

use super::cross_fit::{self, Judged, only, without};
use super::hash::data_hash;
use crate::error::{Error, Result};
use crate::statistics::rms_max;
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
}

/// Share of the new log that each fold holds out, and the folds: all of the log is judged.
const HELD_OUT: f64 = 0.25;
const FOLDS: usize = 4;

/// Adapts the staged predictors of `bundle` to `logs`. `seed` draws what is held out together.
///
/// # Errors
/// When the logs are not fit, lack an axis of the model, or are sampled at another rate; when an axis has another kind of predictor.
pub fn adapt(bundle: &Bundle, logs: &[Log], seed: u64) -> Result<Adapted> {
    let report = assess_runs(logs, Purpose::Training);
    if report.is_refused() {
        return Err(Error::unfit(&report));
    }
    let folds = datasets::folds(logs, HELD_OUT, FOLDS, seed)?;
    let mut predictors: Vec<Box<dyn AxisPredictor>> = Vec::new();
    let mut axes = Vec::new();
    let mut manifest = Manifest { data_sha256: data_hash(logs), ..bundle.manifest.clone() };
    for (predictor, axis) in bundle.predictors()?.into_iter().zip(&mut manifest.axes) {
        let old = Old::of(predictor.as_ref(), &axis.name)?;
        let runs = runs_of(logs, &axis.name)?;
        let judged = |fold: &Fold| -> Result<Judged> {
            let (training, held_out) = (without(&runs, fold), only(&runs, fold));
            let adapted = old.adapted(&training)?;
            Ok(Judged {
                rich: cross_fit::pieces(adapted.as_ref(), &held_out),
                simple: cross_fit::pieces(predictor.as_ref(), &held_out),
            })
        };
        let judged: Vec<Judged> = folds.iter().map(judged).collect::<Result<_>>()?;
        let choice = cross_fit::choose(&judged, true);
        let before = judged.iter().flat_map(|judged| judged.simple.clone()).collect::<Vec<_>>();
        let (rms, max) = cross_fit::figures(&choice.pieces);
        let (band, band_held) = cross_fit::bands(&runs, &choice.pieces, axis.coverage.velocity);
        let raw_rms = rms_max(&cross_fit::tracking_errors(&runs, &choice.pieces)).0;
        let worst_window = cross_fit::worst_window(&choice.pieces, manifest.period_s);
        axis.held_out = HeldOut { rms, max, raw_rms, band_held, folds: judged.len(), worst_window, ..axis.held_out };
        let spread = cross_fit::spread(&runs, &choice.pieces, axis.coverage.velocity, rms, &choice.pieces);
        axis.band = band.with_spread(spread);
        let (before, taken) = (cross_fit::figures(&before).0, !choice.simple);
        axes.push(AdaptedAxis { name: axis.name.clone(), unit: ErrorUnit::from(&*axis), before, held_out: rms, taken });
        predictors.push(if taken { old.adapted(&runs)? } else { predictor });
    }
    Ok(Adapted { bundle: Bundle::new(manifest, &predictors)?, axes })
}

/// The predictor of an axis as it was: staged, with or without a network.
struct Old {
    staged: StagedPredictor,
    stacked: Option<StackedPredictor>,
}

impl Old {
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

    /// Adapted to the rows of `runs`; with the network that it had where that still helps on them.
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
