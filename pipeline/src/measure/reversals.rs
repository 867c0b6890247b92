//! Glitches of the contour error at axis reversals.

use datasets::Log;
use motion::Axis;
use motion::contour::ContourError;

use crate::pieces::Heading;

/// Time after a reversal in which its glitch is searched for, s.
const WINDOW_S: f64 = 0.06;

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

/// Component of the tip that an axis moves; `None` for axes other than x, y and z.
pub(super) fn tip_component(axis: &Axis) -> Option<usize> {
    ["x", "y", "z"].iter().position(|name| *name == axis.name)
}

/// Samples from a reversal of the command to that of the axis, and the length of the glitch.
pub(super) fn glitch_samples(lag_s: Option<f64>, period_s: f64) -> (usize, usize) {
    ((lag_s.unwrap_or(0.0).max(0.0) / period_s).round() as usize, (WINDOW_S / period_s).round() as usize)
}

/// Reversals of the axes x, y and z, in order of time. `errors` are the contour errors of the log's samples, `lags_s`
/// the lags of its axes.
#[must_use]
pub fn reversals(log: &Log, errors: &[ContourError], lags_s: &[Option<f64>]) -> Vec<Reversal> {
    let period = log.period_s();
    let mut found = Vec::new();
    for (index, axis) in log.axes().iter().enumerate() {
        let Some(component) = tip_component(axis) else { continue };
        let (late, window) = glitch_samples(lags_s.get(index).copied().flatten(), period);
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
    let mut heading = Heading::default();
    let turn = |(k, position): (usize, &f64)| Some((k, heading.turns(*position, period_s)?));
    positions.iter().enumerate().filter_map(turn).collect()
}
