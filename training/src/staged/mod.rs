//! Fits the grey-box cascade: least squares in stages, each kept only if it lowers the error on
//! held-out runs.

mod adapt;
mod backlash;
mod cholesky;
mod dataset;
mod fit;
mod friction_map;
mod gram;
mod harmonics;
mod linear;
mod operators;
mod recipe;
mod refine;
mod report;
mod search;
mod servo_fit;
mod spectrum;

pub use crate::AxisRun;
pub use adapt::{AdaptReport, adapt};
pub use fit::{fit, fit_on};
pub use recipe::{HarmonicRecipe, MapRecipe, StagedRecipe};
pub use report::{StageReport, StagedReport};
pub use servo_fit::{ServoFit, fit_best};
