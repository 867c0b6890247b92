//! Errors of a fit.

use models::ModelError;
use thiserror::Error;

/// Errors of this crate.
#[derive(Debug, Error)]
pub enum TrainingError {
    /// A recipe cannot be used.
    #[error("recipe: {0}")]
    Recipe(String),
    /// The runs do not fit together or say too little.
    #[error("the runs cannot be used for training: {0}")]
    Unusable(String),
    /// The normal equations of a stage have no unique solution.
    #[error("the equations of the stage `{0}` are singular; the log varies too little")]
    Singular(&'static str),
    /// The result is not a sound predictor.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A checkpoint cannot be used.
    #[error("the checkpoint cannot be used: {0}")]
    Checkpoint(String),
    /// Reading or writing failed.
    #[error(transparent)]
    Io(#[from] std::io::Error),
}
