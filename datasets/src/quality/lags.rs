//! An axis that lags by another time than the others of its machine.

use super::pairing::lag_sums;
use super::signals::{Signals, with_common_axes};
use crate::{Check, Finding, Log, Report, Severity};

/// Difference of an axis's lag from the nearest one of the others, over all runs, s, from which on it is suspect. Loops of one machine are tuned
/// alike, since a difference of lags bends circles: on `random:2` to `random:60` lags of up to 38 ms differ by at most 1.5 ms.
const ALONE_S: f64 = 2e-3;
/// Lag that no axis has, s.
const LONGEST_S: f64 = 0.2;

/// Warns of such axes.
pub(super) fn check(logs: &[Log], report: &mut Report) {
    let Some(first) = with_common_axes(logs) else { return };
    let mut sums = vec![(0.0, 0.0); first.axes().len()];
    for log in logs {
        for (sum, axis) in sums.iter_mut().zip(Signals::of(log)).filter(|(_, axis)| axis.moves()) {
            let (ev, vv) = lag_sums(&axis);
            (sum.0, sum.1) = (sum.0 + ev, sum.1 + vv);
        }
    }
    let lags_s: Vec<(usize, f64)> =
        sums.iter().enumerate().filter(|(_, (_, vv))| *vv > 0.0).map(|(index, (ev, vv))| (index, ev / vv)).collect();
    // A column that does not belong to its command has no lag.
    let lags_s: Vec<(usize, f64)> = lags_s.into_iter().filter(|(_, lag_s)| lag_s.abs() < LONGEST_S).collect();
    for (index, own_s) in &lags_s {
        let others = lags_s.iter().filter(|(other, _)| other != index).map(|(_, lag_s)| *lag_s);
        let Some(nearest_s) = others.min_by(|a, b| (a - own_s).abs().total_cmp(&(b - own_s).abs())) else { continue };
        // Of two axes the one that lags more is named.
        if (own_s - nearest_s).abs() > ALONE_S && (lags_s.len() > 2 || *own_s > nearest_s) {
            let message = format!(
                "the axis lags its command by {:.1} ms, the nearest of the other axes by {:.1}: where its columns have another clock or filter, a model \
                 corrects a lag that the machine does not have; log all columns at the same instants, without filters",
                1e3 * own_s,
                1e3 * nearest_s
            );
            let column = format!("{}_act", first.axes()[*index]);
            report.push(Finding::new(Severity::Warn, Check::Pairing, message).in_column(column));
        }
    }
}
