//! Paper D's estimator: the nearest of ten points of a spline around the nearest sample.

use super::window::Window;
use crate::contour::spline::{Arcs, error, slope};
use crate::contour::{ContourError, ContourEstimator, ContourQuery, check_paths};
use crate::{MotionError, Vec3};

/// Intervals per segment (Paper D, `Δt = 0.2`).
const POINTS: usize = 5;

/// Paper D's estimator (eq. 21-24): the nearest among the time-matched sample of `to` and the next
/// `σ = ⌈|e_k| / |P_k − P_{k−1}|⌉`, then the nearest of ten points of the cubic Hermite spline on the two segments beside it.
///
/// The paper searches later samples, because an axis lags. If `to` leads (actual → desired, or an
/// over-compensated machine), earlier samples are searched.
#[derive(Debug, Clone, Default)]
pub struct SplineSearch {
    arcs: Arcs,
}

impl ContourEstimator for SplineSearch {
    fn name(&self) -> &'static str {
        "spline-search"
    }

    fn estimate_into(&mut self, query: ContourQuery<'_>, out: &mut Vec<ContourError>) -> Result<(), MotionError> {
        let ContourQuery { from, to, matching } = query;
        check_paths(from, to, matching)?;
        out.clear();
        self.arcs.rebuild(to);
        let mut before = from.first().copied().unwrap_or_default();
        for (k, sample) in from.iter().enumerate() {
            let at = matching.sample(k, to.len());
            let nearest = nearest_sample(sample, &before, to, at);
            before = *sample;
            let (segment, t, foot) = nearest_point(sample, to, nearest);
            let along = to[(segment + 1).min(to.len() - 1)] - to[segment];
            let at_end = (segment == 0 && t == 0.0) || segment as f64 + t >= (to.len() - 1) as f64;
            out.push(error(sample, foot, along, self.arcs.location(segment, t), at_end));
        }
        Ok(())
    }
}

/// Nearest of the samples that eq. 21 admits.
fn nearest_sample(sample: &Vec3, before: &Vec3, to: &[Vec3], at: usize) -> usize {
    let tracking = sample - to[at];
    let end = to.len() - 1;
    // The slower of the two paths needs the most samples for the distance. At standstill 0/0 casts
    // to 0, and a lag divided by 0 to the largest window.
    let step = (sample - before).norm().min((to[at] - to[at.saturating_sub(1)]).norm());
    let sigma = ((tracking.norm() / step).ceil() as usize).min(Window::default().max_samples);
    let travel = to[(at + 1).min(end)] - to[at.saturating_sub(1)];
    // While `to` is at standstill the side on which the sample lies is undefined.
    let ahead = tracking.dot(&travel);
    let low = if ahead <= 0.0 { at.saturating_sub(sigma) } else { at };
    let high = if ahead >= 0.0 { (at + sigma).min(end) } else { at };
    let mut best = (at, tracking.norm_squared());
    for (i, point) in to[low..=high].iter().enumerate() {
        let squared = (sample - point).norm_squared();
        if squared < best.1 {
            best = (low + i, squared);
        }
    }
    best.0
}

/// Nearest of the points at `t = 0.2 … 1` of the two segments beside sample `nearest`: segment, `t` and point.
fn nearest_point(sample: &Vec3, to: &[Vec3], nearest: usize) -> (usize, f64, Vec3) {
    let mut best = (nearest, 0.0, to[nearest]);
    let mut least = (sample - to[nearest]).norm_squared();
    for segment in [nearest.checked_sub(1), Some(nearest)].into_iter().flatten() {
        let Some(end) = to.get(segment + 1) else { continue };
        let start = to[segment];
        let (leaving, arriving) = (slope(to, segment), slope(to, segment + 1));
        let chord = end - start;
        let square = 3.0 * chord - 2.0 * leaving - arriving;
        let cube = leaving + arriving - 2.0 * chord;
        for i in 1..=POINTS {
            let t = i as f64 / POINTS as f64;
            let point = start + (leaving + (square + cube * t) * t) * t;
            let squared = (sample - point).norm_squared();
            if squared < least {
                least = squared;
                best = (segment, t, point);
            }
        }
    }
    best
}
