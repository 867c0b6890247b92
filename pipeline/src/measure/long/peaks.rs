//! What is listed of a long log: its largest errors, reversals and segments.

use std::collections::VecDeque;

use motion::contour::{ContourError, summary_of};

use crate::measure::measurement::{Segment, WorstPoint};
use crate::measure::reversals::Reversal;
use crate::pieces::Heading;
use crate::tally::Tally;

/// Largest number of reversals and of segments that are listed.
pub(super) const MOST_LISTED: usize = 20_000;
/// Largest number of samples of a segment whose percentile is exact.
const EXACT: usize = 1 << 20;

/// The items with the largest keys.
#[derive(Debug)]
pub(super) struct Largest<T> {
    pub items: Vec<T>,
    pub seen: usize,
    most: usize,
    key: fn(&T) -> f64,
}

impl<T> Largest<T> {
    pub fn new(most: usize, key: fn(&T) -> f64) -> Self {
        Self { items: Vec::new(), seen: 0, most, key }
    }

    pub fn add(&mut self, item: T) {
        self.seen += 1;
        self.items.push(item);
        if self.items.len() >= 2 * self.most {
            self.trim();
        }
    }

    /// Leaves the largest items, in no order.
    pub fn trim(&mut self) {
        if self.items.len() > self.most {
            let key = self.key;
            self.items.select_nth_unstable_by(self.most, |a, b| key(b).total_cmp(&key(a)));
            self.items.truncate(self.most);
        }
    }
}

/// The samples with the largest errors, as [`worst_samples`](crate::analysis::worst_samples) chooses them: of those that are chosen each
/// excludes at most the samples beside it, so that few candidates are needed.
pub(super) struct WorstSum {
    candidates: Largest<(usize, ContourError)>,
    most: usize,
    apart: usize,
}

impl WorstSum {
    pub fn new(most: usize, apart: usize) -> Self {
        Self { candidates: Largest::new(most * (2 * apart + 1), |(_, error)| error.magnitude_mm), most, apart }
    }

    pub fn note(&mut self, sample: usize, error: &ContourError) {
        self.candidates.add((sample, *error));
    }

    pub fn points(mut self, period_s: f64) -> Vec<WorstPoint> {
        self.candidates.trim();
        let mut candidates = self.candidates.items;
        candidates.sort_by(|(a, of_a), (b, of_b)| of_b.magnitude_mm.total_cmp(&of_a.magnitude_mm).then(a.cmp(b)));
        let mut chosen: Vec<(usize, ContourError)> = Vec::new();
        for (sample, error) in candidates {
            if chosen.len() < self.most && chosen.iter().all(|(other, _)| other.abs_diff(sample) > self.apart) {
                chosen.push((sample, error));
            }
        }
        let point = |(sample, error): &(usize, ContourError)| WorstPoint {
            time_s: *sample as f64 * period_s,
            at: error.foot,
            error_mm: error.magnitude_mm,
            line: None,
        };
        chosen.iter().map(point).collect()
    }
}

/// A reversal whose glitch is not over.
struct Open {
    reversal: Reversal,
    component: usize,
    /// Samples of the errors that count, and their range.
    from: usize,
    end: usize,
    range: (f64, f64),
}

/// Reversals of an axis and their glitches.
pub(super) struct ReversalSum {
    pub axis: String,
    pub component: usize,
    /// Lag, and length of the glitch, samples.
    pub late: usize,
    pub window: usize,
    pub period_s: f64,
    heading: Heading,
    open: VecDeque<Open>,
}

impl ReversalSum {
    pub fn new(axis: String, component: usize, (late, window): (usize, usize), period_s: f64) -> Self {
        Self { axis, component, late, window, period_s, heading: Heading::default(), open: VecDeque::new() }
    }

    /// Notes the commanded position of a sample, before its error.
    pub fn command(&mut self, sample: usize, at: f64) {
        if let Some(from_positive) = self.heading.turns(at, self.period_s) {
            let time_s = sample as f64 * self.period_s;
            let reversal = Reversal { axis: self.axis.clone(), time_s, at, from_positive, glitch_mm: 0.0 };
            let from = sample + self.late;
            let range = (f64::INFINITY, f64::NEG_INFINITY);
            self.open.push_back(Open { reversal, component: self.component, from, end: from + self.window, range });
        }
    }

    /// Notes the error of a sample.
    pub fn error(&mut self, sample: usize, error: &ContourError, found: &mut Largest<Reversal>) {
        for open in self.open.iter_mut().take_while(|open| open.from <= sample) {
            let along = error.vector[open.component];
            open.range = (open.range.0.min(along), open.range.1.max(along));
        }
        while self.open.front().is_some_and(|open| open.end <= sample + 1) {
            self.close(found);
        }
    }

    fn close(&mut self, found: &mut Largest<Reversal>) {
        if let Some(Open { reversal, range: (low, high), .. }) = self.open.pop_front() {
            found.add(Reversal { glitch_mm: (high - low).max(0.0), ..reversal });
        }
    }

    pub fn finish(mut self, found: &mut Largest<Reversal>) {
        while !self.open.is_empty() {
            self.close(found);
        }
    }
}

/// Segments between standstills of the path.
pub(super) struct SegmentSum {
    from: usize,
    samples: usize,
    magnitudes: Vec<f64>,
    /// The magnitudes of a segment that is too long to be held.
    tally: Option<Box<Tally>>,
}

impl SegmentSum {
    pub fn new() -> Self {
        Self { from: 0, samples: 0, magnitudes: Vec::new(), tally: None }
    }

    /// Notes the error of a sample to which the path `moves`.
    pub fn note(&mut self, sample: usize, moves: bool, error_mm: f64, period_s: f64, found: &mut Largest<Segment>) {
        if !moves {
            self.close(period_s, found);
            return;
        }
        if self.samples == 0 {
            self.from = sample;
        }
        self.samples += 1;
        match &mut self.tally {
            Some(tally) => tally.note(self.samples - 1, error_mm),
            None => self.magnitudes.push(error_mm),
        }
        if self.magnitudes.len() > EXACT {
            let mut tally = Box::new(Tally::default());
            self.magnitudes.drain(..).enumerate().for_each(|(k, error_mm)| tally.note(k, error_mm));
            self.tally = Some(tally);
        }
    }

    pub fn close(&mut self, period_s: f64, found: &mut Largest<Segment>) {
        let contour = match self.tally.take() {
            Some(tally) => tally.summary(),
            None => summary_of(&self.magnitudes, None),
        };
        if let Some(contour) = contour {
            found.add(Segment { line: None, from_s: self.from as f64 * period_s, contour, samples: self.samples });
        }
        self.magnitudes.clear();
        self.samples = 0;
    }
}
