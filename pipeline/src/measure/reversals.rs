//! Glitches of the contour error at axis reversals.

use datasets::Log;
use motion::contour::ContourError;

/// Time after a reversal in which its glitch is searched for, s.
const WINDOW_S: f64 = 0.06;
/// Speed below which an axis counts as at standstill, mm/s or rad/s.
const STILL: f64 = 0.05;

/// A reversal of one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Reversal {
    /// Name of the axis.
    pub axis: String,
    /// Time at which its command reverses, s.
    pub time_s: f64,
    /// Commanded position of the reversal, mm.
    pub at: f64,
    /// Whether the axis moved in positive direction before the reversal.
    pub from_positive: bool,
    /// Size of the glitch, mm: range of the contour error along the axis within 60 ms after the actual reversal.
    pub glitch_mm: f64,
}

/// Reversals of the axes x, y and z, in order of time. `errors` are the contour errors of the log's samples, `lags_s`
/// the lags of its axes.
#[must_use]
pub fn reversals(log: &Log, errors: &[ContourError], lags_s: &[Option<f64>]) -> Vec<Reversal> {
    let period = log.period_s();
    let window = (WINDOW_S / period).round() as usize;
    let mut found = Vec::new();
    for (index, axis) in log.axes().iter().enumerate() {
        let Some(component) = ["x", "y", "z"].iter().position(|name| *name == axis.name) else { continue };
        let late = (lags_s.get(index).copied().flatten().unwrap_or(0.0).max(0.0) / period).round() as usize;
        let column = &log.reference.columns()[index];
        for (k, from_positive) in reversal_samples(column, period) {
            let from = (k + late).min(errors.len());
            let swing = errors[from..(from + window).min(errors.len())].iter().map(|error| error.vector[component]);
            let (low, high) = swing.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), e| (low.min(e), high.max(e)));
            let (time_s, at, glitch_mm) = (k as f64 * period, column[k], (high - low).max(0.0));
            found.push(Reversal { axis: axis.name.clone(), time_s, at, from_positive, glitch_mm });
        }
    }
    found.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    found
}

/// Samples at which a commanded position (mm or rad) reverses, each with whether it rose before. Standstills in between do not matter.
#[must_use]
pub fn reversal_samples(positions: &[f64], period_s: f64) -> Vec<(usize, bool)> {
    let mut found = Vec::new();
    let mut heading = 0.0;
    for k in 1..positions.len() {
        let speed = (positions[k] - positions[k - 1]) / period_s;
        if speed.abs() < STILL {
            continue;
        }
        if heading * speed < 0.0 {
            found.push((k, heading > 0.0));
        }
        heading = speed.signum();
    }
    found
}
