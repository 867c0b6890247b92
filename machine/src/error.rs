//! Errors of machines and machine files.

use motion::MotionError;
use thiserror::Error;

use crate::FileFaults;

/// Errors of this crate and of every [`crate::Machine`].
#[derive(Debug, Error)]
pub enum MachineError {
    /// Axes or period of the reference differ from those of the machine.
    #[error("the reference does not fit the machine: {0}")]
    Misfit(String),
    /// The description of a machine is invalid.
    #[error("the machine description is not sound: {0}")]
    BadDescription(String),
    /// A machine file or controller profile has faults.
    #[error("{0}")]
    BadFile(FileFaults),
    /// The state of a simulated drive became non-finite.
    #[error(
        "the drive of axis `{axis}` is unstable: its position is no longer finite at {time_s:.3} s; lower its gains or its integration step"
    )]
    Unstable {
        /// Name of the axis.
        axis: String,
        /// Time since the first sample, s.
        time_s: f64,
    },
    /// A trajectory was invalid.
    #[error(transparent)]
    Motion(#[from] MotionError),
}

impl From<FileFaults> for MachineError {
    fn from(faults: FileFaults) -> Self {
        Self::BadFile(faults)
    }
}
