//! What the runs show in motion, over all of them: errors that grow with place or time, and runs whose columns are shifted in time.
//!
//! On `random:220` to `random:249`, `random:301` to `random:312` and the built-in machines the error grows by at most 0.18 % of the position (4.4
//! times what is left) and by 14 µm in ten seconds, and the lag of a run differs from that of the others by at most 0.7 ms, that of a control test
//! by up to 8 % (1.7 ms on `random:237`, whose position loops have integrators). Of 486 sets of three to five runs of these machines none has a finding;
//! a single run of 6 s (`random:777`) showed a drift of 32 µm that it did not have.

use motion::AxisKind;
use nalgebra::SVector;

use super::regression::{Motion, motions, slopes};
use super::signals::{Signals, with_common_axes};
use crate::{Check, Finding, Log, Report, Severity};

/// Terms of the error: speed, acceleration, direction, position, time.
const TERMS: usize = 5;
const PLACE: usize = 3;
const TIME: usize = 4;
/// Runs from which on place and time are distinguished from the other terms, and motion from which on a place that grows as no machine's does is in fewer, s.
const FEWEST_RUNS: f64 = 3.0;
const FEW_RUNS_S: f64 = 8.0;
/// Growth of the error with the position from which on the scales differ, as a share and as a multiple of what is left of the error; and the share
/// from which on no machine has it.
const SLOPE: f64 = 5e-3;
const OF_REST: f64 = 8.0;
const NO_MACHINE: f64 = 1e-2;
/// Growth of the error over a run of mean length from which on an axis drifts, mm, and as a multiple of what is left.
const DRIFT_MM: f64 = 0.03;
const DRIFT_OF_REST: f64 = 3.0;
/// Difference of the lags of a run on all axes from those of the others from which on it is suspect, and from which on it is refused: s, and as a
/// share of these lags; and the largest share by which the axes may differ in it.
const SHIFT: (f64, f64) = (0.8e-3, 0.1);
const SURE_SHIFT: (f64, f64) = (2e-3, 0.2);
const ALIKE: f64 = 0.5;

/// Reports axes whose error grows, and runs that are shifted.
pub(super) fn check(logs: &[Log], report: &mut Report) {
    let Some(first) = with_common_axes(logs) else { return };
    for index in 0..first.axes().len() {
        let is_told = report.findings.iter().any(|finding| {
            finding.check == Check::Units && finding.place.column.as_deref() == Some(&format!("{}_act", first.axes()[index]))
        });
        if first.axes()[index].kind == AxisKind::Linear && !is_told {
            report.findings.extend(growth(logs, index));
        }
    }
    shifts(logs, report);
}

/// Terms and error of the counted rows of a run, less their means.
fn rows(axis: &Signals) -> Vec<(SVector<f64, TERMS>, f64)> {
    let of = |at: Motion| (SVector::from([at.speed, at.acceleration, at.direction, at.position, at.time_s]), at.error);
    let mut rows: Vec<_> = motions(axis).into_iter().map(of).collect();
    let count = rows.len().max(1) as f64;
    let (terms, error) = rows.iter().fold((SVector::zeros(), 0.0), |(terms, error), row| (terms + row.0, error + row.1));
    rows.iter_mut().for_each(|row| *row = (row.0 - terms / count, row.1 - error / count));
    rows
}

