//! Circle approximation: the osculating circle at the time-matched sample replaces the path.

use super::local::estimate_locally;
use crate::contour::spline::Arcs;
use crate::contour::{ContourError, ContourEstimator, ContourQuery};
use crate::{MotionError, Vec3};

/// Distance to the circle through the time-matched sample of `to` and its neighbours (alternative
/// in Paper D, table I).
///
/// Second order: exact on a circle. Where the curvature changes, an error of `κ′·e³/6` remains.
#[derive(Debug, Clone, Default)]
pub struct OsculatingCircle {
    arcs: Arcs,
}

impl ContourEstimator for OsculatingCircle {
    fn name(&self) -> &'static str {
        "circle"
    }

    fn estimate_into(&mut self, query: ContourQuery<'_>, out: &mut Vec<ContourError>) -> Result<(), MotionError> {
        estimate_locally(query, &mut self.arcs, out, |sample, [before, at, after]| foot_on_circle(sample, before, at, after))
    }
}

/// Foot point of `p` on the circle through three points in the order of travel, and the direction
/// of travel there. On the line through them if they are collinear.
fn foot_on_circle(p: &Vec3, a: Vec3, b: Vec3, c: Vec3) -> (Vec3, Vec3) {
    let (to_a, to_c) = (a - b, c - b);
    let axis = to_c.cross(&to_a);
    let doubled = 2.0 * axis.norm_squared();
    let line = || {
        let along = c - a;
        let tangent = along.try_normalize(0.0).unwrap_or_default();
        (b + tangent * tangent.dot(&(p - b)), along)
    };
    if doubled <= 1e-24 * to_a.norm_squared() * to_c.norm_squared() {
        return line();
    }
    let to_centre = (axis.cross(&to_c) * to_a.norm_squared() + to_a.cross(&axis) * to_c.norm_squared()) / doubled;
    let centre = b + to_centre;
    let offset = p - centre;
    let in_plane = offset - axis * (offset.dot(&axis) * 2.0 / doubled);
    match in_plane.try_normalize(0.0) {
        Some(outward) => (centre + outward * to_centre.norm(), axis.cross(&outward)),
        // All points of the circle are equally far from its centre.
        None => (b, c - a),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn foot_and_direction_on_a_tilted_circle() {
        let u = Vec3::new(1.0, 2.0, -0.5).normalize();
        let v = u.cross(&Vec3::z()).normalize();
        let at = |angle: f64| Vec3::new(1.0, -2.0, 3.0) + 5.0 * (angle.cos() * u + angle.sin() * v);
        let p = Vec3::new(1.0, -2.0, 3.0) + 5.2 * (0.3_f64.cos() * u + 0.3_f64.sin() * v) + 0.1 * u.cross(&v);
        let (foot, along) = foot_on_circle(&p, at(-0.02), at(0.0), at(0.015));
        assert!((foot - at(0.3)).norm() < 1e-9, "{}", (foot - at(0.3)).norm());
        assert!(along.dot(&(at(0.31) - at(0.3))) > 0.0);
    }
}
