//! Columns that are sampled more slowly than the log: every value is repeated until the next one is read.

use super::digits::step_of;
use super::purpose::Purpose;
use super::signals::Signals;
use crate::{Check, Finding, Report};

/// Rows before and after a row over which its speed is taken.
const REACH: usize = 8;
/// Speed from which on a row counts as moving, in steps of the column's resolution: slower ones repeat a rounded value anyway.
const LEAST_STEPS: f64 = 3.0;
/// Least number of values, least mean number of rows of a value, and share of the values that stay for that number, give or take less than one.
const FEWEST: usize = 20;
const LEAST_ROWS: f64 = 1.8;
const REGULAR: f64 = 0.9;

/// Reports a command or an actual position that is held over several rows.
pub(super) fn check(axis: &Signals, purpose: Purpose, report: &mut Report) {
    let columns =
        [(axis.reference_name(), axis.reference, &axis.reference_steps), (axis.actual_name(), axis.actual, &axis.actual_steps)];
    for (name, values, steps) in columns {
        let Some(rows) = rows_of_value(values, steps, axis.of_kind(1e-6, 1e-8)) else { continue };
        report.push(
            Finding::new(
                purpose.grave(),
                Check::Dropout,
                format!(
                    "its values stay for {rows:.1} rows each while the axis moves: the column is read more slowly than the log is written, and \
                     its steps look like an error of the axis; log all columns at the rate of the slowest one, or keep one row in {:.0}",
                    rows.round()
                ),
            )
            .in_column(name),
        );
    }
}

/// Mean number of rows of one value while the axis moves, where each value stays for as many. An axis that sticks, and logs that lose rows,
/// repeat values now and then. `least`: resolution of a column that shows none.
fn rows_of_value(values: &[f64], steps: &[f64], least: f64) -> Option<f64> {
    let resolution = step_of(values).unwrap_or(0.0).max(least);
    let (mut lengths, mut since) = (Vec::new(), None);
    for k in REACH..values.len().saturating_sub(REACH) {
        let speed = (values[k + REACH] - values[k - REACH]).abs() / (2 * REACH) as f64;
        if speed <= LEAST_STEPS * resolution {
            since = None;
        } else if steps[k - 1] != 0.0 {
            lengths.extend(since.map(|since| k - since));
            since = Some(k);
        }
    }
    let mean = lengths.iter().sum::<usize>() as f64 / lengths.len().max(1) as f64;
    let regular = lengths.iter().filter(|length| (**length as f64 - mean).abs() < 1.0).count();
    (lengths.len() >= FEWEST && mean >= LEAST_ROWS && regular as f64 >= REGULAR * lengths.len() as f64).then_some(mean)
}
