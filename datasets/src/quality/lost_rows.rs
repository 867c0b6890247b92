//! Rows that are lost without a trace in the time stamps: every axis goes further at once.

use super::signals::{Signals, largest};
use crate::{Check, Finding, Report, Severity};

/// Step of an axis over such a row, as a multiple of the larger one beside it, and largest ratio of these multiples among columns. Good logs of
/// `random:2` to `random:60` have no such row.
const FURTHER: f64 = 1.6;
const ALIKE: f64 = 1.25;
/// Steps, as a share of an axis's largest, from which on it tells.
const FAST: f64 = 0.1;

/// Reports rows over which command and actual position of every fast axis step further than beside them, all by one factor.
pub(super) fn check(moving: &[&Signals], report: &mut Report) {
    let largest: Vec<f64> = moving.iter().map(|axis| largest(&axis.reference_steps)).collect();
    let rows = moving.iter().map(|axis| axis.reference_steps.len()).min().unwrap_or(0);
    let lost: Vec<usize> = (1..rows.saturating_sub(1)).filter(|k| is_lost(moving, &largest, *k)).collect();
    let (Some(first), Some(axis)) = (lost.first(), moving.first()) else { return };
    let rows = if lost.len() == 1 { "over one row".to_owned() } else { format!("over {} rows", lost.len()) };
    let message = format!(
        "{rows} every axis moves further than before and after, command and actual position by the same factor: rows are missing there, \
         which looks like a jerk of the machine; log without loss, or cut the file at these rows"
    );
    report.push(Finding::new(Severity::Warn, Check::Timing, message).at_sample(first + 1, axis.period_s));
}

fn is_lost(moving: &[&Signals], largest: &[f64], k: usize) -> bool {
    let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
    for (axis, largest) in moving.iter().zip(largest) {
        let beside = |steps: &[f64]| steps[k - 1].abs().max(steps[k + 1].abs());
        if beside(&axis.reference_steps).min(axis.reference_steps[k].abs()) < FAST * largest {
            continue;
        }
        for steps in [&axis.reference_steps, &axis.actual_steps] {
            let ratio = steps[k].abs() / beside(steps).max(f64::MIN_POSITIVE);
            (least, most) = (least.min(ratio), most.max(ratio));
        }
    }
    least.is_finite() && least >= FURTHER && most <= ALIKE * least
}
