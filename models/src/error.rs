//! Errors of a model.

use thiserror::Error;

/// Errors of this crate.
#[derive(Debug, Error)]
pub enum ModelError {
    /// A saved predictor lacks an array or a setting, or one has the wrong shape.
    #[error("the model's {part} is not usable: {why}; train the model anew")]
    Malformed {
        /// Name of the part.
        part: String,
        /// What is wrong with it.
        why: String,
    },
    /// The input does not fit the model (axes, sampling period, length).
    #[error("the input does not fit the model: {0}")]
    Misfit(String),
    /// A predicted tracking error that no axis can have.
    #[error(
        "at t = {time_s:.3} s the model predicts a tracking error of {error:e} (mm or rad) for axis {axis}; \
         mend the input if it jumps there, else train the model anew"
    )]
    Implausible {
        /// Name of the axis.
        axis: String,
        /// Time since the first sample, s.
        time_s: f64,
        /// The tracking error, mm or rad.
        error: f64,
    },
    /// The bundle's bytes do not match its checksum.
    #[error("the model file is damaged: {0}; copy it again or train anew")]
    Damaged(String),
    /// The bundle was written by a version with another format.
    #[error("the model file has format {found}, this build reads format {expected}; train anew")]
    Format {
        /// Format of the file.
        found: u32,
        /// Format of this build.
        expected: u32,
    },
    /// Reading or writing failed.
    #[error(transparent)]
    Io(#[from] std::io::Error),
}
