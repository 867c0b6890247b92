//! Whether each actual position belongs to its command: swapped columns or axes, wrong sign, actual ahead of the command.

use super::signals::{Signals, correlation, rms, steps};
use crate::{Check, Finding, Report, Severity};

/// Speeds are compared over this time, s, which averages encoder noise away.
const STRIDE_S: f64 = 0.02;
/// Correlation of speeds above which a pair belongs together, and below which it does not.
const BELONGS: f64 = 0.9;
const STRANGE: f64 = 0.5;
/// An actual position that leads by more than this share of a period is suspect.
const LEAD_PERIODS: f64 = 0.5;
/// A column is the rougher one when its third differences are larger by this factor.
const ROUGHER: f64 = 1.05;

pub(super) fn check(moving: &[&Signals], report: &mut Report) {
    for (index, axis) in moving.iter().enumerate() {
        let own = correlation(&speeds(axis, axis.reference), &speeds(axis, axis.actual)).0;
        if own >= STRANGE {
            check_lead(axis, report);
            continue;
        }
        let other = moving.iter().enumerate().find(|(other, candidate)| {
            *other != index && correlation(&speeds(axis, axis.reference), &speeds(candidate, candidate.actual)).0 > BELONGS
        });
        let message = match other {
            Some((_, other)) => format!(
                "the command of `{}` is followed by the actual position of `{}`: the axes' columns are swapped",
                axis.axis, other.axis
            ),
            None if own < -STRANGE => format!(
                "the actual position moves against the command (correlation of speeds {own:.2}): wrong sign; give a negative factor in the \
                 column mapping"
            ),
            None => format!(
                "the actual position does not follow the command (correlation of speeds {own:.2}): wrong column, or shifted in time"
            ),
        };
        report.push(Finding::new(Severity::Refuse, Check::Pairing, message).in_column(axis.actual_name()));
    }
}

fn speeds(axis: &Signals, positions: &[f64]) -> Vec<f64> {
    let stride = (STRIDE_S / axis.period_s).round().max(1.0) as usize;
    positions.iter().zip(positions.iter().skip(stride)).map(|(before, after)| after - before).collect()
}

fn check_lead(axis: &Signals, report: &mut Report) {
    let lag_s = lag_s(axis);
    if lag_s >= -LEAD_PERIODS * axis.period_s {
        return;
    }
    // A measured position is rougher than a planned one.
    let roughness = |of: &[f64]| rms(&steps(&steps(of)));
    let rougher = roughness(&axis.reference_steps) > ROUGHER * roughness(&axis.actual_steps);
    let (severity, remedy) = if rougher {
        (Severity::Refuse, "and the command is rougher than the actual position: the two columns are swapped")
    } else {
        (Severity::Warn, "columns swapped, or stamped at different instants, or too much feed-forward")
    };
    report.push(
        Finding::new(
            severity,
            Check::Pairing,
            format!("the actual position is ahead of the command by {:.2} ms; {remedy}", -1e3 * lag_s),
        )
        .in_column(axis.actual_name()),
    );
}

/// Delay of the actual position, s, as the regression of the tracking error on the speed.
fn lag_s(axis: &Signals) -> f64 {
    let mean = axis.error.iter().sum::<f64>() / axis.error.len().max(1) as f64;
    let (mut ev, mut vv) = (0.0, 0.0);
    for (k, error) in axis.error.iter().enumerate().take(axis.error.len() - 1).skip(1) {
        let speed = (axis.reference[k + 1] - axis.reference[k - 1]) / (2.0 * axis.period_s);
        ev += (error - mean) * speed;
        vv += speed * speed;
    }
    if vv > 0.0 { ev / vv } else { 0.0 }
}
