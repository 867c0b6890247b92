//! Three-axis machines.

use super::Kinematics;
use crate::{Axis, MotionError, Pose, Vec3};

/// Up to three perpendicular linear axes and an upright tool. Axes that are neither `x`, `y` nor `z` do not move the tool.
#[derive(Debug, Clone, PartialEq)]
pub struct Cartesian {
    axes: Vec<Axis>,
    /// The coordinate moved by every axis.
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

    fn reach(&self, pose: &Pose, joints: &mut [f64]) -> Result<(), MotionError> {
        for (joint, slot) in joints.iter_mut().zip(&self.slots) {
            if let Some(slot) = slot {
                *joint = pose.tip[*slot];
            }
        }
        Ok(())
    }

    fn place_at(&self, tip: &Vec3, rotary: &[f64; 3], joints: &mut [f64]) -> Result<(), MotionError> {
        for ((joint, axis), slot) in joints.iter_mut().zip(&self.axes).zip(&self.slots) {
            *joint = match slot {
                Some(slot) => tip[*slot],
                None => axis.slot().and_then(|slot| rotary.get(slot.checked_sub(3)?)).copied().unwrap_or(*joint),
            };
        }
        Ok(())
    }

    fn jacobian(&self, _joints: &[f64]) -> Vec<[Vec3; 2]> {
        let column = |slot: &Option<usize>| slot.map_or(Vec3::zeros(), |slot| Vec3::ith(slot, 1.0));
        self.slots.iter().map(|slot| [column(slot), Vec3::zeros()]).collect()
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

    #[test]
    fn words_go_to_their_axes() {
        let machine = Cartesian::new(["z", "c", "x", "u"].map(Axis::named).to_vec());
        let placed = machine.place(&Vec3::new(1.0, 2.0, 3.0), &[0.1, 0.2, 0.3], &[9.0; 4]).unwrap();
        assert_eq!(placed, [3.0, 0.3, 1.0, 9.0]);
        let columns = machine.jacobian(&placed);
        assert_eq!(
            columns.iter().map(|column| column[0]).collect::<Vec<_>>(),
            [Vec3::z(), Vec3::zeros(), Vec3::x(), Vec3::zeros()]
        );
        assert!(columns.iter().all(|column| column[1] == Vec3::zeros()));
        assert!(!machine.has_rotary_axes() && machine.pole_distance_rad(&Vec3::z()).is_none() && machine.travel(0).is_none());
    }
}
