//! Contour errors while the samples arrive, in constant memory.

use std::collections::VecDeque;

use super::window::{Follower, Window};
use crate::contour::spline::SampledSpline;
use crate::contour::{ContourError, check_point};
use crate::{MotionError, Vec3};

/// [`Exact`](crate::contour::Exact) on two paths that are sampled together and arrive in time order: the same figures, twice
/// `window.max_samples` (and a few) periods late, out of a buffer of a few windows.
#[derive(Debug, Clone)]
pub struct ExactStream {
    window: Window,
    spline: SampledSpline,
    follower: Follower,
    waiting: VecDeque<Vec3>,
    /// Index of the first sample that waits.
    next: usize,
    heading: Vec3,
}

impl ExactStream {
    /// A stream that looks within `window`; its `max_samples` sets the delay.
    ///
    /// # Errors
    /// As [`Exact::with_window`](crate::contour::Exact::with_window).
    pub fn new(window: Window) -> Result<Self, MotionError> {
        window.check()?;
        Ok(Self {
            window,
            spline: SampledSpline::default(),
            follower: Follower::default(),
            waiting: VecDeque::new(),
            next: 0,
            heading: Vec3::zeros(),
        })
    }

    /// Takes the samples of one instant (mm) and returns the error of an earlier sample of `from` once it is certain: the first call
    /// that returns one returns that of the first sample, and each later call that of the next.
    ///
    /// # Errors
    /// When a coordinate is not finite or beyond 1e9 mm; the samples are then not taken.
    pub fn push(&mut self, from: Vec3, to: Vec3) -> Result<Option<ContourError>, MotionError> {
        check_point(&from)?;
        check_point(&to)?;
        self.spline.push(to);
        self.waiting.push_back(from);
        let span = self.window.span();
        if self.spline.segments() <= self.next + span {
            return Ok(None);
        }
        let error = self.take();
        self.spline.pieces.drop_before(self.next.saturating_sub(span), span);
        Ok(error)
    }

    /// Errors of all samples that still wait, in time order, appended to `out`; the stream is then empty and may be used again.
    pub fn finish(&mut self, out: &mut Vec<ContourError>) {
        self.spline.finish();
        while let Some(error) = self.take() {
            out.push(error);
        }
        self.spline.clear();
        self.follower.reset();
        self.next = 0;
        self.heading = Vec3::zeros();
    }

    /// Pieces of the path kept at the moment.
    #[must_use]
    pub fn buffered(&self) -> usize {
        self.spline.pieces.kept()
    }

    fn take(&mut self) -> Option<ContourError> {
        let sample = self.waiting.pop_front()?;
        let pieces = &self.spline.pieces;
        let place = self.follower.step(pieces, &self.window, self.next as f64, 1.0, &sample);
        self.next += 1;
        Some(pieces.error_at(&place, &sample, &mut self.heading))
    }
}
