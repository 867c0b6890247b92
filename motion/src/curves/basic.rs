//! Lines, arcs with helical lift, and cubic Béziers.

use super::Curve;
use crate::{MotionError, Vec3};

/// A straight line, `u` from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// First point, mm.
    pub start: Vec3,
    /// Last point, mm.
    pub end: Vec3,
}

impl Curve for Line {
    fn domain(&self) -> (f64, f64) {
        (0.0, 1.0)
    }

    fn derivatives(&self, u: f64) -> [Vec3; 4] {
        [self.point(u), self.velocity(u), Vec3::zeros(), Vec3::zeros()]
    }

    fn point(&self, u: f64) -> Vec3 {
        // Weighted sum: both end points are exact to the bit.
        let u = u.clamp(0.0, 1.0);
        self.start * (1.0 - u) + self.end * u
    }

    fn velocity(&self, _u: f64) -> Vec3 {
        self.end - self.start
    }

    fn degree(&self) -> Option<usize> {
        Some(1)
    }
}

/// An arc about an axis, with a lift along it and a linear change of radius: circle, helix or
/// spiral arc. `u` from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arc {
    center: Vec3,
    /// In-plane unit vector towards the start.
    radial: Vec3,
    /// In-plane unit vector 90° ahead, in the sense of positive sweep.
    ahead: Vec3,
    lift: Vec3,
    radius: (f64, f64),
    sweep_rad: f64,
}

impl Arc {
    /// The arc from `start` about the axis through `center` along unit vector `normal`. It sweeps
    /// `sweep_rad` (right-handed, more than one turn allowed) and ends at radius `end_radius` and
    /// `lift_mm` further along `normal`. Lengths in mm.
    ///
    /// # Errors
    /// If the start lies on the axis, or a value is not finite.
    pub fn new(
        start: Vec3,
        center: Vec3,
        normal: Vec3,
        sweep_rad: f64,
        end_radius: f64,
        lift_mm: f64,
    ) -> Result<Self, MotionError> {
        let normal = normal.normalize();
        let offset = start - center;
        let along = normal * offset.dot(&normal);
        let radial = offset - along;
        let radius = radial.norm();
        let finite = [sweep_rad, end_radius, lift_mm, radius].iter().all(|v| v.is_finite());
        if !finite || radius <= 0.0 || end_radius < 0.0 {
            return Err(MotionError::BadCurve(format!("an arc of radius {radius} mm to {end_radius} mm over {sweep_rad} rad")));
        }
        let radial = radial / radius;
        Ok(Self {
            center: center + along,
            radial,
            ahead: normal.cross(&radial),
            lift: normal * lift_mm,
            radius: (radius, end_radius),
            sweep_rad,
        })
    }
}

impl Curve for Arc {
    fn domain(&self) -> (f64, f64) {
        (0.0, 1.0)
    }

    fn derivatives(&self, u: f64) -> [Vec3; 4] {
        let u = u.clamp(0.0, 1.0);
        let w = self.sweep_rad;
        let (sin, cos) = (w * u).sin_cos();
        let out = self.radial * cos + self.ahead * sin;
        let ahead = self.ahead * cos - self.radial * sin;
        let growth = self.radius.1 - self.radius.0;
        let r = self.radius.0 + growth * u;
        [
            self.center + out * r + self.lift * u,
            out * growth + ahead * (r * w) + self.lift,
            ahead * (2.0 * growth * w) - out * (r * w * w),
            out * (-3.0 * growth * w * w) - ahead * (r * w * w * w),
        ]
    }
}

/// A cubic Bézier, `u` from 0 to 1. Rounds corners, tangent to both legs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bezier {
    /// Control points, mm.
    pub points: [Vec3; 4],
}

impl Curve for Bezier {
    fn domain(&self) -> (f64, f64) {
        (0.0, 1.0)
    }

    fn derivatives(&self, u: f64) -> [Vec3; 4] {
        let [a, b, c, d] = self.points;
        let (ab, bc, cd) = (b - a, c - b, d - c);
        let share = u.clamp(0.0, 1.0);
        let second = ((bc - ab) * (1.0 - share) + (cd - bc) * share) * 6.0;
        [self.point(u), self.velocity(u), second, (cd - bc * 2.0 + ab) * 6.0]
    }

    fn point(&self, u: f64) -> Vec3 {
        let [a, b, c, d] = self.points;
        let u = u.clamp(0.0, 1.0);
        let w = 1.0 - u;
        a * (w * w * w) + b * (3.0 * u * w * w) + c * (3.0 * u * u * w) + d * (u * u * u)
    }

    fn velocity(&self, u: f64) -> Vec3 {
        let [a, b, c, d] = self.points;
        let u = u.clamp(0.0, 1.0);
        let w = 1.0 - u;
        ((b - a) * (w * w) + (c - b) * (2.0 * u * w) + (d - c) * (u * u)) * 3.0
    }

    fn degree(&self) -> Option<usize> {
        Some(3)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arc_ends_where_its_angle_says() {
        let start = Vec3::new(3.0, 1.0, 2.0);
        let arc = Arc::new(start, Vec3::new(1.0, 1.0, 0.0), Vec3::z(), std::f64::consts::PI, 2.0, 0.5).unwrap();
        assert!((arc.point(0.0) - start).norm() < 1e-15);
        assert!((arc.point(1.0) - Vec3::new(-1.0, 1.0, 2.5)).norm() < 1e-14);
        // Right-handed about +Z: the start moves towards +Y.
        assert!(arc.derivatives(0.0)[1].y > 0.0);
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let curves: [Box<dyn Curve>; 2] = [
            Box::new(Arc::new(Vec3::x(), Vec3::new(0.1, 0.2, 0.3), Vec3::new(0.2, 0.3, 1.0), 2.0, 1.5, 0.4).unwrap()),
            Box::new(Bezier { points: [Vec3::zeros(), Vec3::x(), Vec3::new(1.0, 2.0, 0.5), Vec3::new(0.5, 3.0, 0.0)] }),
        ];
        let h = 1e-4;
        for curve in &curves {
            let (before, at, after) = (curve.derivatives(0.4 - h), curve.derivatives(0.4), curve.derivatives(0.4 + h));
            for order in 1..4 {
                let numeric = (after[order - 1] - before[order - 1]) / (2.0 * h);
                assert!((numeric - at[order]).norm() < 1e-5 * (1.0 + at[order].norm()));
            }
        }
    }
}
