//! Kinematics: axis positions to tool poses and back.

mod cartesian;
mod five_axis;
mod orientation;

pub use cartesian::Cartesian;
pub use five_axis::{FiveAxis, RotaryJoint, RotaryMount};

use crate::{Axis, MotionError, Pose, Vec3};

/// Forward and inverse kinematics of a machine.
pub trait Kinematics: std::fmt::Debug + Send + Sync {
    /// The axes, in the order of every position slice below.
    fn axes(&self) -> &[Axis];

    /// Pose in the workpiece frame at the axis positions `joints` (mm, rad; one per machine axis).
    fn forward(&self, joints: &[f64]) -> Pose;

    /// Moves `joints` (mm, rad) to `pose`, to the solution nearest to their present values.
    /// Unchanged on an error.
    ///
    /// # Errors
    /// If the pose cannot be reached.
    fn reach(&self, pose: &Pose, joints: &mut [f64]) -> Result<(), MotionError>;

    /// Moves `joints` (mm, rad) so that the tool tip is at `tip` (mm, workpiece frame) and the
    /// rotary axes A, B, C are at `rotary` (rad; entries of missing axes are ignored), as for
    /// tool-centre-point words. Axes without influence on the tool keep their positions. Unchanged
    /// on an error.
    ///
    /// # Errors
    /// If an axis would leave its travel.
    fn place_at(&self, tip: &Vec3, rotary: &[f64; 3], joints: &mut [f64]) -> Result<(), MotionError>;

    /// Axis positions (mm, rad) of `pose`: the solution nearest to `near`.
    ///
    /// # Errors
    /// If the pose cannot be reached.
    fn inverse(&self, pose: &Pose, near: &[f64]) -> Result<Vec<f64>, MotionError> {
        let mut joints = near.to_vec();
        self.reach(pose, &mut joints)?;
        Ok(joints)
    }

    /// Axis positions (mm, rad) of [`Kinematics::place_at`], from `near`.
    ///
    /// # Errors
    /// If an axis would leave its travel.
    fn place(&self, tip: &Vec3, rotary: &[f64; 3], near: &[f64]) -> Result<Vec<f64>, MotionError> {
        let mut joints = near.to_vec();
        self.place_at(tip, rotary, &mut joints)?;
        Ok(joints)
    }

    /// Derivatives of tool tip (mm per mm or rad) and tool axis (1 per mm or rad) with respect to
    /// every axis at `joints`, workpiece frame (Paper C, eq. 6).
    fn jacobian(&self, joints: &[f64]) -> Vec<[Vec3; 2]>;

    /// Whether an axis rotates tool or workpiece.
    fn has_rotary_axes(&self) -> bool {
        false
    }

    /// Angle, rad in `[0, π/2]`, between the tool axis `tool` and the nearest pole, where one axis
    /// does not change the tool direction. `None` if there is no pole.
    fn pole_distance_rad(&self, _tool: &Vec3) -> Option<f64> {
        None
    }

    /// Travel `[lowest, highest]` of the axis with index `axis` (mm, rad), if limited.
    fn travel(&self, _axis: usize) -> Option<[f64; 2]> {
        None
    }
}

/// Index among A, B, C of the rotary axis called `name`.
fn rotary_index(name: &str) -> Option<usize> {
    ["a", "b", "c"].iter().position(|rotary| *rotary == name)
}
