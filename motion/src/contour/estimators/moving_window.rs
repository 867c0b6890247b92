//! Paper C's estimator: an adaptive window around the time-matched sample, then the adjoining
//! chords.

use super::hermite::foot_near;
use super::window::Window;
use crate::MotionError;
use crate::contour::spline::{Arcs, error};
use crate::contour::{ContourError, ContourEstimator, ContourQuery, check_paths};

/// Paper C, section II-A: the nearest sample within `n = |P_d P_a| / |P_a P_{a−1}|` samples on
/// either side of the time-matched one, so that the other branch of a hairpin is never taken. Then
/// the foot of the perpendicular on its two chords (eq. 1-2).
#[derive(Debug, Clone, Default)]
pub struct MovingWindow {
    arcs: Arcs,
}

impl ContourEstimator for MovingWindow {
    fn name(&self) -> &'static str {
        "moving-window"
    }

    fn estimate_into(&mut self, query: ContourQuery<'_>, out: &mut Vec<ContourError>) -> Result<(), MotionError> {
        let ContourQuery { from, to, matching } = query;
        check_paths(from, to, matching)?;
        out.clear();
        self.arcs.rebuild(to);
        let last = to.len().saturating_sub(1);
        for (k, sample) in from.iter().enumerate() {
            let at = matching.sample(k, to.len());
            let step = (to[at] - to[at.saturating_sub(1)]).norm();
            // At standstill 0/0 casts to 0, and a lag divided by 0 to the largest window.
            let reach = ((sample - to[at]).norm() / step).ceil() as usize;
            let reach = reach.clamp(1, Window::default().max_samples);
            let near = (at.saturating_sub(reach)..=(at + reach).min(last))
                .min_by(|a, b| (sample - to[*a]).norm_squared().total_cmp(&(sample - to[*b]).norm_squared()));
            let (segment, share) = foot_near(sample, to, near.unwrap_or(at));
            let end = to[(segment + 1).min(last)];
            let foot = to[segment].lerp(&end, share);
            let at_end = (segment == 0 && share <= 0.0) || segment as f64 + share >= last as f64;
            out.push(error(sample, foot, end - to[segment], self.arcs.location(segment, share), at_end));
        }
        Ok(())
    }
}
