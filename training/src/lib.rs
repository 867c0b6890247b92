//! Fitting predictors to logs.

mod error;
pub mod network;
pub mod stacked;
pub mod staged;

pub use error::TrainingError;
