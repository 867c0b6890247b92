//! Estimators that replace the path by a simple curve at the time-matched sample.

use crate::contour::spline::{Arcs, distinct_neighbours, error};
use crate::contour::{ContourError, ContourQuery, check_paths};
use crate::{MotionError, Vec3};

/// Longest standstill, in samples back and ahead, that is skipped to find a direction.
pub(in crate::contour) const REST_REACH: usize = 64;

/// Contour error of every sample against the curve that `foot` puts in place of the path. Its arguments are a sample and three points of
/// the path (before, at and after the time-matched sample); it returns the foot point and the direction of travel there.
pub(super) fn estimate_locally(
    query: ContourQuery<'_>,
    arcs: &mut Arcs,
    out: &mut Vec<ContourError>,
    foot: impl Fn(&Vec3, [Vec3; 3]) -> (Vec3, Vec3),
) -> Result<(), MotionError> {
    let ContourQuery { from, to, matching } = query;
    check_paths(from, to, matching)?;
    out.clear();
    arcs.rebuild(to);
    out.extend(from.iter().enumerate().map(|(k, sample)| {
        let at = matching.sample(k, to.len());
        let (before, after) = distinct_neighbours(to, at, REST_REACH);
        let (foot, along) = foot(sample, [before.unwrap_or(to[at]), to[at], after.unwrap_or(to[at])]);
        let at_end = before.is_none() && after.is_none();
        error(sample, foot, along, arcs.location(at, 0.0), at_end)
    }));
    Ok(())
}
