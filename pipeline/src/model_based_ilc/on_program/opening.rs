//! Openings of the search: every cut-off, with the first updates only.

use machine::Machine;
use motion::Trajectory;

use super::candidate::Tried;
use super::search::{CUT_OFFS_HZ, DOUBLINGS, Search, further_in_time};
use crate::error::Result;
use crate::refit::{RefitSettings, TimeEncoding};

/// Updates of an opening: high cut-offs begin with a larger error and learn faster.
const OPENING_UPDATES: usize = 2;

/// A cut-off, and the best run with it.
pub(super) struct Opening {
    pub(super) tried: Tried,
    pub(super) low_pass_hz: f64,
    /// Relative increase of the cycle time by times of the points' own, where it is too large and the program therefore keeps its feeds.
    pub(super) kept_feeds: Option<f64>,
}

impl<M: Machine + ?Sized> Search<'_, '_, '_, M> {
    /// The best reference with this cut-off and a few updates of it, with the finest points whose cycle is short enough: with times of their own,
    /// or without, where these need points further apart and cost more, or the cycle is too long whatever the points.
    pub(super) fn opening(&mut self, low_pass_hz: f64, written: RefitSettings) -> Result<Opening> {
        self.low_pass_hz = low_pass_hz;
        let (first, others) = (self.ideals[0], &self.ideals[1..]);
        let mut best = self.opening_from(&first.reference, written)?;
        for ideal in others {
            let next = self.opening_from(&ideal.reference, written)?;
            if !best.tried.is_better(&next.tried) {
                best = next;
            }
        }
        Ok(best)
    }

    /// The opening from one reference.
    fn opening_from(&mut self, ideal: &Trajectory, written: RefitSettings) -> Result<Opening> {
        let low_pass_hz = self.low_pass_hz;
        let start = self.start(ideal)?;
        let (timed, slowdown) = self.finest(&start, written)?;
        let timed = self.begun(timed)?;
        let is_finest = matches!(&timed, Tried::Short(found) if found.written.spacing_s <= written.spacing_s);
        let kept = RefitSettings { encoding: TimeEncoding::Keep, ..written };
        if is_finest || written.encoding == TimeEncoding::Keep || !self.control.replans(kept) {
            return Ok(Opening { tried: timed, low_pass_hz, kept_feeds: None });
        }
        let (kept, _) = self.finest(&start, kept)?;
        let kept = self.begun(kept)?;
        let (tried, kept_feeds) = if timed.is_better(&kept) { (timed, None) } else { (kept, Some(slowdown)) };
        Ok(Opening { tried, low_pass_hz, kept_feeds })
    }

    /// A few updates of a run whose cycle is short enough.
    fn begun(&mut self, tried: Tried) -> Result<Tried> {
        if matches!(tried, Tried::Short(_)) { self.learn(tried, f64::INFINITY, OPENING_UPDATES) } else { Ok(tried) }
    }

    /// Doubles the time between points until the cycle is short enough; looser chords make no cycle shorter. All cut-offs but the lowest give up
    /// where it would be too long even if every further doubling halved the slowdown. Also returns the increase of the cycle time with `written`.
    fn finest(&mut self, start: &Trajectory, written: RefitSettings) -> Result<(Tried, f64)> {
        let mut best = self.run(start.clone(), written)?;
        let first = self.slowdown(best.cycle_s());
        let (mut at, mut slowdown) = (written, first);
        let is_lowest = CUT_OFFS_HZ.last() == Some(&self.low_pass_hz);
        for left in (1..=if self.may_coarsen(written) { DOUBLINGS } else { 0 }).rev() {
            let is_far = slowdown > self.cycle_limit * f64::from(1 << left);
            if matches!(best, Tried::Short(_)) || is_far && !is_lowest {
                break;
            }
            at = further_in_time(at);
            let next = self.run(start.clone(), at)?;
            slowdown = self.slowdown(next.cycle_s());
            if next.is_better(&best) {
                best = next;
            }
        }
        Ok((best, first))
    }
}
