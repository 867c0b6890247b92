//! Lag of the axes behind their commands.

use datasets::Log;
use motion::lag_s;

/// Common delay of the moving axes, s: the mean of their lags. It has little effect on the contour, unlike lag
/// differences between axes.
pub(super) fn common_delay_s(logs: &[Log], moving: &[usize]) -> f64 {
    let lags: Vec<f64> = moving.iter().filter_map(|&axis| axis_lag_s(logs, axis)).collect();
    lags.iter().sum::<f64>() / lags.len().max(1) as f64
}

/// Mean lag of one axis over the runs, weighted by their length, s.
pub(super) fn axis_lag_s(logs: &[Log], axis: usize) -> Option<f64> {
    let lags: Vec<(f64, f64)> = logs
        .iter()
        .filter_map(|log| {
            let lag = lag_s(&log.reference.columns()[axis], &log.actual.columns()[axis], log.period_s())?;
            Some((lag, log.len() as f64))
        })
        .collect();
    let samples: f64 = lags.iter().map(|(_, samples)| samples).sum();
    (samples > 0.0).then(|| lags.iter().map(|(lag, samples)| lag * samples).sum::<f64>() / samples)
}
