//! From axis positions to tool poses and back.

mod cartesian;
mod five_axis;
mod orientation;

pub use cartesian::Cartesian;
pub use five_axis::{FiveAxis, RotaryJoint, RotaryMount};

use crate::{Axis, MotionError, Pose, Vec3};

/// How a machine's axes place its tool.
pub trait Kinematics: std::fmt::Debug + Send + Sync {
    /// The axes, in the order of every position slice below.
    fn axes(&self) -> &[Axis];

    /// Pose in the workpiece frame of the axis positions `joints` (mm, rad; one a machine axis).
    fn forward(&self, joints: &[f64]) -> Pose;

    /// Axis positions (mm, rad) of `pose`, of all solutions the one nearest to `near`.
    ///
    /// # Errors
    /// When the pose cannot be reached.
    fn inverse(&self, pose: &Pose, near: &[f64]) -> Result<Vec<f64>, MotionError>;

    /// Axis positions (mm, rad) with the tool tip at `tip` (mm, workpiece frame) and the rotary axes A, B, C at `rotary` (rad;
    /// entries of axes that the machine lacks are ignored), as tool-centre-point words ask for. Axes that the kinematics does
    /// not place keep `near`.
    ///
    /// # Errors
    /// When an axis would leave its travel.
    fn place(&self, tip: &Vec3, rotary: &[f64; 3], near: &[f64]) -> Result<Vec<f64>, MotionError>;

    /// Derivatives of tool tip (mm per mm or rad) and tool axis (1 per mm or rad) by every axis at `joints`, workpiece frame
    /// (Paper C, eq. 6).
    fn jacobian(&self, joints: &[f64]) -> Vec<[Vec3; 2]>;

    /// Whether an axis turns tool or workpiece.
    fn turns(&self) -> bool {
        false
    }

    /// Angle, rad in `[0, π/2]`, between the tool axis and the nearest pole, where an axis may turn without effect on the tool's
    /// direction; `None` where there is no pole to come near to.
    fn pole_distance_rad(&self, _joints: &[f64]) -> Option<f64> {
        None
    }

    /// Travel `[lowest, highest]` of the axis with index `axis` (mm, rad), where it is limited.
    fn travel(&self, _axis: usize) -> Option<[f64; 2]> {
        None
    }
}

/// Index among A, B, C of the rotary axis called `name`.
fn rotary_index(name: &str) -> Option<usize> {
    ["a", "b", "c"].iter().position(|rotary| *rotary == name)
}
