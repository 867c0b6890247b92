//! Fitting predictors to logs.

#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr, clippy::exit, clippy::disallowed_methods))]

mod error;
pub mod network;
mod recipe;
mod run;
pub mod stacked;
pub mod staged;

pub use error::TrainingError;
pub use recipe::Recipe;
pub use run::AxisRun;
