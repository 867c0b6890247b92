//! Speeds and accelerations that the control test is made for.

use motion::{Axis, AxisLimits, Limits};

use super::block::Coordinates;

/// Limits of a machine by program coordinate.
pub(super) struct Bounds<'a> {
    /// Of X, Y, Z, A, B, C.
    axes: [Option<AxisLimits>; 6],
    path: &'a Limits,
    speed_share: f64,
}

/// Limits of a motion, mm or rad.
#[derive(Debug, Clone, Copy)]
pub(super) struct MotionLimits {
    pub velocity: f64,
    acceleration: f64,
    jerk: f64,
    centripetal: f64,
}

impl<'a> Bounds<'a> {
    pub fn of(axes: &[Axis], limits: &'a Limits, speed_share: f64) -> Self {
        let mut by_slot = [None; 6];
        for (axis, limits) in axes.iter().zip(&limits.axes) {
            if let Some(slot) = axis.slot() {
                by_slot[slot] = Some(*limits);
            }
        }
        Self { axes: by_slot, path: limits, speed_share }
    }

    /// Those of X, Y, Z that the machine has.
    pub fn linear(&self) -> Vec<usize> {
        (0..3).filter(|slot| self.axes[*slot].is_some()).collect()
    }

    /// Those of A, B, C that the machine has.
    pub fn rotary(&self) -> Vec<usize> {
        (3..6).filter(|slot| self.axes[*slot].is_some()).collect()
    }

    /// Limits of a line along a unit vector.
    pub fn along(&self, direction: &Coordinates) -> MotionLimits {
        let moving = (0..6).filter(|slot| direction[*slot] != 0.0);
        self.lowest(moving.map(|slot| (slot, direction[slot].abs())))
    }

    /// Limits that hold in every direction of these axes.
    pub fn within(&self, slots: &[usize]) -> MotionLimits {
        self.lowest(slots.iter().map(|slot| (*slot, 1.0)))
    }

    /// The same for the x-y plane; `None` where the machine lacks an axis of it.
    pub fn in_xy(&self) -> Option<MotionLimits> {
        (self.axes[0].is_some() && self.axes[1].is_some()).then(|| self.within(&[0, 1]))
    }

    /// Lowest limit of axes that take a share of the motion each.
    fn lowest(&self, shares: impl Iterator<Item = (usize, f64)>) -> MotionLimits {
        let free = f64::INFINITY;
        let mut out = MotionLimits { velocity: free, acceleration: free, jerk: free, centripetal: free };
        for (slot, share) in shares {
            if let Some(axis) = self.axes[slot] {
                out.velocity = out.velocity.min(self.speed_share * axis.velocity / share);
                out.acceleration = out.acceleration.min(axis.acceleration / share);
                out.jerk = out.jerk.min(axis.jerk / share);
            }
            if slot < 3 {
                out.velocity = out.velocity.min(self.speed_share * self.path.path_velocity_mm_s);
                out.acceleration = out.acceleration.min(self.path.path_acceleration_mm_s2);
                out.jerk = out.jerk.min(self.path.path_jerk_mm_s3);
                out.centripetal = out.centripetal.min(self.path.centripetal_mm_s2);
            }
        }
        out.centripetal = out.centripetal.min(out.acceleration);
        out
    }
}

impl MotionLimits {
    /// Distance from standstill to standstill that just reaches a share of the speed, and that speed.
    pub fn distance_to_reach(&self, share: f64) -> [f64; 2] {
        let speed = share * self.velocity;
        let reaches_acceleration = speed * self.jerk > self.acceleration.powi(2);
        let change_s = if reaches_acceleration {
            speed / self.acceleration + self.acceleration / self.jerk
        } else {
            2.0 * (speed / self.jerk).sqrt()
        };
        [speed * change_s, speed]
    }

    /// A share of the speed, and the radius at which it meets the centripetal limit.
    pub fn radius_at(&self, share: f64) -> (f64, f64) {
        let speed = share * self.velocity;
        (speed, speed * speed / self.centripetal)
    }
}
