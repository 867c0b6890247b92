//! Check whether a model still fits its machine.

use std::ops::Range;

use datasets::{Log, Piece, scored};
use models::{AxisManifest, AxisPredictor, AxisSignal, Bundle};
use motion::{Axis, Trajectory};
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::pieces::{Approach, RmsMax};
use crate::units::ErrorUnit;

/// Ratio of the RMS error to that of the worst two seconds of held-out runs above which a model is stale, independent of
/// its prediction interval.
const STALE: f64 = 2.0;
/// Share of errors within the 95 % prediction interval below which a model is stale: chance leaves a twentieth outside,
/// never a quarter.
const LEAST_IN_BAND: f64 = 0.75;

/// Fit of one axis of a model to a new log.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// Name of the axis.
    pub axis: String,
    /// Unit of its errors in reports.
    pub unit: ErrorUnit,
    /// Root mean square of prediction minus measurement, mm or rad.
    pub rms: f64,
    /// RMS of prediction minus measurement on held-out runs of the training, mm or rad.
    pub expected: f64,
    /// Share of the samples within the model's 95 % prediction interval.
    pub in_band: f64,
    /// Share of the samples outside the operating range: positions, speeds and accelerations beyond the training. They
    /// show nothing about the machine and do not count in the other figures, unless there are no others.
    pub outside: f64,
    /// Whether the model no longer fits the machine.
    pub stale: bool,
}

/// Fit of every axis that model and log share.
///
/// # Errors
/// When the sampling periods differ, or the log has no axis of the model.
pub fn fits(bundle: &Bundle, log: &Log) -> Result<Vec<Fit>> {
    let mut sums = FitSum::new(bundle, log.axes(), log.period_s(), 0)?;
    sums.add_samples(&log.reference, &log.actual, 0, 0..log.len());
    Ok(sums.finish())
}

/// Fits of the axes, as the samples of a log come.
pub(crate) struct FitSum<'a> {
    period_s: f64,
    axes: Vec<AxisSum<'a>>,
}

/// Errors of one axis.
struct AxisSum<'a> {
    manifest: &'a AxisManifest,
    predictor: Box<dyn AxisPredictor>,
    /// Index of the axis in the log.
    index: usize,
    /// First sample that counts.
    skip: usize,
    approach: Approach,
    /// Over the samples within the operating range, and over all.
    inside: WithinBand,
    all: WithinBand,
}

#[derive(Default)]
struct WithinBand {
    errors: RmsMax,
    within: usize,
    count: usize,
}

impl WithinBand {
    fn note(&mut self, error: f64, width: f64) {
        self.errors.note(error);
        self.within += usize::from(error.abs() <= width);
        self.count += 1;
    }
}

impl<'a> FitSum<'a> {
    /// No samples yet of a log that is read in pieces with `before` samples before them.
    pub(super) fn new(bundle: &'a Bundle, of_log: &[Axis], period_s: f64, before: usize) -> Result<Self> {
        if (bundle.manifest.period_s / period_s - 1.0).abs() > 1e-6 {
            return Err(Error::OtherRate { model_ms: bundle.manifest.period_s * 1e3, log_ms: period_s * 1e3 });
        }
        let mut axes = Vec::new();
        for (manifest, predictor) in bundle.manifest.axes.iter().zip(bundle.predictors()?) {
            let Some(index) = of_log.iter().position(|axis| axis.name == manifest.name) else { continue };
            let (inside, all) = Default::default();
            axes.push(AxisSum { manifest, predictor, index, skip: 0, approach: Approach::new(before), inside, all });
        }
        if axes.is_empty() {
            return Err(Error::NoCommonAxis);
        }
        Ok(Self { period_s, axes })
    }

    /// Adds a piece of a log, in the order of the log.
    pub(super) fn add(&mut self, piece: &Piece) {
        if let Some(actual) = &piece.actual {
            self.add_samples(&piece.reference, actual, piece.first, piece.own.clone());
        }
    }

    /// Adds the samples `own` of trajectories that begin with sample `first` of the log.
    fn add_samples(&mut self, reference: &Trajectory, actual: &Trajectory, first: usize, own: Range<usize>) {
        let period_s = self.period_s;
        self.axes.par_iter_mut().for_each(|axis| {
            let (reference, actual) = (&reference.columns()[axis.index], &actual.columns()[axis.index]);
            if first + own.start == 0 {
                axis.skip = scored(reference, period_s).start;
            }
            axis.add(reference, actual, first, own.clone(), period_s);
        });
    }

    pub(super) fn finish(self) -> Vec<Fit> {
        self.axes.into_iter().map(AxisSum::fit).collect()
    }
}

impl AxisSum<'_> {
    fn add(&mut self, reference: &[f64], actual: &[f64], first: usize, own: Range<usize>, period_s: f64) {
        let approached = self.approach.to(reference, first, own.clone(), period_s);
        let before = approached.len() - reference.len();
        let predicted = self.predictor.predict(&AxisSignal::uncompensated(&approached, period_s));
        // The widths at the start of a log are those of a path that begins with the samples that count.
        let counted = self.skip.saturating_sub(first).clamp(own.start, own.end)..own.end;
        let from = if first == 0 { counted.start } else { 0 };
        let widths = self.manifest.band.at(&AxisSignal::uncompensated(&reference[from..], period_s));
        let outside = self.manifest.coverage.weights(reference, period_s, false, false);
        for k in counted {
            let error = predicted[before + k] - (reference[k] - actual[k]);
            self.all.note(error, widths[k - from]);
            if outside[k].1.is_none() {
                self.inside.note(error, widths[k - from]);
            }
        }
    }

    fn fit(self) -> Fit {
        let Self { manifest, inside, all, .. } = self;
        let evaluated = if inside.count == 0 { &all } else { &inside };
        let rms = evaluated.errors.figures().0;
        let in_band = evaluated.within as f64 / evaluated.count.max(1) as f64;
        let uneven = manifest.held_out.worst_window.max(1.0);
        Fit {
            axis: manifest.name.clone(),
            unit: ErrorUnit::from(manifest),
            rms,
            stale: inside.count > 0 && (rms > STALE * uneven * manifest.held_out.rms || in_band < LEAST_IN_BAND),
            expected: manifest.held_out.rms,
            in_band,
            outside: 1.0 - inside.count as f64 / all.count.max(1) as f64,
        }
    }
}
