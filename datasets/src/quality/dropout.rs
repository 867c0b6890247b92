//! Rows without a measured actual position: zeros, or a repeated last value; and rows without the command.

use super::copied::segments;
use super::purpose::Purpose;
use super::signals::{Signals, largest, quantile, range};
use crate::{Check, Finding, Report};

/// Minimum number of rows with the same actual position, and longest command travel in them as a
/// multiple of the largest usual tracking error.
const FROZEN_ROWS: usize = 10;
const FROZEN_TRAVEL: f64 = 3.0;
/// Time in which an axis settles once its command stands, s, and travel after it that is none of an axis at rest, mm and rad. A position loop of 20 1/s at
/// 100 mm/s is 5 mm behind, and 12 µm after 0.3 s.
const SETTLES_S: f64 = 0.3;
const LEFT_ALONE: (f64, f64) = (0.1, 2e-3);

/// Reports zeros and frozen values, and returns the affected rows.
pub(super) fn check(axis: &Signals, purpose: Purpose, report: &mut Report) -> Vec<bool> {
    let zero = zeros(axis);
    let frozen = frozen(axis);
    for (rows, what) in [
        (&zero, "read exactly 0 amid the travel: the position was not transmitted there"),
        (
            &frozen,
            "repeat one value while the command moves on: the axis stands at a limit, or the log lost contact with the encoder",
        ),
    ] {
        let segments = segments(rows);
        if let Some((first, _)) = segments.first() {
            let total = rows.iter().filter(|lost| **lost).count();
            report.push(
                Finding::new(
                    purpose.grave(),
                    Check::Dropout,
                    format!("{total} rows in {} stretches {what}; cut them out, the rest as separate runs", segments.len()),
                )
                .in_column(axis.actual_name())
                .at_sample(*first, axis.period_s),
            );
        }
    }
    let abandoned = abandoned(axis);
    if let Some((first, travel)) = abandoned.first() {
        let times = if abandoned.len() == 1 { "once".to_owned() } else { format!("{} times", abandoned.len()) };
        let message = format!(
            "the command stands {times} while the axis goes on moving, by {travel:.3} {} the first time: the command was not logged there, or the axis \
             was moved by hand or by another program; cut these rows out, the rest as separate runs",
            axis.unit()
        );
        let finding = Finding::new(purpose.grave(), Check::Dropout, message);
        report.push(finding.in_column(axis.reference_name()).at_sample(*first, axis.period_s));
    }
    zero.iter().zip(&frozen).map(|(zero, frozen)| *zero || *frozen).collect()
}

/// Rests of the command in which the axis moves though it has settled: first row, and travel.
fn abandoned(axis: &Signals) -> Vec<(usize, f64)> {
    let settles = (SETTLES_S / axis.period_s).ceil() as usize;
    let still: Vec<bool> = axis.reference_steps.iter().map(|step| *step == 0.0).collect();
    let rests = segments(&still).into_iter().filter(|(start, end)| end - start > settles);
    let travels = rests.map(|(start, end)| (start, range(&axis.actual[start + settles..=end])));
    travels.filter(|(_, travel)| *travel > axis.of_kind(LEFT_ALONE.0, LEFT_ALONE.1)).collect()
}

/// Zeros that no motion explains: the command is further from 0 than it ever is from the actual
/// position elsewhere.
fn zeros(axis: &Signals) -> Vec<bool> {
    let elsewhere: Vec<f64> =
        axis.error.iter().zip(axis.actual).filter(|(_, actual)| **actual != 0.0).map(|(error, _)| *error).collect();
    let limit = 2.0 * largest(&elsewhere).min(10.0 * quantile(&elsewhere, 0.95)) + axis.of_kind(0.05, 5e-4);
    axis.actual.iter().zip(axis.reference).map(|(actual, reference)| *actual == 0.0 && reference.abs() > limit).collect()
}

/// Repeated values while the command moves, there and back too: at a limit it comes back. The usual error is that of the other rows, since
/// long stretches would make it their own.
fn frozen(axis: &Signals) -> Vec<bool> {
    let still: Vec<bool> = axis.actual_steps.iter().map(|step| *step == 0.0).collect();
    let stretches: Vec<_> = segments(&still).into_iter().filter(|(start, end)| end - start >= FROZEN_ROWS).collect();
    let mut rows = vec![false; axis.actual.len()];
    stretches.iter().for_each(|(start, end)| rows[*start..=*end].fill(true));
    let elsewhere: Vec<f64> = axis.error.iter().zip(&rows).filter(|(_, still)| !**still).map(|(error, _)| *error).collect();
    let limit = FROZEN_TRAVEL * quantile(&elsewhere, 0.95) + axis.of_kind(0.05, 5e-4);
    rows.fill(false);
    for (start, end) in stretches {
        if range(&axis.reference[start..=end]) > limit && axis.actual[start] != 0.0 {
            rows[start..=end].fill(true);
        }
    }
    rows
}
