//! The glitch that an axis leaves at each reversal.

use datasets::Log;
use motion::contour::ContourError;

/// Time after a reversal in which its glitch is looked for, s.
const WINDOW_S: f64 = 0.06;
/// Slower is standing still, mm/s or rad/s.
const STILL: f64 = 0.05;

/// A reversal of one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Reversal {
    /// Name of the axis.
    pub axis: String,
    /// When its command turned back, s.
    pub time_s: f64,
    /// Its position there, mm.
    pub at: f64,
    /// Whether it moved towards positive positions before.
    pub from_positive: bool,
    /// Size of the glitch, mm: how far the contour error along the axis swings within 60 ms of the actual reversal.
    pub glitch_mm: f64,
}

/// The reversals of the axes x, y and z, in order of time. `errors` are the contour errors of the log's samples.
#[must_use]
pub fn reversals(log: &Log, errors: &[ContourError], lags_s: &[Option<f64>]) -> Vec<Reversal> {
    let period = log.period_s();
    let window = (WINDOW_S / period).round() as usize;
    let mut found = Vec::new();
    for (index, axis) in log.axes().iter().enumerate() {
        let Some(component) = ["x", "y", "z"].iter().position(|name| *name == axis.name) else { continue };
        let late = (lags_s.get(index).copied().flatten().unwrap_or(0.0).max(0.0) / period).round() as usize;
        let column = &log.reference.columns()[index];
        let mut heading = 0.0;
        for k in 1..column.len() {
            let speed = (column[k] - column[k - 1]) / period;
            if speed.abs() < STILL {
                continue;
            }
            if heading * speed < 0.0 {
                let from = (k + late).min(errors.len());
                let swing = errors[from..(from + window).min(errors.len())].iter().map(|error| error.vector[component]);
                let (low, high) = swing.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), e| (low.min(e), high.max(e)));
                found.push(Reversal {
                    axis: axis.name.clone(),
                    time_s: k as f64 * period,
                    at: column[k],
                    from_positive: heading > 0.0,
                    glitch_mm: (high - low).max(0.0),
                });
            }
            heading = speed.signum();
        }
    }
    found.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    found
}
