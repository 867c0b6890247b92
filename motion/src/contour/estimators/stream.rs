//! Contour errors of a stream of samples, in constant memory.

use std::collections::VecDeque;

use super::window::{Follower, Window};
use crate::contour::spline::SampledSpline;
use crate::contour::{ContourError, check_point};
use crate::{MotionError, Vec3};

/// [`Exact`](crate::contour::Exact) on two paths that are sampled together and arrive in time
/// order. The results are the same, delayed by twice `window.max_samples` (and a few) periods. The
/// buffer holds a few windows.
#[derive(Debug, Clone)]
pub struct ExactStream {
    window: Window,
    spline: SampledSpline,
    follower: Follower,
    waiting: VecDeque<Vec3>,
    /// Index of the first pending sample.
    next: usize,
    heading: Vec3,
}

impl ExactStream {
    /// A stream with this `window`. Its `max_samples` sets the delay.
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

    /// Takes the samples of one instant (mm). Returns the error of an earlier sample of `from` once
    /// it is certain: the first value returned belongs to the first sample, each later one to the
    /// next.
    ///
    /// # Errors
    /// If a coordinate is not finite or beyond 1e9 mm. The samples are then discarded.
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

    /// Appends the errors of all pending samples to `out`, in time order. The stream is then empty
    /// and may be reused.
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

    /// Number of pieces of the path in the buffer.
    #[must_use]
    pub fn buffered(&self) -> usize {
        self.spline.pieces.kept()
    }

    fn take(&mut self) -> Option<ContourError> {
        let sample = self.waiting.pop_front()?;
        let pieces = &self.spline.pieces;
        let foot = self.follower.step(pieces, &self.window, self.next as f64, 1.0, &sample);
        self.next += 1;
        Some(pieces.error_at(&foot, &sample, &mut self.heading))
    }
}
