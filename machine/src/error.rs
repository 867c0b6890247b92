//! What can go wrong with a machine.

use motion::MotionError;
use thiserror::Error;

/// Errors of this crate and of every [`crate::Machine`].
#[derive(Debug, Error)]
pub enum MachineError {
    /// The reference's axes or period are not the machine's.
    #[error("the reference does not fit the machine: {0}")]
    Misfit(String),
    /// The description of a machine is not sound.
    #[error("the machine description is not sound: {0}")]
    BadDescription(String),
    /// A simulated drive did not stay finite.
    #[error(
        "the drive of axis `{axis}` is unstable: its position is no longer finite at {time_s:.3} s; lower its gains or its integration step"
    )]
    Unstable {
        /// Name of the axis.
        axis: String,
        /// Time since the first sample, s.
        time_s: f64,
    },
    /// A trajectory could not be made.
    #[error(transparent)]
    Motion(#[from] MotionError),
}
