//! Report of a fit.

use serde::{Deserialize, Serialize};

/// One candidate and its error on held-out blocks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StageReport {
    /// Name of the candidate.
    pub name: String,
    /// Columns of its last pass.
    pub columns: usize,
    /// RMS of the held-out errors, in the unit of the axis.
    pub held_out_rms: f64,
    /// RMS with one speed band left out in turn; `None` if it was not computed.
    pub other_speeds_rms: Option<f64>,
    /// Whether it replaced the simpler candidates.
    pub accepted: bool,
}

/// The candidates and the result of a fit of the staged predictor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StagedReport {
    /// All candidates, simplest first.
    pub stages: Vec<StageReport>,
    /// Name of the chosen candidate.
    pub chosen: String,
    /// Window of the linear law, s before and after the present.
    pub window_s: (f64, f64),
    /// Ridge of the non-linear columns, if there are any.
    pub ridge: Option<f64>,
    /// Spatial frequencies of the position harmonics, 1/unit.
    pub lines: Vec<f64>,
    /// Columns of the last pass.
    pub columns: usize,
    /// Scored samples.
    pub samples: usize,
}

impl StagedReport {
    /// Cross-validated RMS error of the chosen candidate, mm or rad. The choice used the same
    /// folds.
    #[must_use]
    pub fn held_out_rms(&self) -> Option<f64> {
        self.stages.iter().find(|stage| stage.name == self.chosen).map(|stage| stage.held_out_rms)
    }
}
