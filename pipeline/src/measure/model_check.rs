//! Whether a model still fits the machine.

use datasets::{Log, scored};
use models::{AxisSignal, Bundle};

use crate::error::{Error, Result};
use crate::statistics::rms_max;
use crate::units::ErrorUnit;

/// Error over that of the worst two seconds of held-out runs above which a model is stale, whatever its band says.
const STALE: f64 = 2.0;
/// Share of errors within the 95 % band below which it is: chance exceeds the band in a twentieth, never in a quarter.
const LEAST_IN_BAND: f64 = 0.75;

/// How one axis of a model does on a new log.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// Name of the axis.
    pub axis: String,
    /// Unit in which its errors are shown.
    pub unit: ErrorUnit,
    /// Root mean square of prediction minus measurement, mm or rad.
    pub rms: f64,
    /// What it was on held-out runs of the training, mm or rad.
    pub expected: f64,
    /// Share of the samples within the model's 95 % band.
    pub in_band: f64,
    /// Share of the samples beyond the positions, speeds and accelerations of the training. They say nothing of the machine and are left
    /// out of the other figures, unless there are no others.
    pub outside: f64,
    /// Whether the model no longer fits.
    pub stale: bool,
}

/// The axes of the model that the log has as well.
///
/// # Errors
/// When the rates differ, or the log has none of the axes.
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
        let judged =
            if inside.is_empty() { all.iter().map(|(error, width, _)| (*error, *width)).collect() } else { inside.clone() };
        let rms = rms_max(&judged.iter().map(|(error, _)| *error).collect::<Vec<_>>()).0;
        let in_band = judged.iter().filter(|(error, width)| error.abs() <= *width).count() as f64 / judged.len().max(1) as f64;
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
