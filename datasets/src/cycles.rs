//! Counters of position-control cycles or rows, which show where rows are lost.

use crate::Table;

/// Name of the signal of SINUMERIK Edge that counts the position-control cycles.
pub(crate) const CYCLE: &str = "CYCLE";

/// Names of counters; that of rows without one is pandas'.
const COUNTERS: [&str; 7] = ["cycle", "cycles", "sample", "samples", "index", "row", "unnamed: 0"];

fn counter(table: &Table) -> Option<usize> {
    table.names.iter().position(|name| COUNTERS.iter().any(|known| name.trim().eq_ignore_ascii_case(known)))
}

/// Whether there is a counter among the columns.
pub(crate) fn has_counter(table: &Table) -> bool {
    counter(table).is_some()
}

/// The counts of a table; `None` without a counter, and where it does not count up.
pub(crate) fn counts(table: &Table) -> Option<&[f64]> {
    let counts = table.columns.get(counter(table)?)?;
    let is_rising = counts.iter().all(|count| count.is_finite()) && counts.windows(2).all(|pair| pair[1] > pair[0]);
    is_rising.then_some(counts)
}

/// Counts as time since the first row, s, for rows that are `period_s` apart where none is lost. A recorder may skip cycles regularly: the
/// smallest step is one period.
pub(crate) fn seconds(counts: &[f64], period_s: f64) -> Vec<f64> {
    let steps = counts.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0);
    let step = steps.fold(f64::INFINITY, f64::min);
    let step = if step.is_finite() { step.max(1.0) } else { 1.0 };
    let first = counts.first().copied().unwrap_or_default();
    counts.iter().map(|count| (count - first) / step * period_s).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_counter_counts_up() {
        let of = |column: &[f64]| Table { names: vec!["Sample".to_owned()], columns: vec![column.to_vec()], ..Table::default() };
        assert_eq!(counts(&of(&[1.0, 2.0, 4.0])), Some(&[1.0, 2.0, 4.0][..]));
        for column in [[1.0, 1.0, 2.0], [65_535.0, 0.0, 1.0], [1.0, f64::NAN, 3.0]] {
            assert_eq!(counts(&of(&column)), None);
        }
        assert!(has_counter(&of(&[])) && !has_counter(&Table::default()));
    }

    #[test]
    fn lost_cycles_are_steps_in_time() {
        assert_eq!(seconds(&[700.0, 702.0, 704.0, 710.0], 0.5), [0.0, 0.5, 1.0, 2.5]);
        assert_eq!(seconds(&[7.0, 7.0], 0.5), [0.0, 0.0]);
        assert!(seconds(&[], 0.5).is_empty());
    }
}
