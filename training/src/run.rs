//! One axis of one recorded run, and the rows available for fitting and scoring.

use std::ops::Range;

/// One axis of one recorded run.
///
/// Signals cover the whole run, so that every row has the command history of the machine. Held-out
/// data are excluded by row: errors of rows outside [`Self::rows`] are neither fitted nor scored.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisRun {
    /// Commanded position, mm or rad, one a period.
    pub reference: Vec<f64>,
    /// Actual position at the same instants.
    pub actual: Vec<f64>,
    /// Sampling period, s.
    pub period_s: f64,
    /// Rows whose errors may be fitted and scored, sorted and disjoint.
    pub rows: Vec<Range<usize>>,
}

impl AxisRun {
    /// A run with all rows.
    #[must_use]
    pub fn new(reference: Vec<f64>, actual: Vec<f64>, period_s: f64) -> Self {
        let rows = std::iter::once(0..reference.len()).collect();
        Self { reference, actual, period_s, rows }
    }

    /// Commanded less actual position at every sample, mm or rad.
    pub(crate) fn tracking_error(&self) -> Vec<f64> {
        self.reference.iter().zip(&self.actual).map(|(r, x)| r - x).collect()
    }

    /// The same run, restricted to its rows in `rows` (sorted and disjoint).
    #[must_use]
    pub fn only(&self, rows: &[Range<usize>]) -> Self {
        let both = |a: &Range<usize>, b: &Range<usize>| a.start.max(b.start)..a.end.min(b.end);
        let rows = self.rows.iter().flat_map(|own| rows.iter().map(move |other| both(own, other)));
        Self { rows: rows.filter(|rows| !rows.is_empty()).collect(), ..self.clone() }
    }

    /// The same run without its rows in `rows` (sorted and disjoint).
    #[must_use]
    pub fn without(&self, rows: &[Range<usize>]) -> Self {
        let starts = std::iter::once(0).chain(rows.iter().map(|rows| rows.end));
        let ends = rows.iter().map(|rows| rows.start).chain([self.reference.len()]);
        let rest: Vec<Range<usize>> = starts.zip(ends).map(|(start, end)| start..end).filter(|rows| !rows.is_empty()).collect();
        self.only(&rest)
    }

    /// Rows whose errors count: [`Self::rows`] without the start of a log that begins in motion.
    #[must_use]
    pub fn scored(&self) -> Vec<Range<usize>> {
        let whole = datasets::scored(&self.reference, self.period_s);
        let both = self.rows.iter().map(|rows| rows.start.max(whole.start)..rows.end.min(whole.end));
        both.filter(|rows| !rows.is_empty()).collect()
    }

    /// Number of rows that count.
    #[must_use]
    pub fn scored_len(&self) -> usize {
        self.scored().iter().map(ExactSizeIterator::len).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_taken_and_left_out() {
        let at_rest = AxisRun::new(vec![0.0; 1000], vec![0.0; 1000], 0.002);
        let held = [100..200, 500..1000];
        assert_eq!(at_rest.only(&held).rows, held);
        assert_eq!(at_rest.without(&held).rows, [0..100, 200..500]);
        assert_eq!(at_rest.without(&held).only(&[50..90, 95..300]).rows, [50..90, 95..100, 200..300]);
        assert_eq!(at_rest.only(&held).scored_len(), 600);
        let moving = AxisRun::new((0..1000).map(f64::from).collect(), vec![0.0; 1000], 0.002);
        assert_eq!(moving.only(&held).scored(), [150..200, 500..1000]);
    }
}
