//! Result of model-based ILC.

use compensation::Ended;
use motion::Trajectory;

use super::outside::OutsideRange;
use crate::statistics::Figures;

/// Result of model-based ILC.
#[derive(Debug)]
pub struct Outcome {
    /// Computed reference; the desired path itself where nothing is gained.
    pub reference: Trajectory,
    /// Predicted actual positions for `reference`.
    pub forecast: Trajectory,
    /// Bound of the correction of the tool tip, mm.
    pub max_shift: f64,
    /// Predicted figures without compensation.
    pub before: Figures,
    /// Predicted figures with `reference`.
    pub after: Figures,
    /// Number of updates.
    pub updates: usize,
    /// Reason why the iteration on the reference ended; `None` for the papers' laws and where no Gauss–Newton steps are
    /// made.
    pub ended: Option<Ended>,
    /// Whether the predicted gain is large enough for the path to be changed.
    pub gained: bool,
    /// Predicted cycle time before and after, s, of a replanned program; `None` where the control takes the reference.
    pub cycle_s: Option<(f64, f64)>,
    /// Relative increase of the cycle time by timed points, where it is too large and the program therefore keeps its
    /// feeds.
    pub kept_feeds: Option<f64>,
    /// Path ranges outside the operating range of the model.
    pub outside: Vec<OutsideRange>,
}