/// An error of one axis that grows with the position, or with time.
fn growth(logs: &[Log], index: usize) -> Option<Finding> {
    let mut all = Vec::new();
    let (mut low, mut high, mut moving_s, mut runs) = (f64::INFINITY, f64::NEG_INFINITY, 0.0, 0.0_f64);
    for log in logs {
        let signals = Signals::of(log);
        let Some(axis) = signals.get(index).filter(|axis| axis.moves()) else { continue };
        (low, high) = axis.reference.iter().fold((low, high), |(low, high), at| (low.min(*at), high.max(*at)));
        (moving_s, runs) = (moving_s + log.reference.duration_s(), runs + 1.0);
        all.extend(rows(axis));
    }
    let few = runs < FEWEST_RUNS;
    if few && moving_s < FEW_RUNS_S {
        return None;
    }
    let (slopes, rest) = slopes(&all)?;
    let axis = &logs[0].axes()[index];
    let column = format!("{axis}_act");
    // The error is command minus actual position.
    let (slope, span) = (-slopes[PLACE], high - low);
    if slope.abs() > if few { NO_MACHINE } else { SLOPE } && slope.abs() * span > OF_REST * rest {
        let severity = if slope.abs() > NO_MACHINE { Severity::Refuse } else { Severity::Warn };
        let message = format!(
            "in motion the actual position grows by {:.2} % more than its command, by {:.4} mm over {span:.1} mm: the scale of the encoder or of the \
             column is off; where it is the column, map it with a factor, as in `{column}={column}*{:.6}`",
            100.0 * slope,
            slope * span,
            1.0 / (1.0 + slope)
        );
        return Some(Finding::new(severity, Check::Units, message).in_column(column));
    }
    if few {
        return None;
    }
    let drift = -slopes[TIME] * moving_s / runs.max(1.0);
    if drift.abs() > DRIFT_MM.max(DRIFT_OF_REST * rest) {
        let message = format!(
            "in motion the actual position drifts against its command, by {drift:.4} mm in a run of mean length: counts are lost, or a scale warms \
             up; mend the encoder, or log a warm machine"
        );
        return Some(Finding::new(Severity::Refuse, Check::Units, message).in_column(column));
    }
    None
}

/// Runs in which all axes lag by the same time more or less than in the others.
fn shifts(logs: &[Log], report: &mut Report) {
    if logs.len() < 2 {
        return;
    }
    let lags: Vec<Vec<Option<f64>>> = logs.iter().map(|log| Signals::of(log).iter().map(lag_s).collect()).collect();
    if let ([_, second], [a, b]) = (logs, lags.as_slice()) {
        let apart: Vec<(f64, f64)> =
            a.iter().zip(b).filter_map(|(a, b)| Some(((*b)? - (*a)?, 0.5 * ((*a)? + (*b)?).abs()))).collect();
        let differs = |sign: f64| apart.iter().all(|(by, lag_s)| sign * by > SURE_SHIFT.0.max(SURE_SHIFT.1 * lag_s));
        if apart.len() >= 2 && (differs(1.0) || differs(-1.0)) {
            let by_ms = apart.iter().map(|(by, _)| 1e3 * by.abs()).fold(f64::INFINITY, f64::min);
            let message = format!(
                "all axes lag their commands by {by_ms:.1} ms {} than in `{}`: the runs are of two machines, the columns of one are shifted \
                 against each other, or the control was set otherwise; train on the runs of one machine in one state",
                if differs(1.0) { "more" } else { "less" },
                logs[0].name
            );
            let mut finding = Finding::new(Severity::Refuse, Check::Pairing, message);
            finding.place.run = Some(second.name.clone());
            report.push(finding);
        }
        return;
    }
    let axes = lags.first().map_or(0, Vec::len);
    let usual: Vec<Option<f64>> =
        (0..axes).map(|axis| motion::quantile(&mut lags.iter().filter_map(|run| run[axis]).collect::<Vec<_>>(), 0.5)).collect();
    let known: Vec<f64> = usual.iter().flatten().map(|lag_s| lag_s.abs()).collect();
    let lag_s = known.iter().sum::<f64>() / known.len().max(1) as f64;
    let bound = |(least_s, share): (f64, f64)| least_s.max(share * lag_s);
    for (log, run) in logs.iter().zip(&lags) {
        let apart: Vec<f64> = run.iter().zip(&usual).filter_map(|(own, usual)| Some((*own)? - (*usual)?)).collect();
        let (low, high) = apart.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), by| (low.min(*by), high.max(*by)));
        let least = if low > 0.0 { low } else { -high };
        if apart.len() < 2 || least < bound(SHIFT) || high - low > ALIKE * least {
            continue;
        }
        let severity = if least > bound(SURE_SHIFT) { Severity::Refuse } else { Severity::Warn };
        let message = format!(
            "all axes lag their commands by {:.1} ms {} than in the other runs: the columns are shifted against each other, or the control was set \
             otherwise; leave this run out, or record it again",
            1e3 * least,
            if low > 0.0 { "more" } else { "less" }
        );
        let mut finding = Finding::new(severity, Check::Pairing, message);
        finding.place.run = Some(log.name.clone());
        report.push(finding);
    }
}

/// Lag of an axis in one run, s, where it moves enough to tell.
fn lag_s(axis: &Signals) -> Option<f64> {
    let (ev, vv) = super::pairing::lag_sums(axis);
    (axis.moves() && vv > 0.0).then(|| ev / vv)
}
