//! From axis positions to tool poses and back.

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
}

/// Up to three perpendicular linear axes and an upright tool. Axes that are neither `x`, `y` nor `z` do not move the tool.
#[derive(Debug, Clone, PartialEq)]
pub struct Cartesian {
    axes: Vec<Axis>,
    /// For every axis the coordinate it moves.
    slots: Vec<Option<usize>>,
}

impl Cartesian {
    /// The Cartesian machine with these axes, in this order.
    #[must_use]
    pub fn new(axes: Vec<Axis>) -> Self {
        let slots = axes.iter().map(|axis| ["x", "y", "z"].iter().position(|name| *name == axis.name)).collect();
        Self { axes, slots }
    }
}

impl Kinematics for Cartesian {
    fn axes(&self) -> &[Axis] {
        &self.axes
    }

    fn forward(&self, joints: &[f64]) -> Pose {
        let mut tip = Vec3::zeros();
        for (slot, position) in self.slots.iter().zip(joints) {
            if let Some(slot) = slot {
                tip[*slot] = *position;
            }
        }
        Pose::upright(tip)
    }

    fn inverse(&self, pose: &Pose, near: &[f64]) -> Result<Vec<f64>, MotionError> {
        Ok(self.slots.iter().zip(near).map(|(slot, near)| slot.map_or(*near, |slot| pose.tip[slot])).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_undoes_forward_and_keeps_other_axes() {
        let machine = Cartesian::new(["z", "x", "u"].map(Axis::named).to_vec());
        let joints = [1.0, 2.0, 3.0];
        let pose = machine.forward(&joints);
        assert_eq!(pose.tip, Vec3::new(2.0, 0.0, 1.0));
        assert_eq!(machine.inverse(&pose, &joints).unwrap(), joints);
    }
}
