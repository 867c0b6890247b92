//! Tangent approximation: the tangent at the time-matched sample replaces the path.

use super::local::estimate_locally;
use crate::MotionError;
use crate::contour::spline::Arcs;
use crate::contour::{ContourError, ContourEstimator, ContourQuery};

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
        estimate_locally(query, &mut self.arcs, out, |sample, [before, at, after]| {
            let along = after - before;
            let tangent = along.try_normalize(0.0).unwrap_or_default();
            (at + tangent * tangent.dot(&(sample - at)), along)
        })
    }
}
