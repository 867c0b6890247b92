//! Paper A's estimator: foot of the perpendicular on the adjoining chords, mapped to a Hermite
//! spline.

use super::window::Window;
use crate::contour::spline::{Arcs, error, foot_on_chord, hermite};
use crate::contour::{ContourError, ContourEstimator, ContourQuery, check_paths};
use crate::{MotionError, Vec3};

/// Forward search range for the nearest sample from the last foot point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Horizon {
    /// To the end of the path, as printed in Paper A. Slow, and it cannot recover from a jump ahead
    /// at a crossing.
    ToEnd,
    /// To Paper C's adaptive window beyond the time-matched sample: twice `n = |P_d P_a| / |P_a
    /// P_{a−1}|` samples, because a decelerating path needs more than `n` for the remaining
    /// distance.
    #[default]
    Adaptive,
}

/// Paper A's estimator (section 3; Paper B, eq. 4-10): the nearest sample forward of the last foot
/// point, the foot of the perpendicular on its two chords, the point of the cubic Hermite spline at
/// the same fraction of the chord, the component of the error normal to the spline.
#[derive(Debug, Clone, Default)]
pub struct HermiteFootPoint {
    /// Forward search range.
    pub horizon: Horizon,
    arcs: Arcs,
}

impl HermiteFootPoint {
    /// The estimator with this horizon.
    #[must_use]
    pub fn new(horizon: Horizon) -> Self {
        Self { horizon, arcs: Arcs::default() }
    }

    fn last_candidate(&self, sample: &Vec3, to: &[Vec3], at: usize, first: usize) -> usize {
        let end = to.len() - 1;
        match self.horizon {
            Horizon::ToEnd => end,
            Horizon::Adaptive => {
                let step = (to[at] - to[at.saturating_sub(1)]).norm();
                let samples = 2.0 * (sample - to[at]).norm() / step;
                // At standstill 0/0 casts to 0, and a lag divided by 0 to the largest window.
                let reach = (samples.ceil() as usize).clamp(1, Window::default().max_samples);
                (at + reach).max(first + 1).min(end)
            }
        }
    }
}

impl ContourEstimator for HermiteFootPoint {
    fn name(&self) -> &'static str {
        "hermite-foot"
    }

    fn estimate_into(&mut self, query: ContourQuery<'_>, out: &mut Vec<ContourError>) -> Result<(), MotionError> {
        let ContourQuery { from, to, matching } = query;
        check_paths(from, to, matching)?;
        out.clear();
        self.arcs.rebuild(to);
        let mut first = 0;
        for (k, sample) in from.iter().enumerate() {
            let at = matching.sample(k, to.len());
            let last = self.last_candidate(sample, to, at, first);
            let mut nearest = first;
            let mut least = f64::INFINITY;
            for (w, point) in to.iter().enumerate().take(last + 1).skip(first) {
                let squared = (sample - point).norm_squared();
                if squared < least {
                    (nearest, least) = (w, squared);
                }
            }
            let (segment, share) = foot_near(sample, to, nearest);
            let (point, along) = hermite(to, segment, share);
            let tangent = along.try_normalize(0.0).unwrap_or_default();
            let foot = point + tangent * tangent.dot(&(sample - point));
            let at_end = (segment == 0 && share <= 0.0) || segment as f64 + share >= (to.len() - 1) as f64;
            let foot = if at_end { point } else { foot };
            out.push(error(sample, foot, along, self.arcs.location(segment, share), at_end));
            first = segment;
        }
        Ok(())
    }
}

/// Segment and fraction of the foot of the perpendicular on the chords at sample `nearest`: the
/// nearer foot if both chords have one, the sample itself if neither has.
pub(in crate::contour) fn foot_near(sample: &Vec3, to: &[Vec3], nearest: usize) -> (usize, f64) {
    let chords = [nearest.checked_sub(1), (nearest + 1 < to.len()).then_some(nearest)];
    let feet = chords.into_iter().flatten().filter_map(|segment| {
        let (a, b) = (&to[segment], &to[segment + 1]);
        let (share, within) = foot_on_chord(sample, a, b);
        within.then(|| (segment, share, (sample - a - (b - a) * share).norm_squared()))
    });
    feet.min_by(|one, other| one.2.total_cmp(&other.2)).map_or((nearest, 0.0), |(segment, share, _)| (segment, share))
}
