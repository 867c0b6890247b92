//! What the learning came to.

use compensation::Ended;
use motion::Trajectory;

use super::outside::OutsideRange;
use crate::statistics::Figures;

/// What came out.
#[derive(Debug)]
pub struct Outcome {
    /// The learned reference; the desired path itself where nothing is gained.
    pub reference: Trajectory,
    /// What the model expects of it.
    pub forecast: Trajectory,
    /// Bound of the correction of the tool tip that was kept to, mm.
    pub max_shift: f64,
    /// Predicted figures without compensation.
    pub before: Figures,
    /// Predicted figures of `reference`.
    pub after: Figures,
    /// Updates taken.
    pub updates: usize,
    /// Why learning on the reference ended; `None` for the papers' laws and where the spatial law alone learns.
    pub ended: Option<Ended>,
    /// Whether the model predicts a gain worth having.
    pub gained: bool,
    /// How long the program takes before and after, as the control is expected to plan it, s; `None` where it takes the reference.
    pub cycle_s: Option<(f64, f64)>,
    /// Where the program keeps its feeds because the times of its points would cost too much: how much, as a share of the cycle time.
    pub kept_feeds: Option<f64>,
    /// Where the model is out of its depth: axis, reason, samples.
    pub outside: Vec<OutsideRange>,
}
