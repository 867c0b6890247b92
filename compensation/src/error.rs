//! Errors of learning a reference.

use machine::MachineError;
use motion::MotionError;
use thiserror::Error;

/// Errors of this crate.
#[derive(Debug, Error)]
pub enum CompensationError {
    /// A setting of a law is out of range.
    #[error("{name} is {value}; {remedy}")]
    BadSetting {
        /// Name of the setting.
        name: &'static str,
        /// The value given.
        value: f64,
        /// What it has to be.
        remedy: &'static str,
    },
    /// The machine did not run.
    #[error(transparent)]
    Machine(#[from] MachineError),
    /// A trajectory or pose could not be made.
    #[error(transparent)]
    Motion(#[from] MotionError),
}
