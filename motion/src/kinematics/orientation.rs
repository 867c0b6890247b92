//! Angles of one or two rotary joints for a given tool direction.
//!
//! At zero angles the tool points along `+Z`. `outer` is the joint nearer to the workpiece, `inner`
//! the one nearer to the tool: the tool axis in the workpiece frame is `o = R(outer, α)·R(inner,
//! β)·z`, all rotations right-handed. This is the second Paden-Kahan subproblem. It is solved on
//! the spherical triangle of `inner`, `outer` and `v = R(inner, β)·z`, whose sides are known, with
//! half-angle formulas. These keep all digits near the poles, where the usual `acos` loses half of
//! them.

use std::f64::consts::PI;

use crate::Vec3;

/// Tolerance on reachable directions, rad.
pub(super) const REACH_RAD: f64 = 1e-9;

/// Within this angle of the outer joint's direction the angle of that joint is free, rad.
const POLE_RAD: f64 = 1e-12;

/// Angles of two joints. The outer one is `None` if it is free.
pub(super) type Branch = (Option<f64>, f64);

/// Angle between two vectors, rad in `[0, π]`.
pub(super) fn angle(a: &Vec3, b: &Vec3) -> f64 {
    a.cross(b).norm().atan2(a.dot(b))
}

/// Rotation angle from `from` to `to` about the unit vector `axis`, rad in `[-π, π]`.
fn turn(axis: &Vec3, from: &Vec3, to: &Vec3) -> f64 {
    // Both are first projected onto the plane normal to the axis: differences of products would
    // cancel near the axis.
    let (from, to) = (axis.cross(from), axis.cross(to));
    axis.dot(&from.cross(&to)).atan2(from.dot(&to))
}

/// Angle of a single joint about unit vector `axis` that points the tool along unit vector `tool`.
/// `None` if the angle is free. Error: the angle by which the direction is missed, rad.
pub(super) fn one_joint(axis: &Vec3, tool: &Vec3) -> Result<Option<f64>, f64> {
    let miss = (angle(axis, tool) - angle(axis, &Vec3::z())).abs();
    if miss > REACH_RAD {
        return Err(miss);
    }
    let free = axis.cross(&Vec3::z()).norm() < POLE_RAD;
    Ok((!free).then(|| turn(axis, &Vec3::z(), tool)))
}

/// `vector` rotated about the unit vector `axis` by an angle with this sine and cosine (Rodrigues).
pub(super) fn turned(axis: &Vec3, (sin, cos): (f64, f64), vector: &Vec3) -> Vec3 {
    vector * cos + axis.cross(vector) * sin + axis * (axis.dot(vector) * (1.0 - cos))
}

/// A pair of joints, with the constants of their triangle.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct TwoJoints {
    /// Unit vectors.
    outer: Vec3,
    inner: Vec3,
    /// Sides from `inner` to the tool and to `outer`, rad.
    tool_side: f64,
    joint_side: f64,
    /// Inner angle at which the tool is nearest to the direction of the outer joint, rad.
    nearest: f64,
}

impl TwoJoints {
    /// The joints about unit vectors `outer` and `inner`.
    pub fn new(outer: Vec3, inner: Vec3) -> Self {
        let z = Vec3::z();
        let (tool_side, joint_side) = (angle(&inner, &z), angle(&inner, &outer));
        Self { outer, inner, tool_side, joint_side, nearest: turn(&inner, &z, &outer) }
    }

    /// The two solutions for the tool along unit vector `tool`. Error: the angle by which they miss
    /// it, rad.
    pub fn branches(&self, tool: &Vec3) -> Result<[Branch; 2], f64> {
        Ok(self.inner_angles(tool)?.map(|inner| (self.outer_angle(tool, inner), inner)))
    }

