//! Motion: curves, feed planning, sampled trajectories, kinematics and contour error.
//!
//! Lengths are mm, times s, angles rad. A [`Pose`] is a tool tip *and* a tool axis. A
//! [`Trajectory`] holds the positions of any number of machine axes. [`Kinematics`] converts
//! between them.

#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr, clippy::exit, clippy::disallowed_methods))]

mod axis;
pub mod contour;
pub mod curves;
mod error;
mod interpolate;
mod kinematics;
mod lag;
mod limits;
mod path;
pub mod planner;
mod pose;
mod quantile;
mod share;
mod trajectory;

pub use axis::{Axis, AxisKind};
pub use curves::Curve;
pub use error::MotionError;
pub use interpolate::{cubic, hermite};
pub use kinematics::{Cartesian, FiveAxis, Kinematics, RotaryJoint, RotaryMount};
pub use lag::lag_s;
pub use limits::{AxisLimits, Limits};
pub use path::{DesiredPath, poses_of};
pub use planner::{
    AxisFilter, Corners, MM_PER_RAD, PathSample, Piece, Plan, PlanSettings, RotaryPath, ToolPath, Turning, plan, plan_curve,
    plan_curve_on,
};
pub use pose::{Pose, Vec3, Vec6};
pub use quantile::quantile;
pub use share::SHARE;
pub use trajectory::Trajectory;
