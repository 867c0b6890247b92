//! The exact contour error against the smooth path through samples.

use super::window::{Follower, Window};
use crate::contour::spline::SampledSpline;
use crate::contour::{ContourError, ContourEstimator, ContourQuery, check_paths};
use crate::{MotionError, Vec3};

/// Samples processed at a time. The spline through `to` is built just ahead of them, so that it
/// stays in the cache.
const BLOCK: usize = 256;

/// The foot point on the [`SampledSpline`] through `to`: the nearest point within the [`Window`],
/// to within 1e-9 mm.
///
/// Newton's method where the squared distance is provably convex along a piece, branch and bound
/// elsewhere (corners, standstill, noise). Pieces whose bounding sphere is too far away are
/// skipped.
#[derive(Debug, Clone, Default)]
pub struct Exact {
    window: Window,
    spline: SampledSpline,
    follower: Follower,
}

impl Exact {
    /// The estimator with another window.
    ///
    /// # Errors
    /// If the margin of the window is negative or not finite, or its largest half-width is below
    /// its smallest.
    pub fn with_window(window: Window) -> Result<Self, MotionError> {
        window.check()?;
        Ok(Self { window, ..Self::default() })
    }
}

impl ContourEstimator for Exact {
    fn name(&self) -> &'static str {
        "exact"
    }

    fn estimate_into(&mut self, query: ContourQuery<'_>, out: &mut Vec<ContourError>) -> Result<(), MotionError> {
        let ContourQuery { from, to, matching } = query;
        check_paths(from, to, matching)?;
        out.clear();
        out.reserve(from.len());
        self.spline.clear();
        self.follower.reset();
        let span = self.window.span();
        let mut whole = false;
        let mut heading = Vec3::zeros();
        for (block, samples) in from.chunks(BLOCK).enumerate() {
            let index = |k: usize| matching.index(block * BLOCK + k);
            // Casts saturate: a match before the path requests none of it, a match after it all of
            // it.
            let needed = (index(samples.len()) as usize).saturating_add(span + 3);
            if !whole {
                self.spline.extend(to, to.len().min(needed));
                whole = needed >= to.len();
                if whole {
                    self.spline.finish();
                }
            }
            let (pieces, window, follower) = (&self.spline.pieces, &self.window, &mut self.follower);
            out.extend(samples.iter().enumerate().map(|(k, sample)| {
                let foot = follower.step(pieces, window, index(k), matching.rate, sample);
                pieces.error_at(&foot, sample, &mut heading)
            }));
            let done = (index(samples.len()) as usize).saturating_sub(span);
            self.spline.pieces.drop_before(done, span);
        }
        Ok(())
    }
}
