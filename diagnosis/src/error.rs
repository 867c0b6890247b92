//! Errors of this crate.

use motion::MotionError;
use thiserror::Error;

/// Errors of this crate.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum DiagnosisError {
    /// No log is given.
    #[error("there is no log; give at least one log of commanded and actual positions")]
    NoLog,
    /// A log has other axes than the first one.
    #[error("{name}: {source}; diagnose logs of the same axes together")]
    Mismatch {
        /// Name of the log.
        name: String,
        /// The difference.
        source: MotionError,
    },
    /// A log has another period than the first one.
    #[error("{name} is sampled every {} ms, the first log every {} ms; record all logs at one rate", own_s * 1e3, first_s * 1e3)]
    Periods {
        /// Name of the log.
        name: String,
        /// Its period, s.
        own_s: f64,
        /// Period of the first log, s.
        first_s: f64,
    },
    /// No axis moves.
    #[error("no axis moves for {shortest_s} s in all; record a run that moves (`precomp excite` writes programs for it)")]
    NoMotion {
        /// Shortest motion that is analysed, s.
        shortest_s: f64,
    },
    /// The model of an axis does not follow its log.
    #[error("axis {axis}: no servo model follows the log; check columns and units with `precomp measure`")]
    NoFit {
        /// Name of the axis.
        axis: String,
    },
}
