//! Checks of a set of runs.

use super::assess;
use super::motion_checks::reversals;
use super::purpose::Purpose;
use super::signals::Signals;
use super::{lags, rests, trends};
use crate::{Check, Finding, Log, Report, Severity};

/// Minimum duration of motion in all runs together, s; less costs accuracy: 7.5 / 15 / 30 s gave
/// 0.43 / 0.33 / 0.26 µm.
const LITTLE_S: f64 = 15.0;

/// All checks of each run, with its name, and of the runs as a set: same axes and rate, every moving axis in both directions, enough data.
#[must_use]
pub fn assess_runs(logs: &[Log], purpose: Purpose) -> Report {
    let mut report = Report::default();
    for log in logs {
        let mut own = assess(log, purpose);
        for finding in &mut own.findings {
            finding.place.run = Some(log.name.clone());
        }
        report.extend(own);
    }
    let Some(first) = logs.first() else {
        report.push(Finding::new(Severity::Refuse, Check::Runs, "there is no run"));
        return report;
    };
    for log in &logs[1..] {
        let mut refuse = |message: String| {
            let mut finding = Finding::new(Severity::Refuse, Check::Runs, message);
            finding.place.run = Some(log.name.clone());
            report.push(finding);
        };
        if log.axes() != first.axes() {
            refuse(format!(
                "its axes are not those of `{}`; train each machine by itself. If a bad axis was left out of one of them, leave that run out",
                first.name
            ));
        }
        if (log.period_s() - first.period_s()).abs() > 1e-4 * first.period_s() {
            refuse(format!(
                "its period is {:.4} ms, that of `{}` {:.4} ms; log all runs at one rate",
                1e3 * log.period_s(),
                first.name,
                1e3 * first.period_s()
            ));
        }
    }
    if purpose == Purpose::Training {
        check_copies(logs, &mut report);
        check_directions(logs, first, &mut report);
        rests::check(logs, &mut report);
        lags::check(logs, &mut report);
        trends::check(logs, &mut report);
        let total_s: f64 = logs.iter().map(|log| log.reference.duration_s()).sum();
        if total_s < LITTLE_S {
            report.push(Finding::new(
                Severity::Warn,
                Check::Runs,
                format!("{total_s:.1} s of motion in all; accuracy grows up to about 60 s"),
            ));
        }
    }
    report
}

/// Refuses recordings that are given twice: what is held out would be trained on.
fn check_copies(logs: &[Log], report: &mut Report) {
    for (index, log) in logs.iter().enumerate() {
        let same = |other: &&Log| {
            other.len() == log.len()
                && other.reference.columns() == log.reference.columns()
                && other.actual.columns() == log.actual.columns()
        };
        if let Some(first) = logs[..index].iter().find(same) {
            let message = format!("it is the same recording as `{}`: give each recording once", first.name);
            let mut finding = Finding::new(Severity::Refuse, Check::Runs, message);
            finding.place.run = Some(log.name.clone());
            report.push(finding);
        }
    }
}

fn check_directions(logs: &[Log], first: &Log, report: &mut Report) {
    for (index, axis) in first.axes().iter().enumerate() {
        let (mut moves, mut forward, mut backward, mut turns) = (false, false, false, 0);
        for log in logs {
            if let Some(signals) = Signals::of(log).get(index)
                && signals.moves()
            {
                moves = true;
                turns += reversals(signals);
                let way = signals.reference.last().zip(signals.reference.first()).map_or(0.0, |(last, first)| last - first);
                forward |= way > 0.0;
                backward |= way < 0.0;
            }
        }
        if moves && turns == 0 {
            let (severity, message) = if forward && backward {
                (
                    Severity::Warn,
                    "no run holds a reversal of this axis: what it does where it turns back is a guess; record runs that go there and back",
                )
            } else {
                (
                    Severity::Refuse,
                    "the axis never reverses in any run: one direction cannot teach the other; record runs that go there and back",
                )
            };
            report.push(Finding::new(severity, Check::Motion, message).in_column(format!("{axis}_ref")));
        }
    }
}