    /// The inner angles of the two solutions. Error: the angle by which they miss the direction,
    /// rad.
    pub fn inner_angles(&self, tool: &Vec3) -> Result<[f64; 2], f64> {
        let reached = match angle(&self.outer, tool) {
            angle if self.leaves_free(tool) => (angle / PI).round() * PI,
            angle => angle,
        };
        let Self { tool_side, joint_side, nearest, .. } = *self;
        // Negative if the three sides form no triangle. The brackets keep the digits of a small
        // third side.
        let margins = [
            reached + (joint_side - tool_side),
            reached + (tool_side - joint_side),
            tool_side + joint_side - reached,
            2.0 * PI - tool_side - joint_side - reached,
        ];
        let miss = -margins.iter().fold(f64::INFINITY, |least, margin| least.min(*margin));
        if miss > REACH_RAD {
            return Err(miss);
        }
        let [a, b, c, d] = margins.map(|margin| (0.5 * margin).max(0.0).sin());
        let corner = 2.0 * (a * b).max(0.0).sqrt().atan2((c * d).max(0.0).sqrt());
        Ok([nearest + corner, nearest - corner])
    }

    /// The outer angle that belongs to an inner angle, rad. `None` if it is free.
    pub fn outer_angle(&self, tool: &Vec3, inner_angle: f64) -> Option<f64> {
        let before = turned(&self.inner, inner_angle.sin_cos(), &Vec3::z());
        (!self.leaves_free(tool)).then(|| turn(&self.outer, &before, tool))
    }

    /// Whether the tool is parallel to the outer joint.
    fn leaves_free(&self, tool: &Vec3) -> bool {
        self.outer.cross(tool).norm() < POLE_RAD
    }
}

/// `angle` plus the number of whole turns that brings it nearest to `near` within `travel`, rad.
/// `None` if there is none.
pub(super) fn unwound(angle: f64, near: f64, travel: Option<[f64; 2]>) -> Option<f64> {
    let turns = ((near - angle) / (2.0 * PI)).round();
    let turns = match travel {
        None => turns,
        Some([low, high]) => {
            let least = ((low - REACH_RAD - angle) / (2.0 * PI)).ceil();
            let most = ((high + REACH_RAD - angle) / (2.0 * PI)).floor();
            if least > most {
                return None;
            }
            turns.clamp(least, most)
        }
    };
    Some(angle + turns * (2.0 * PI))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_tilts_keep_their_digits() {
        for tilt in [1e-3, 1e-6, 1e-9, 1e-11] {
            let tool = Vec3::new(0.6 * f64::sin(tilt), 0.8 * f64::sin(tilt), f64::cos(tilt));
            let [(c, b), _] = TwoJoints::new(Vec3::z(), Vec3::y()).branches(&tool).unwrap();
            assert!((b - tilt).abs() < 1e-15 * tilt + 1e-25, "{tilt}: {b}");
            assert!((c.unwrap() - 0.8_f64.atan2(0.6)).abs() < 1e-15);
        }
    }

    #[test]
    fn a_nutating_head_reaches_as_far_as_its_cone() {
        // A joint at 45° below a rotary one reaches from upright to level and no further.
        let inner = Vec3::new(0.0, 1.0, 1.0).normalize();
        let head = TwoJoints::new(Vec3::z(), inner);
        let level = head.branches(&Vec3::x()).unwrap();
        assert!((level[0].1.abs() - PI).abs() < 1e-7);
        let miss = head.branches(&Vec3::new(0.1_f64.cos(), 0.0, -0.1_f64.sin())).unwrap_err();
        assert!((miss - 0.1).abs() < 1e-12);
        assert_eq!(head.branches(&Vec3::z()).unwrap()[0].0, None);
    }

    #[test]
    fn whole_turns_follow_travel_first_then_nearness() {
        assert_eq!(unwound(0.5, 4.0 * PI + 1.0, None), Some(0.5 + 4.0 * PI));
        assert_eq!(unwound(0.5, 4.0 * PI, Some([-PI, PI])), Some(0.5));
        assert_eq!(unwound(0.5, 0.0, Some([1.0, 6.0])), None);
        assert_eq!(unwound(-0.5, 0.0, Some([1.0, 6.0])), Some(2.0 * PI - 0.5));
    }
}
