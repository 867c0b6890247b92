//! Check whether a model still fits its machine.

use datasets::{Log, scored};
use models::{AxisSignal, Bundle};

use crate::error::{Error, Result};
use crate::statistics::rms_max;
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
    if (bundle.manifest.period_s / log.period_s() - 1.0).abs() > 1e-6 {
        return Err(Error::OtherRate { model_ms: bundle.manifest.period_s * 1e3, log_ms: log.period_s() * 1e3 });
    }
    let mut found = Vec::new();
    for (axis, predictor) in bundle.manifest.axes.iter().zip(bundle.predictors()?) {
        let (Some(reference), Some(actual)) = (log.reference.column(&axis.name), log.actual.column(&axis.name)) else { continue };
        let signal = AxisSignal::uncompensated(reference, log.period_s());
        let skip = scored(reference, log.period_s()).start;
        let errors: Vec<f64> =
            predictor.predict(&signal).iter().zip(reference.iter().zip(actual)).map(|(p, (r, x))| p - (r - x)).collect();
        let widths = axis.band.at(&AxisSignal::uncompensated(&reference[skip..], log.period_s()));
        let outside = axis.coverage.weights(reference, log.period_s(), false);
        let all: Vec<(f64, f64, bool)> =
            (skip..reference.len()).map(|k| (errors[k], widths[k - skip], outside[k].1.is_some())).collect();
        let inside: Vec<(f64, f64)> =
            all.iter().filter(|(.., outside)| !outside).map(|(error, width, _)| (*error, *width)).collect();
        let evaluated =
            if inside.is_empty() { all.iter().map(|(error, width, _)| (*error, *width)).collect() } else { inside.clone() };
        let rms = rms_max(&evaluated.iter().map(|(error, _)| *error).collect::<Vec<_>>()).0;
        let in_band =
            evaluated.iter().filter(|(error, width)| error.abs() <= *width).count() as f64 / evaluated.len().max(1) as f64;
        let uneven = axis.held_out.worst_window.max(1.0);
        found.push(Fit {
            axis: axis.name.clone(),
            unit: ErrorUnit::from(axis),
            rms,
            stale: !inside.is_empty() && (rms > STALE * uneven * axis.held_out.rms || in_band < LEAST_IN_BAND),
            expected: axis.held_out.rms,
            in_band,
            outside: 1.0 - inside.len() as f64 / all.len().max(1) as f64,
        });
    }
    if found.is_empty() {
        return Err(Error::NoCommonAxis);
    }
    Ok(found)
}
