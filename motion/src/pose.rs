//! Tool poses: a tip and an axis.

use nalgebra::{Vector3, Vector6};

/// A point or vector in the workpiece frame, mm.
pub type Vec3 = Vector3<f64>;

/// X, Y, Z in mm and A, B, C in rad.
pub type Vec6 = Vector6<f64>;

/// A tool pose in the workpiece frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Tool tip, mm.
    pub tip: Vec3,
    /// Unit vector along the tool, from the tip towards the spindle.
    pub tool: Vec3,
}

impl Pose {
    /// A pose with an upright tool (`+Z`), as on every three-axis machine. `tip` in mm.
    #[must_use]
    pub fn upright(tip: Vec3) -> Self {
        Self { tip, tool: Vec3::z() }
    }

    /// Angle between the tool axes of two poses, rad in `[0, π]` (Paper C, eq. 4).
    #[must_use]
    pub fn angle_to(&self, other: &Self) -> f64 {
        // atan2 keeps its digits at microradians, acos does not.
        self.tool.cross(&other.tool).norm().atan2(self.tool.dot(&other.tool))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_angles_keep_their_digits() {
        let a = Pose::upright(Vec3::zeros());
        let angle = 1e-9_f64;
        let b = Pose { tip: Vec3::zeros(), tool: Vec3::new(angle.sin(), 0.0, angle.cos()) };
        assert!((a.angle_to(&b) - angle).abs() < 1e-18);
    }
}
