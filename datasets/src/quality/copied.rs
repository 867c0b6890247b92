//! Command recorded in place of the actual position, in the same row or some rows later.

use super::digits::step_of;
use super::signals::Signals;
use crate::{Check, Finding, Report, Severity};

/// Minimum total, in rows, and share of the log, for equal rows to be reported.
const FEWEST_ROWS: usize = 20;
const FEWEST_SHARE: f64 = 0.01;
/// Most rows by which a copy is late, and share of its rows that equal the command's.
const LATEST: usize = 20;
const EQUAL: f64 = 0.995;
/// Steps of rounding by which rounded positions differ.
const ROUNDED: f64 = 1.01;
/// Number of segments named in the message.
const LISTED: usize = 3;

pub(super) fn check(signals: &[Signals], report: &mut Report) {
    let moving: Vec<&Signals> = signals.iter().filter(|axis| axis.moves()).collect();
    let Some(first) = moving.first() else {
        return;
    };
    let mut all_copied = false;
    for axis in &moving {
        if axis.error.iter().all(|error| *error == 0.0) {
            all_copied = true;
            report.push(
                Finding::new(
                    Severity::Refuse,
                    Check::Copied,
                    "the actual position equals the command in every row: it is a copy of it; log the encoder's position",
                )
                .in_column(axis.actual_name()),
            );
        } else if let Some(rows) = (1..=LATEST).find(|rows| is_copied(axis, *rows)) {
            all_copied = true;
            report.push(
                Finding::new(
                    Severity::Refuse,
                    Check::Copied,
                    format!("the actual position equals the command {rows} row(s) before: it is a copy of it; log the encoder's position"),
                )
                .in_column(axis.actual_name()),
            );
        }
    }
    if all_copied {
        return;
    }
    let rows = first.error.len();
    let equal: Vec<bool> = (0..rows).map(|k| moving.iter().all(|axis| axis.error[k] == 0.0)).collect();
    let total = equal.iter().filter(|equal| **equal).count();
    let moves = |k: usize| k > 0 && moving.iter().any(|axis| axis.reference_steps[k - 1] != 0.0);
    let in_motion = (0..rows).filter(|&k| equal[k] && moves(k)).count();
    // Rounded positions equal each other now and then, and are one step apart more often.
    let rounded: Vec<f64> = moving.iter().map(|axis| ROUNDED * step_of(&axis.error).unwrap_or(0.0)).collect();
    let is_near =
        |k: &usize| !equal[*k] && moves(*k) && moving.iter().zip(&rounded).all(|(axis, step)| axis.error[*k].abs() <= *step);
    if in_motion < (0..rows).filter(is_near).count() {
        return;
    }
    // An axis that stands reads its command exactly.
    if in_motion < FEWEST_ROWS || (total as f64) < FEWEST_SHARE * rows as f64 {
        return;
    }
    let mut segments = segments(&equal);
    segments.sort_by_key(|(start, end)| std::cmp::Reverse(end - start));
    let listed: Vec<String> = segments.iter().take(LISTED).map(|(start, end)| format!("{}-{}", start + 1, end)).collect();
    let start = segments.iter().map(|(start, _)| *start).min().unwrap_or(0);
    report.push(
        Finding::new(
            Severity::Warn,
            Check::Copied,
            format!(
                "{total} of {rows} rows have command = actual on all moving axes, {in_motion} of them while the command moves \
                 ({} stretches, longest: rows {}): the logger fills in one for the other there; leave these rows out or fix the logger",
                segments.len(),
                listed.join(", ")
            ),
        )
        .at_sample(start, first.period_s),
    );
}

/// Whether the actual position is the command of so many rows before, while that moves.
fn is_copied(axis: &Signals, rows: usize) -> bool {
    let moves = (rows..axis.reference.len()).filter(|k| axis.reference_steps[k - rows] != 0.0);
    let (mut moving, mut equal) = (0_usize, 0_usize);
    for k in moves {
        (moving, equal) = (moving + 1, equal + usize::from(axis.actual[k] == axis.reference[k - rows]));
        // A measured position differs in the first rows.
        if moving == FEWEST_ROWS && equal == 0 {
            return false;
        }
    }
    moving >= FEWEST_ROWS && equal as f64 >= EQUAL * moving as f64
}

/// Ranges of consecutive `true`, as start and end (excluded).
pub(super) fn segments(flags: &[bool]) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut start = None;
    for (k, &flag) in flags.iter().chain(std::iter::once(&false)).enumerate() {
        match (flag, start) {
            (true, None) => start = Some(k),
            (false, Some(from)) => {
                found.push((from, k));
                start = None;
            }
            _ => {}
        }
    }
    found
}
