//! Tangent approximation: the tangent at the time-matched sample replaces the path.

use crate::MotionError;
use crate::contour::spline::{Arcs, distinct_neighbours, error};
use crate::contour::{ContourError, ContourEstimator, ContourQuery, check_paths};

/// Longest standstill, in samples back and ahead, that is skipped to find a direction.
pub(in crate::contour) const REST_REACH: usize = 64;

/// Distance to the tangent of `to` at the time-matched sample: `ε = e − (e·τ)τ` (alternative in
/// Paper D, table I).
///
/// First order: on a circle of radius r a tracking error `e` along the path adds `e²/2r`.
#[derive(Debug, Clone, Default)]
pub struct Tangent {
    arcs: Arcs,
}

impl ContourEstimator for Tangent {
    fn name(&self) -> &'static str {
        "tangent"
    }

    fn estimate_into(&mut self, query: ContourQuery<'_>, out: &mut Vec<ContourError>) -> Result<(), MotionError> {
        let ContourQuery { from, to, matching } = query;
        check_paths(from, to, matching)?;
        out.clear();
        self.arcs.rebuild(to);
        out.extend(from.iter().enumerate().map(|(k, sample)| {
            let at = matching.sample(k, to.len());
            let (before, after) = distinct_neighbours(to, at, REST_REACH);
            let along = after.unwrap_or(to[at]) - before.unwrap_or(to[at]);
            let tangent = along.try_normalize(0.0).unwrap_or_default();
            let foot = to[at] + tangent * tangent.dot(&(sample - to[at]));
            let at_end = before.is_none() && after.is_none();
            error(sample, foot, along, self.arcs.location(at, 0.0), at_end)
        }));
        Ok(())
    }
}
