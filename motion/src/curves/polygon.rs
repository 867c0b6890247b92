//! Regular polygons with rounded corners.

use std::f64::consts::PI;

use super::Curve;
use crate::{MotionError, Vec3};

/// A regular polygon about the origin with arcs as corners, one lap from the middle of a side, in a
/// plane tilted about the X axis.
///
/// The parameter is the arc length, mm. Curvature jumps where a line meets an arc: derivatives
/// there are those of the following piece.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoundedPolygon {
    sides: usize,
    /// Distance of the sides from the origin, mm.
    inradius_mm: f64,
    corner_mm: f64,
    /// From the middle of a side to the start of its corner, mm.
    half_line_mm: f64,
    /// Unit vectors of the plane.
    plane: [Vec3; 2],
}

impl RoundedPolygon {
    /// The polygon of `sides` sides whose unrounded corners lie at `circumradius_mm`, rounded with
    /// arcs of `corner_mm`. Its plane is XY rotated by `tilt_rad` about X.
    ///
    /// # Errors
    /// If it has fewer than three sides, or the arcs do not fit.
    pub fn new(sides: usize, circumradius_mm: f64, corner_mm: f64, tilt_rad: f64) -> Result<Self, MotionError> {
        let half_angle = PI / sides.max(1) as f64;
        let inradius_mm = circumradius_mm * half_angle.cos();
        let half_line_mm = (inradius_mm - corner_mm) * half_angle.tan();
        let sound = sides >= 3 && corner_mm > 0.0 && half_line_mm > 0.0 && half_line_mm.is_finite() && tilt_rad.is_finite();
        if !sound {
            return Err(MotionError::BadCurve(format!(
                "a polygon of {sides} sides, circumradius {circumradius_mm} mm, corners of {corner_mm} mm"
            )));
        }
        let plane = [Vec3::x(), Vec3::new(0.0, tilt_rad.cos(), tilt_rad.sin())];
        Ok(Self { sides, inradius_mm, corner_mm, half_line_mm, plane })
    }

    /// Direction change at a corner, rad.
    fn turn_rad(&self) -> f64 {
        2.0 * PI / self.sides as f64
    }

    /// From the middle of a side to the middle of the next, mm.
    fn period_mm(&self) -> f64 {
        2.0 * self.half_line_mm + self.corner_mm * self.turn_rad()
    }
}

impl Curve for RoundedPolygon {
    fn domain(&self) -> (f64, f64) {
        (0.0, self.sides as f64 * self.period_mm())
    }

    fn derivatives(&self, u: f64) -> [Vec3; 4] {
        let u = u.clamp(0.0, self.domain().1);
        let side = (u / self.period_mm()).floor().min((self.sides - 1) as f64);
        let along = u - side * self.period_mm();
        let arc_mm = self.corner_mm * self.turn_rad();
        let angle = side * self.turn_rad() + ((along - self.half_line_mm) / self.corner_mm).clamp(0.0, self.turn_rad());
        // Outward normal of the side, or of the arc. The direction of motion is 90° ahead of it.
        let (sin, cos) = angle.sin_cos();
        let [x, y] = self.plane;
        let (out, ahead) = (x * cos + y * sin, y * cos - x * sin);
        if along < self.half_line_mm {
            return [out * self.inradius_mm + ahead * along, ahead, Vec3::zeros(), Vec3::zeros()];
        }
        if along >= self.half_line_mm + arc_mm {
            return [out * self.inradius_mm + ahead * (along - self.period_mm()), ahead, Vec3::zeros(), Vec3::zeros()];
        }
        let (sin, cos) = (side * self.turn_rad()).sin_cos();
        let (side_out, side_ahead) = (x * cos + y * sin, y * cos - x * sin);
        let centre = side_out * (self.inradius_mm - self.corner_mm) + side_ahead * self.half_line_mm;
        let r = self.corner_mm;
        [centre + out * r, ahead, out * (-1.0 / r), ahead * (-1.0 / (r * r))]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_closes_without_a_jump_and_is_passed_at_unit_speed() {
        for sides in [3, 5, 12] {
            let polygon = RoundedPolygon::new(sides, 35.0, 4.0, 0.25).unwrap();
            let (first, last) = polygon.domain();
            assert!((polygon.point(first) - polygon.point(last)).norm() < 1e-9);
            let (steps, h) = (5_000, (last - first) / 5_000.0);
            for k in 0..steps {
                let (u, next) = (f64::from(k) * h, f64::from(k + 1) * h);
                let chord = (polygon.point(next) - polygon.point(u)).norm();
                assert!(chord <= h + 1e-9 && chord > 0.999 * h, "{sides} at {u}: {chord} against {h}");
                assert!((polygon.velocity(u).norm() - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn derivatives_agree_with_differences_within_a_piece() {
        let polygon = RoundedPolygon::new(5, 35.0, 4.0, 0.25).unwrap();
        let h = 1e-5;
        // In the first line, in the first corner, after it.
        for u in [3.0, polygon.half_line_mm + 2.0, polygon.half_line_mm + 7.0] {
            let (before, at, after) = (polygon.derivatives(u - h), polygon.derivatives(u), polygon.derivatives(u + h));
            for order in 1..4 {
                let numeric = (after[order - 1] - before[order - 1]) / (2.0 * h);
                assert!((numeric - at[order]).norm() < 1e-6, "order {order} at {u}");
            }
        }
    }

    #[test]
    fn corners_that_do_not_fit_are_refused() {
        assert!(RoundedPolygon::new(2, 35.0, 4.0, 0.0).is_err());
        assert!(RoundedPolygon::new(5, 35.0, 40.0, 0.0).is_err());
        assert!(RoundedPolygon::new(5, f64::NAN, 4.0, 0.0).is_err());
    }
}
