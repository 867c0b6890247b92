//! Fitting predictors to logs.

mod error;
pub mod network;
mod recipe;
pub mod stacked;
pub mod staged;

pub use error::TrainingError;
pub use recipe::Recipe;
