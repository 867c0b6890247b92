//! The runs of one axis that a servo model is fitted to, and what it may have.

use std::ops::Range;

use crate::axis::Start;
use crate::parameters::Servo;

/// One run of one axis, mm.
#[derive(Debug, Clone)]
pub struct Run {
    /// Commanded positions.
    pub reference: Vec<f64>,
    /// Actual positions at the same instants.
    pub actual: Vec<f64>,
    /// Start, where it is measured; `None` for the one that the model expects.
    pub start: Option<Start>,
    /// Samples that are fitted, sorted and disjoint.
    pub rows: Vec<Range<usize>>,
}

impl Run {
    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.reference.len().min(self.actual.len())
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Start of the model.
    pub(crate) fn start(&self, servo: &Servo, period_s: f64) -> Start {
        self.start.unwrap_or_else(|| servo.start(&self.reference, period_s))
    }

    /// The stretch of `samples` with the most fitted ones.
    fn stretch(&self, samples: usize, unscored: usize) -> Self {
        let samples = samples.min(self.len());
        // What came before a cut is not known.
        let first = |from: usize| if from == 0 { 0 } else { from + unscored };
        let fitted = |from: usize| -> usize {
            let inside = |rows: &Range<usize>| rows.end.min(from + samples).saturating_sub(rows.start.max(first(from)));
            self.rows.iter().map(inside).sum()
        };
        let starts = self.rows.iter().map(|rows| rows.start.min(self.len() - samples));
        let from = starts.fold(0, |best, from| if fitted(from) > fitted(best) { from } else { best });
        let to = from + samples;
        let rows = self.rows.iter().map(|rows| rows.start.max(first(from))..rows.end.min(to)).filter(|rows| !rows.is_empty());
        Self {
            rows: rows.map(|rows| rows.start - from..rows.end - from).collect(),
            reference: self.reference[from..to].to_vec(),
            actual: self.actual[from..to].to_vec(),
            start: if from == 0 { self.start } else { None },
        }
    }
}

/// What a servo model of an axis may have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Scope {
    /// Backlash: whether the sensor may lie behind it.
    pub sees_backlash: bool,
    /// What a prediction needs and a diagnosis leaves to its own tests: friction by place, contacts that slip one after the other, the rest
    /// before a motion, and every way of smoothing the command from the start.
    pub whole: bool,
}

/// Runs of one axis.
#[derive(Debug, Clone)]
pub struct Record {
    /// Sampling period, s.
    pub period_s: f64,
    /// The runs.
    pub runs: Vec<Run>,
}

/// Shortest part of a run that is compared, s.
const LEAST_S: f64 = 2.0;
/// Runs from which on halves are made of whole runs, and blocks of a run otherwise.
const LEAST_RUNS: usize = 4;
const BLOCKS: usize = 8;
/// Time after a cut that is not fitted, s.
const UNSCORED_S: f64 = 0.3;

impl Record {
    /// Time of the fitted samples, s.
    #[must_use]
    pub fn fitted_s(&self) -> f64 {
        self.fitted() as f64 * self.period_s
    }

    /// Number of fitted samples.
    pub(crate) fn fitted(&self) -> usize {
        self.runs.iter().flat_map(|run| &run.rows).map(ExactSizeIterator::len).sum()
    }

    /// Lowest and highest commanded position, mm.
    #[must_use]
    pub fn travel(&self) -> (f64, f64) {
        let all = self.runs.iter().flat_map(|run| &run.reference);
        all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &x| (low.min(x), high.max(x)))
    }

    /// Every second run, and the others; of a few runs blocks of their samples.
    #[must_use]
    pub(crate) fn halves(&self) -> [Self; 2] {
        [0, 1].map(|half| {
            let runs = self.runs.iter().enumerate().map(|(index, run)| {
                let rows = if self.runs.len() >= LEAST_RUNS {
                    if index % 2 == half { run.rows.clone() } else { Vec::new() }
                } else {
                    let block = run.len().div_ceil(BLOCKS).max(1);
                    let blocks = (half..BLOCKS).step_by(2).map(|i| i * block..(i + 1) * block);
                    let inside = |block: Range<usize>| {
                        let both = move |rows: &Range<usize>| rows.start.max(block.start)..rows.end.min(block.end);
                        run.rows.iter().map(both).filter(|rows| !rows.is_empty()).collect::<Vec<_>>()
                    };
                    blocks.flat_map(inside).collect()
                };
                Run { rows, ..run.clone() }
            });
            Self { period_s: self.period_s, runs: runs.filter(|run| !run.rows.is_empty()).collect() }
        })
    }

    /// The record cut to about `seconds`, an equal share of every run.
    #[must_use]
    pub fn shortened(&self, seconds: f64) -> Self {
        let samples = seconds / self.period_s;
        let total: usize = self.runs.iter().map(Run::len).sum();
        if total as f64 <= samples {
            return self.clone();
        }
        // No share shorter than two seconds: of many runs every n-th is taken.
        let least = (LEAST_S / self.period_s).ceil();
        let runs = self.runs.len();
        let taken = ((samples / least) as usize).clamp(1, runs);
        let share = (samples / taken as f64).ceil() as usize;
        let unscored = (UNSCORED_S / self.period_s).ceil() as usize;
        let runs = (0..taken).map(|i| self.runs[i * runs / taken].stretch(share, unscored)).collect();
        Self { period_s: self.period_s, runs }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(rows: Range<usize>) -> Vec<Range<usize>> {
        std::iter::once(rows).collect()
    }

    fn run(len: usize, rows: Vec<Range<usize>>) -> Run {
        Run { reference: vec![0.0; len], actual: vec![0.0; len], start: Some((0.0, 0.0).into()), rows }
    }

    #[test]
    fn a_record_is_cut_where_most_is_fitted_and_keeps_its_start_otherwise() {
        let of = |rows: Vec<Range<usize>>| Record { period_s: 0.01, runs: vec![run(3000, rows)] }.shortened(10.0);
        let from_the_start = of(one(30..3000));
        assert_eq!(from_the_start.runs[0].rows, one(30..1000));
        assert!(from_the_start.runs[0].start.is_some());
        let later = of(one(1500..3000));
        assert_eq!((later.runs[0].rows.clone(), later.runs[0].len()), (one(30..1000), 1000));
        assert!(later.runs[0].start.is_none() && (later.fitted_s() - 9.7).abs() < 1e-9);
    }

    #[test]
    fn halves_share_no_sample_and_leave_out_none() {
        for record in [
            Record { period_s: 0.01, runs: vec![run(999, vec![10..400, 500..999])] },
            Record { period_s: 0.01, runs: (0..5).map(|_| run(300, one(10..300))).collect() },
        ] {
            let [one, other] = record.halves();
            assert_eq!(one.fitted() + other.fitted(), record.fitted());
            assert!(one.fitted() > 0 && other.fitted() > 0);
        }
    }
}
