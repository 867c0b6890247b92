//! Compensation laws and the loop that runs them.
//!
//! Every method is the same loop: run a reference on a machine, measure the error, let a law move the reference. The machine is a
//! real one, a simulated one, or a learned model of one; a law never knows which.

#![deny(clippy::print_stdout, clippy::print_stderr, clippy::exit, clippy::disallowed_methods)]

mod descent;
mod error;
mod filter;
mod guard;
mod law;
pub mod laws;
mod learn;
mod response;

pub use descent::{Descent, Ended, Ladder, descend, spatial_ladder};
pub use error::CompensationError;
pub use filter::LowPass;
pub use guard::Guard;
pub use law::{CompensationLaw, PoseErrors, Shift, move_poses, pose_errors};
pub use learn::{Learned, Round, StopRule, learn};
pub use response::ImpulseResponse;
