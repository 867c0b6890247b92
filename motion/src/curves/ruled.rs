//! Curves along a ruled surface, for five axes.

use super::{Curve, Nurbs};
use crate::Vec3;

/// The lower edge of a ruled surface `S(u, v) = (1 − v)·C₀(u) + v·C₁(u)`, with the tool along the
/// ruling through it, as in flank milling.
#[derive(Debug, Clone)]
pub struct RuledSurface {
    /// Lower edge `C₀`, mm: the path of the tool tip.
    pub lower: Nurbs,
    /// Upper edge `C₁`, mm, over the same parameter as the lower one.
    pub upper: Nurbs,
}

impl Curve for RuledSurface {
    fn domain(&self) -> (f64, f64) {
        self.lower.domain()
    }

    fn derivatives(&self, u: f64) -> [Vec3; 4] {
        self.lower.derivatives(u)
    }

    fn tool(&self, u: f64) -> Vec3 {
        (self.upper.point(u) - self.lower.point(u)).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curves::library;

    #[test]
    fn the_tool_lies_along_the_ruling() {
        let curve = library::s_piece().unwrap();
        let (first, last) = curve.domain();
        for share in [0.0, 0.13, 0.5, 0.77, 1.0] {
            let u = first + share * (last - first);
            let ruling = curve.upper.point(u) - curve.lower.point(u);
            let tool = curve.tool(u);
            assert!((tool.norm() - 1.0).abs() < 1e-15 && tool.cross(&ruling).norm() < 1e-12 && tool.z > 0.0);
            assert_eq!(curve.point(u), curve.lower.point(u));
        }
    }

    #[test]
    fn the_s_bends_both_ways_and_leans_to_both_sides_without_a_pole() {
        let curve = library::s_piece().unwrap();
        let (first, last) = curve.domain();
        let (mut left, mut right, mut inwards, mut outwards) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64);
        for i in 0..=1000 {
            let u = first + (last - first) * f64::from(i) / 1000.0;
            let [_, velocity, bend, _] = curve.derivatives(u);
            let curvature = velocity.cross(&bend).z / velocity.norm().powi(3);
            (left, right) = (left.max(curvature), right.min(curvature));
            let normal = Vec3::z().cross(&velocity).normalize();
            let lean = curve.tool(u).dot(&normal);
            (inwards, outwards) = (inwards.max(lean), outwards.min(lean));
            // At a pole the rotary axis beside the workpiece would have to turn at once.
            assert!(curve.tool(u).z < 8.0_f64.to_radians().cos(), "{u}");
        }
        assert!(left > 0.02 && right < -0.02, "{left} {right}");
        assert!(inwards > 0.2 && outwards < -0.2, "{inwards} {outwards}");
        assert!(left < 0.1 && right > -0.1, "{left} {right}");
    }
}
