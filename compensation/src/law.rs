//! How a reference is moved after a run.

use motion::{DesiredPath, Trajectory, Vec3};

use crate::CompensationError;

/// How a reference is moved after a run.
pub trait CompensationLaw {
    /// Short name, as on the command line.
    fn name(&self) -> &'static str;

    /// The next reference, from the last one and the actual positions of its run; all three sampled at the same instants.
    ///
    /// # Errors
    /// When they do not match, or a moved pose cannot be reached.
    fn update(
        &mut self,
        desired: &DesiredPath,
        reference: &Trajectory,
        actual: &Trajectory,
    ) -> Result<Trajectory, CompensationError>;
}

/// `reference` with its tool tip moved by `shifts` (mm, workpiece frame, one a sample) and its tool axis kept, back on the axes.
///
/// # Errors
/// When a moved pose cannot be reached.
pub fn move_tips(desired: &DesiredPath, reference: &Trajectory, shifts: &[Vec3]) -> Result<Trajectory, CompensationError> {
    let kinematics = desired.kinematics();
    let mut columns: Vec<Vec<f64>> = vec![Vec::with_capacity(reference.len()); reference.axes().len()];
    let mut joints = vec![0.0; columns.len()];
    for (k, shift) in shifts.iter().enumerate() {
        for (joint, position) in joints.iter_mut().zip(reference.at(k)) {
            *joint = position;
        }
        let mut pose = kinematics.forward(&joints);
        pose.tip += shift;
        for (column, position) in columns.iter_mut().zip(kinematics.inverse(&pose, &joints)?) {
            column.push(position);
        }
    }
    Ok(reference.with_columns(columns)?)
}
