//! The joints between workpiece and tool.

use nalgebra::Rotation3;

use super::super::orientation::turned;
use crate::{Pose, Vec3};

/// A joint of the chain from workpiece to tool.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Link {
    /// Index among the axes.
    pub(super) axis: usize,
    /// Index among A, B, C.
    pub(super) rotary: usize,
    /// Unit vector.
    pub(super) direction: Vec3,
    /// From workpiece zero, or from the tool tip for a head joint, mm.
    pub(super) pivot: Vec3,
}

impl Link {
    /// The joint at an angle.
    pub(super) fn at(&self, angle_rad: f64) -> Turn<'_> {
        Turn { link: self, sin_cos: angle_rad.sin_cos() }
    }
}

/// A joint at an angle.
pub(super) struct Turn<'a> {
    link: &'a Link,
    sin_cos: (f64, f64),
}

impl Turn<'_> {
    fn direction(&self, direction: &Vec3) -> Vec3 {
        turned(&self.link.direction, self.sin_cos, direction)
    }

    pub(super) fn point(&self, point: &Vec3) -> Vec3 {
        self.link.pivot + self.direction(&(point - self.link.pivot))
    }

    pub(super) fn pose(&self, pose: &Pose) -> Pose {
        Pose { tip: self.point(&pose.tip), tool: self.direction(&pose.tool) }
    }
}

/// A frame inside another: `p ↦ rotation·p + origin`.
pub(super) struct Frame {
    pub(super) rotation: Rotation3<f64>,
    pub(super) origin: Vec3,
}

impl Frame {
    pub(super) fn at_rest() -> Self {
        Self { rotation: Rotation3::identity(), origin: Vec3::zeros() }
    }

    pub(super) fn point(&self, point: &Vec3) -> Vec3 {
        self.rotation * point + self.origin
    }

    /// Appends a rotation about a joint.
    pub(super) fn turn(&mut self, link: &Link, angle_rad: f64) {
        let pivot = self.point(&link.pivot);
        self.rotation *= Rotation3::from_scaled_axis(link.direction * angle_rad);
        self.origin = pivot - self.rotation * link.pivot;
    }
}
