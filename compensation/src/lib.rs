//! Compensation laws and the loop that runs them.
//!
//! All methods use the same loop: run a reference on a machine, measure the error, update the
//! reference by a law. The machine is real, simulated or a learned model; the law is the same for
//! all.

#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr, clippy::exit, clippy::disallowed_methods))]

mod correction_limits;
mod cut_offs;
mod descent;
mod error;
mod filter;
mod law;
pub mod laws;
mod learn;
mod response;

pub use correction_limits::{CorrectionLimits, Held, OVERSHOOT};
pub use cut_offs::{CutOffCandidates, spatial_candidates};
pub use descent::{Descent, Ended, descend};
pub use error::CompensationError;
pub use filter::LowPass;
pub use law::{CompensationLaw, PoseErrors, Shift, move_poses, pose_errors};
pub use learn::{Iteration, Learned, StopRule, Worth, learn, learn_from};
pub use response::ImpulseResponse;
