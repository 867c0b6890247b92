//! Pre-compensation in one shot (Paper D, section IV).

use motion::contour::{ContourError, SplineSearch};
use motion::{DesiredPath, Trajectory, Vec3};

use crate::{CompensationError, CompensationLaw, PoseErrors, Shift, move_poses, pose_errors};

/// `P_new = P_k + η (P_k − R_k)`, with `R_k` the point of the predicted path nearest to `P_k` (Paper D, eq. 21-24); the tool axis likewise.
pub struct OneShot {
    /// Gain on the contour error, 1 in the paper.
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
        let PoseErrors { contour, mut shifts, .. } = pose_errors(desired, actual, &mut self.estimator)?;
        for (shift, error) in shifts.iter_mut().zip(&contour) {
            *shift = Shift { tip: across(error), ..*shift }.times(self.eta);
        }
        move_poses(desired, reference, &shifts)
    }
}

/// The error without its tangential component. The search takes one of ten points between samples;
/// the distance to the next point, micrometres at speed, would make the reference oscillate.
fn across(error: &ContourError) -> Vec3 {
    error.vector - error.tangent * error.tangent.dot(&error.vector)
}
