//! Fitting predictors to logs.

mod error;
pub mod network;
mod recipe;
mod run;
pub mod stacked;
pub mod staged;

pub use error::TrainingError;
pub use recipe::Recipe;
pub use run::AxisRun;
