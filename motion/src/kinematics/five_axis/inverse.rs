//! Selection of the inverse solution.

use super::super::orientation::{Branch, REACH_RAD, angle, one_joint, unwound};
use super::chain::Link;
use super::{Angles, FiveAxis};
use crate::{MotionError, Vec3};

impl FiveAxis {
    pub(super) fn beyond_travel(&self, axis: usize, angle_rad: f64) -> MotionError {
        let name = &self.axes[axis].name;
        let [low, high] = self.travel[axis].unwrap_or([f64::NEG_INFINITY, f64::INFINITY]).map(f64::to_degrees);
        let angle = angle_rad.to_degrees();
        MotionError::Unreachable(format!(
            "axis `{name}` would stand at {angle:.3}°, outside its travel from {low:.3}° to {high:.3}°"
        ))
    }

    fn unreached(&self, tool: &Vec3, miss_rad: f64) -> MotionError {
        let names: Vec<String> = self.chain.iter().map(|link| format!("`{}`", self.axes[link.axis].name)).collect();
        let who = match names.as_slice() {
            [] => "a machine without rotary axes misses".to_string(),
            [only] => format!("axis {only} alone misses"),
            _ => format!("axes {} miss", names.join(" and ")),
        };
        let (x, y, z, miss) = (tool.x, tool.y, tool.z, miss_rad.to_degrees());
        MotionError::Unreachable(format!("{who} the tool axis ({x:.6}, {y:.6}, {z:.6}) by {miss:.6}°"))
    }

    /// Angle of `link` with any number of whole turns added to `angle_rad`, within travel. `near`
    /// if the angle is free.
    fn settled(&self, link: &Link, angle_rad: Option<f64>, near: &[f64]) -> Result<f64, MotionError> {
        let (near, travel) = (near[link.axis], self.travel[link.axis]);
        match (angle_rad, travel) {
            (None, None) => Ok(near),
            (None, Some([low, high])) => Ok(near.clamp(low, high)),
            (Some(angle), _) => unwound(angle, near, travel).ok_or_else(|| {
                let angle = unwound(angle, near, None).unwrap_or(angle);
                self.beyond_travel(link.axis, angle)
            }),
        }
    }

    /// The solution for `tool` with the smallest move of the inner joint. `None` if the inner joint
    /// does not decide.
    pub(super) fn direct_solution(&self, tool: &Vec3, near: &[f64]) -> Option<Angles> {
        let (Some(pair), [outer, inner]) = (&self.pair, self.chain.as_slice()) else { return None };
        let move_of = |link: &Link, angle: f64| (angle - near[link.axis]).abs();
        let mut candidates = pair.inner_angles(tool).ok()?.map(|angle| {
            let settled = unwound(angle, near[inner.axis], self.travel[inner.axis]);
            (angle, settled, settled.map_or(f64::INFINITY, |angle| move_of(inner, angle)))
        });
        if candidates[1].2 < candidates[0].2 {
            candidates.swap(0, 1);
        }
        let [(angle, settled, inner_move), (.., others_move)] = candidates;
        let outer_angle = unwound(pair.outer_angle(tool, angle)?, near[outer.axis], self.travel[outer.axis])?;
        let longest = inner_move.max(move_of(outer, outer_angle));
        (longest + REACH_RAD < others_move).then_some([outer_angle, settled?])
    }

    /// Joint angles for `tool`: the nearest solution within travel, and the other one if it exists.
    pub(super) fn solutions(&self, tool: &Vec3, near: &[f64]) -> Result<(Angles, Option<Angles>), MotionError> {
        let missed = |miss| self.unreached(tool, miss);
        match (&self.pair, self.chain.as_slice()) {
            (Some(pair), [outer, inner]) => {
                let branches = pair.branches(tool).map_err(missed)?;
                let settled = |(outer_angle, inner_angle): Branch| -> Result<Angles, MotionError> {
                    Ok([self.settled(outer, outer_angle, near)?, self.settled(inner, Some(inner_angle), near)?])
                };
                let moves = |[a, b]: &Angles| [(a - near[outer.axis]).abs(), (b - near[inner.axis]).abs()];
                match branches.map(settled) {
                    [Ok(first), Ok(second)] if nearer(moves(&second), moves(&first)) => Ok((second, Some(first))),
                    [Ok(first), Ok(second)] => Ok((first, Some(second))),
                    [Ok(only), Err(_)] | [Err(_), Ok(only)] => Ok((only, None)),
                    [Err(error), Err(_)] => Err(error),
                }
            }
            (_, [joint]) => {
                let angle = self.settled(joint, one_joint(&joint.direction, tool).map_err(missed)?, near)?;
                Ok(([angle, 0.0], None))
            }
            _ => match angle(tool, &Vec3::z()) {
                miss if miss > REACH_RAD => Err(missed(miss)),
                _ => Ok((Angles::default(), None)),
            },
        }
    }
}

/// Whether the moves `a` of two axes, rad, are smaller: by the larger of both, then by their sum.
/// Rounding does not decide.
fn nearer(a: [f64; 2], b: [f64; 2]) -> bool {
    let ([a_longest, b_longest], [a_sum, b_sum]) = ([a, b].map(|m| m[0].max(m[1])), [a, b].map(|m| m[0] + m[1]));
    if (a_longest - b_longest).abs() > REACH_RAD { a_longest < b_longest } else { a_sum < b_sum - REACH_RAD }
}
