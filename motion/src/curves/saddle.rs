//! Curves on a saddle, for five axes.

use super::{Curve, jet::Jet};
use crate::Vec3;

/// Length in the saddle's formula, mm.
const SPAN_MM: f64 = 160.0;

/// A curve projected vertically onto the saddle `z = (x² − y²)/160` (mm), with the tool along the
/// surface normal `(−∂z/∂x, −∂z/∂y, 1)`, normalised. `x` and `y` are those of the given curve,
/// whose `z` is ignored.
#[derive(Debug, Clone, Copy)]
pub struct OnSaddle<C>(pub C);

impl<C: Curve> Curve for OnSaddle<C> {
    fn domain(&self) -> (f64, f64) {
        self.0.domain()
    }

    fn derivatives(&self, u: f64) -> [Vec3; 4] {
        let plan = self.0.derivatives(u);
        let [x, y] = [0, 1].map(|coordinate| Jet(plan.map(|derivative| derivative[coordinate])));
        let z = (x * x - y * y) * (1.0 / SPAN_MM);
        std::array::from_fn(|order| Vec3::new(x.0[order], y.0[order], z.0[order]))
    }

    fn tool(&self, u: f64) -> Vec3 {
        let plan = self.0.point(u);
        Vec3::new(-2.0 * plan.x / SPAN_MM, 2.0 * plan.y / SPAN_MM, 1.0).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curves::library;

    fn curves() -> [(Box<dyn Curve>, f64); 2] {
        [(Box::new(library::saddle()), 1e-4), (Box::new(library::saddle_butterfly().unwrap()), 1e-7)]
    }

    #[test]
    fn derivatives_agree_with_differences() {
        for (curve, h) in curves() {
            let (first, last) = curve.domain();
            for share in [0.03, 0.22, 0.41, 0.57, 0.79, 0.97] {
                let u = first + share * (last - first);
                let (before, at, after) = (curve.derivatives(u - h), curve.derivatives(u), curve.derivatives(u + h));
                for order in 1..4 {
                    let numeric = (after[order - 1] - before[order - 1]) / (2.0 * h);
                    let error = (numeric - at[order]).norm();
                    assert!(error < 1e-6 * (1.0 + at[order].norm()), "{curve:?} at {u}, order {order}: {error}");
                }
            }
        }
    }

    #[test]
    fn the_tool_is_a_unit_vector_across_the_surface() {
        for (curve, _) in curves() {
            let (first, last) = curve.domain();
            for i in 0..=1000 {
                let u = first + (last - first) * f64::from(i) / 1000.0;
                let [point, velocity, ..] = curve.derivatives(u);
                let tool = curve.tool(u);
                assert!((point.z - (point.x * point.x - point.y * point.y) / 160.0).abs() < 1e-12);
                assert!((tool.norm() - 1.0).abs() < 1e-15 && tool.z > 0.0);
                assert!(tool.dot(&velocity).abs() < 1e-13 * (1.0 + velocity.norm()));
            }
        }
    }

    #[test]
    fn the_saddle_matches_its_formula() {
        let curve = library::saddle();
        assert!((curve.point(0.0) - Vec3::new(40.0, 0.0, 10.0)).norm() < 1e-14);
        assert!((curve.tool(0.0) - Vec3::new(-0.5, 0.0, 1.0).normalize()).norm() < 1e-15);
    }

    #[test]
    fn the_butterfly_fills_its_box() {
        let curve = library::saddle_butterfly().unwrap();
        let (mut low, mut high) = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
        for i in 0..=200_000 {
            let point = curve.point(f64::from(i) * 5e-6);
            (low, high) = (low.inf(&point), high.sup(&point));
        }
        assert!((high.x - 40.0).abs() < 1e-5 && (low.x + 40.0).abs() < 1e-5, "{} {}", low.x, high.x);
        assert!((high.y + low.y).abs() < 1e-5, "{} {}", low.y, high.y);
    }
}
