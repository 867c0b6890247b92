//! What all windows of a program came to.

use std::collections::BTreeMap;

use gcode::Edits;
use motion::contour::ContourSummary;

use super::window::{Done, OutsideLines};
use crate::error::{Error, Result};
use crate::expectation::{Expectation, ExpectationSum};
use crate::model_based_ilc::WithoutGain;
use crate::part::{FixedMoves, Section, Whole};
use crate::refit::{Mark, RefitSettings, SlowStop, write_head};
use crate::tally::Tally;

/// A compensated long program.
#[derive(Debug)]
pub struct Joined<'a> {
    /// The program.
    pub content: Vec<u8>,
    /// Whether the offsets of all coordinate systems in which it cuts are known.
    pub is_placed: bool,
    /// Whether any point is shifted.
    pub gained: bool,
    /// Largest correction of a point, and largest bound of corrections, mm.
    pub largest_shift_mm: f64,
    /// Largest bound of corrections of a window, mm.
    pub max_shift: f64,
    /// Largest number of updates of a window.
    pub updates: usize,
    /// Predicted cycle time before and after, s.
    pub cycle_s: (f64, f64),
    /// Least increase of a cycle that was found where it is beyond the limit whatever the points.
    pub too_slow: Option<f64>,
    /// Longest slow zone before stops.
    pub slow_stop: Option<SlowStop>,
    /// Finest and coarsest points.
    pub points: Option<(RefitSettings, RefitSettings)>,
    /// Segments that are not changed because the forecast gains nothing by it.
    pub without_gain: Vec<WithoutGain>,
    /// Lines outside of the model's operating range.
    pub outside: Vec<OutsideLines>,
    /// Cutting moves that are left alone, by their reason.
    pub fixed: BTreeMap<&'static str, FixedMoves>,
    /// Length of feed moves, of those that are left alone, and of segments without gain, mm.
    pub feed_mm: f64,
    /// Length of those that are left alone, mm.
    pub fixed_mm: f64,
    /// Length of segments without gain, mm.
    pub without_gain_mm: f64,
    before: Tally,
    after: Tally,
    expected: ExpectationSum<'a>,
    windows: usize,
    samples: usize,
    /// Length and edits of the first window, which holds the head of the program.
    head: (usize, Edits),
}

impl<'a> Joined<'a> {
    pub(super) fn new(whole: &Whole, is_placed: bool) -> Self {
        Self {
            content: Vec::with_capacity(whole.program.bytes().len() * 5 / 4),
            is_placed,
            gained: false,
            largest_shift_mm: 0.0,
            max_shift: 0.0,
            updates: 0,
            cycle_s: (0.0, 0.0),
            too_slow: None,
            slow_stop: None,
            points: None,
            without_gain: Vec::new(),
            outside: Vec::new(),
            fixed: BTreeMap::new(),
            feed_mm: 0.0,
            fixed_mm: 0.0,
            without_gain_mm: 0.0,
            before: Tally::default(),
            after: Tally::default(),
            expected: ExpectationSum::default(),
            windows: 0,
            samples: 0,
            head: (0, Edits::new()),
        }
    }

    /// Number of windows.
    #[must_use]
    pub fn windows(&self) -> usize {
        self.windows
    }

    /// Predicted contour error over feed moves without compensation.
    ///
    /// # Errors
    /// [`Error::NoSamples`] where nothing is fed.
    pub fn before(&self) -> Result<ContourSummary> {
        self.before.summary().ok_or(Error::NoSamples)
    }

    /// The same with compensation.
    ///
    /// # Errors
    /// As [`Joined::before`].
    pub fn after(&self) -> Result<ContourSummary> {
        self.after.summary().ok_or(Error::NoSamples)
    }

    /// What a run is expected to come to.
    #[must_use]
    pub fn expectation(&self) -> Option<Expectation> {
        self.expected.expectation()
    }

    /// Time of the program that is done, for progress.
    pub(super) fn note(&self) -> String {
        format!("{:.0} s of machining", self.cycle_s.0)
    }

    /// Adds the next window.
    pub(super) fn add(&mut self, done: Done<'a>) {
        if self.windows == 0 {
            self.head = (done.written.bytes.len(), done.written.edits);
        }
        self.content.extend_from_slice(&done.written.bytes);
        self.gained |= done.gained;
        self.largest_shift_mm = self.largest_shift_mm.max(done.written.largest_shift_mm);
        self.max_shift = self.max_shift.max(done.max_shift);
        self.updates = self.updates.max(done.updates);
        let (before_s, after_s) = self.cycle_s;
        self.cycle_s = (before_s + done.samples as f64 * done.period_s, after_s + done.after_s);
        self.too_slow = [self.too_slow, done.too_slow].into_iter().flatten().reduce(f64::max);
        let stops = [self.slow_stop, done.points.and_then(|points| points.slow_stop)].into_iter().flatten();
        self.slow_stop = stops.max_by(|a, b| a.length_mm.total_cmp(&b.length_mm));
        self.points = [self.points, done.points.map(|points| (points, points))].into_iter().flatten().reduce(|a, b| {
            let finer = if b.0.spacing_s < a.0.spacing_s { b.0 } else { a.0 };
            (finer, if b.1.spacing_s > a.1.spacing_s { b.1 } else { a.1 })
        });
        if done.gained {
            self.without_gain.extend(done.without_gain);
            self.without_gain_mm += done.without_gain_mm;
        } else {
            self.without_gain_mm += done.feed_mm - done.fixed_mm;
        }
        for range in done.outside {
            match self.outside.iter_mut().find(|known| known.axis == range.axis && known.reason == range.reason) {
                Some(known) => {
                    known.lines.1 = known.lines.1.max(range.lines.1);
                    known.samples += range.samples;
                    known.fades |= range.fades;
                }
                None => self.outside.push(range),
            }
        }
        for (why, moves) in done.fixed {
            self.fixed.entry(why).and_modify(|known| *known = known.with(moves)).or_insert(moves);
        }
        self.feed_mm += done.feed_mm;
        self.fixed_mm += done.fixed_mm;
        self.before.add(&done.before, self.samples);
        self.after.add(&done.after, self.samples);
        self.expected.add(done.expected);
        self.samples += done.samples;
        self.windows += 1;
    }

    /// Puts the comment at the head of a changed program.
    pub(super) fn finish(&mut self, whole: &Whole, first: &Section, mark: Option<&Mark>) -> Result<()> {
        if let Some(mark) = mark.filter(|_| self.gained) {
            let (length, edits) = std::mem::replace(&mut self.head, (0, Edits::new()));
            let head = write_head(&whole.program, first.core.clone(), edits, mark, self.largest_shift_mm)?;
            self.content.splice(..length, head);
        }
        Ok(())
    }
}
