//! What a fit says about itself.

use serde::{Deserialize, Serialize};

/// One candidate and how it did on the blocks that it was not fitted to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StageReport {
    /// Name of the candidate.
    pub name: String,
    /// Columns of its last pass.
    pub columns: usize,
    /// Root mean square of the held-out errors, in the axis's unit.
    pub held_out_rms: f64,
    /// The same with one band of speeds left out in turn, where that was looked at.
    pub other_speeds_rms: Option<f64>,
    /// Whether it beat the simpler ones and became the model.
    pub accepted: bool,
}

/// How a staged predictor came about.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StagedReport {
    /// Every candidate, simplest first.
    pub stages: Vec<StageReport>,
    /// Name of the candidate that was taken.
    pub chosen: String,
    /// Window of the linear law, s before and after the present.
    pub window_s: (f64, f64),
    /// Ridge of the non-linear columns, where there are any.
    pub ridge: Option<f64>,
    /// Spatial frequencies of the position lines, 1/unit.
    pub lines: Vec<f64>,
    /// Columns of the last pass.
    pub columns: usize,
    /// Scored samples.
    pub samples: usize,
}

impl StagedReport {
    /// Root mean square that the candidate that was taken leaves on the folds that it was not fitted to, mm or rad. It was chosen by them.
    #[must_use]
    pub fn held_out_rms(&self) -> Option<f64> {
        self.stages.iter().find(|stage| stage.name == self.chosen).map(|stage| stage.held_out_rms)
    }
}
