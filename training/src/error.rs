//! Errors of a fit.

use models::ModelError;
use thiserror::Error;

/// Errors of this crate.
#[derive(Debug, Error)]
pub enum TrainingError {
    /// A recipe is invalid.
    #[error("recipe: {0}")]
    Recipe(String),
    /// The runs do not match or contain too little motion.
    #[error("the runs cannot be used for training: {0}")]
    Unusable(String),
    /// The normal equations of a stage have no unique solution.
    #[error("the equations of the stage `{0}` are singular; the log varies too little")]
    Singular(&'static str),
    /// The result is no valid predictor.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A checkpoint is invalid or belongs to another training.
    #[error("the checkpoint cannot be used: {0}")]
    Checkpoint(String),
    /// Reading or writing failed.
    #[error(transparent)]
    Io(#[from] std::io::Error),
}
