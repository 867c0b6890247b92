//! Fitting the staged predictor: least squares in stages, each kept only if held-out runs say that it pays.

mod adapt;
mod backlash;
mod cholesky;
mod corpus;
mod fit;
mod friction_map;
mod gram;
mod linear;
mod lines;
mod operators;
mod recipe;
mod refine;
mod report;
mod search;
mod waves;

pub use crate::AxisRun;
pub use adapt::{AdaptReport, adapt};
pub use fit::fit;
pub use recipe::{LineRecipe, MapRecipe, StagedRecipe};
pub use report::{StageReport, StagedReport};
