//! Pre-compensation in one shot (Paper D, section IV).

use motion::contour::{ContourError, ContourEstimator, SplineSearch};
use motion::{DesiredPath, Trajectory, Vec3};

use crate::{CompensationError, CompensationLaw, move_tips};

/// `P_new = P_k + η (P_k − R_k)`, with `R_k` the point of the predicted path nearest to `P_k` (Paper D, eq. 21-24).
pub struct OneShot {
    /// Share of the contour error that is taken off, 1 in the paper.
    pub eta: f64,
    estimator: SplineSearch,
}

impl Default for OneShot {
    fn default() -> Self {
        Self { eta: 1.0, estimator: SplineSearch::default() }
    }
}

impl CompensationLaw for OneShot {
    fn name(&self) -> &'static str {
        "one-shot"
    }

    fn update(
        &mut self,
        desired: &DesiredPath,
        reference: &Trajectory,
        actual: &Trajectory,
    ) -> Result<Trajectory, CompensationError> {
        let actual = desired.tips_of(actual)?;
        let errors = self.estimator.estimate(&desired.tips(), &actual)?;
        let shifts: Vec<Vec3> = errors.iter().map(|error| across(error) * self.eta).collect();
        move_tips(desired, reference, &shifts)
    }
}

/// The error without what lies along the path: the search takes one of ten points between samples, and the way to the next of them,
/// micrometres at speed, would jerk the reference to and fro.
fn across(error: &ContourError) -> Vec3 {
    error.vector - error.tangent * error.tangent.dot(&error.vector)
}
