//! Non-uniform rational B-splines, by `curvo`.

use curvo::prelude::{Interpolation, NurbsCurve3D};
use nalgebra::{Point3, Point4};

use super::Curve;
use crate::{MotionError, Vec3};

/// A NURBS curve in space.
#[derive(Debug, Clone)]
pub struct Nurbs(NurbsCurve3D<f64>);

impl Nurbs {
    /// The NURBS of `degree` with control points (mm), weights and a knot vector of `points + degree + 1` entries.
    ///
    /// # Errors
    /// If the numbers of points, weights and knots do not match, a weight is not positive, or the
    /// knots decrease.
    pub fn new(degree: usize, points: &[Vec3], weights: &[f64], knots: &[f64]) -> Result<Self, MotionError> {
        if points.len() != weights.len() {
            return Err(MotionError::BadCurve(format!("{} control points but {} weights", points.len(), weights.len())));
        }
        if let Some(weight) = weights.iter().find(|w| !(w.is_finite() && **w > 0.0)) {
            return Err(MotionError::BadCurve(format!("a weight of {weight}; weights are positive")));
        }
        if knots.windows(2).any(|pair| pair[1] < pair[0]) {
            return Err(MotionError::BadCurve("the knot vector decreases".into()));
        }
        let control = points.iter().zip(weights).map(|(p, w)| Point4::new(p.x * w, p.y * w, p.z * w, *w)).collect();
        NurbsCurve3D::try_new(degree, control, knots.to_vec()).map(Self).map_err(|error| MotionError::BadCurve(error.to_string()))
    }

    /// The spline of `degree` through `points` (mm), with chord-length parameters.
    ///
    /// # Errors
    /// If there are too few points, or two neighbours coincide.
    pub fn through(points: &[Vec3], degree: usize) -> Result<Self, MotionError> {
        let points: Vec<Point3<f64>> = points.iter().map(|p| Point3::from(*p)).collect();
        NurbsCurve3D::interpolate(&points, degree).map(Self).map_err(|error| MotionError::BadCurve(error.to_string()))
    }
}

impl Curve for Nurbs {
    fn domain(&self) -> (f64, f64) {
        self.0.knots_domain()
    }

    fn derivatives(&self, u: f64) -> [Vec3; 4] {
        let (first, last) = self.domain();
        let derivatives = self.0.rational_derivatives(u.clamp(first, last), 3);
        std::array::from_fn(|order| derivatives[order])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interpolation_passes_through_its_points() {
        let points = [
            Vec3::new(0.0, 0.0, 0.0),
            Vec3::new(5.0, 1.0, 2.0),
            Vec3::new(9.0, 4.0, 1.0),
            Vec3::new(7.0, 9.0, 0.0),
            Vec3::new(1.0, 8.0, -2.0),
            Vec3::new(-3.0, 2.0, 1.0),
            Vec3::new(0.5, -3.0, 4.0),
        ];
        let curve = Nurbs::through(&points, 5).unwrap();
        let (first, last) = curve.domain();
        for point in &points {
            let nearest = (0..=20_000)
                .map(|i| (curve.point(first + (last - first) * f64::from(i) / 20_000.0) - point).norm())
                .fold(f64::INFINITY, f64::min);
            assert!(nearest < 2e-3, "{nearest}");
        }
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let points = [0.0, 1.0, 3.0, 2.0, 5.0].map(|x: f64| Vec3::new(x, x * x * 0.3 - x, x.sin()));
        let curve = Nurbs::new(3, &points, &[1.0, 2.0, 0.5, 1.5, 1.0], &[0.0, 0.0, 0.0, 0.0, 0.4, 1.0, 1.0, 1.0, 1.0]).unwrap();
        let h = 1e-5;
        let (before, at, after) = (curve.derivatives(0.3 - h), curve.derivatives(0.3), curve.derivatives(0.3 + h));
        for order in 1..4 {
            let numeric = (after[order - 1] - before[order - 1]) / (2.0 * h);
            assert!((numeric - at[order]).norm() < 1e-5 * (1.0 + at[order].norm()), "order {order}");
        }
    }

    #[test]
    fn unsound_definitions_are_refused() {
        let points = [Vec3::zeros(), Vec3::x()];
        assert!(Nurbs::new(1, &points, &[1.0], &[0.0, 0.0, 1.0, 1.0]).is_err());
        assert!(Nurbs::new(1, &points, &[1.0, -1.0], &[0.0, 0.0, 1.0, 1.0]).is_err());
        assert!(Nurbs::new(1, &points, &[1.0, 1.0], &[0.0, 0.5, 0.2, 1.0]).is_err());
        assert!(Nurbs::new(1, &points, &[1.0, 1.0], &[0.0, 1.0]).is_err());
    }
}
