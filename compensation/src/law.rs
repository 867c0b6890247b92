//! Compensation laws: the update of a reference after a run.

use std::ops::Range;

use motion::contour::{ContourError, ContourEstimator, axis_turns, orientation_errors, turns};
use motion::{DesiredPath, Kinematics, MotionError, Pose, SHARE, Trajectory, Vec3, poses_of};
use rayon::prelude::*;

use crate::CompensationError;

/// Updates a reference after a run.
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

/// Error or shift of a pose, in the workpiece frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shift {
    /// Of the tip, mm.
    pub tip: Vec3,
    /// Of the tool's unit vector.
    pub tool: Vec3,
}

impl Shift {
    /// The shift, scaled.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        Self { tip: self.tip * factor, tool: self.tool * factor }
    }

    /// Interpolates from this shift to another.
    #[must_use]
    pub fn lerp(self, other: Self, share: f64) -> Self {
        Self { tip: self.tip.lerp(&other.tip, share), tool: self.tool.lerp(&other.tool, share) }
    }
}

/// Errors of a run, one entry per desired sample.
#[derive(Debug, Clone)]
pub struct PoseErrors {
    /// Contour errors of the tip.
    pub contour: Vec<ContourError>,
    /// Of tip and tool axis together.
    pub shifts: Vec<Shift>,
    /// Poses of the run.
    pub actual: Vec<Pose>,
}

/// Contour error of tip and tool axis at every desired sample, desired − actual at the foot point (Papers A-D; Paper C, eq. 1-4), with the
/// poses of the run. While rotary axes turn about a tip that hardly moves, the tip's error is that at the same instant: its foot point would be where the run
/// passes before or after the turn.
///
/// # Errors
/// When the run's axes are not the path's, or a position is not finite.
pub fn pose_errors(
    desired: &DesiredPath,
    actual: &Trajectory,
    estimator: &mut dyn ContourEstimator,
) -> Result<PoseErrors, CompensationError> {
    let actual = poses_of(actual, desired.kinematics().as_ref())?;
    let tips: Vec<Vec3> = actual.iter().map(|pose| pose.tip).collect();
    let contour = estimator.estimate(&desired.tips(), &tips)?;
    let still = |error: &ContourError| Shift { tip: error.vector, tool: Vec3::zeros() };
    let mut shifts: Vec<Shift> = contour.iter().map(still).collect();
    if desired.kinematics().has_rotary_axes() {
        for (shift, error) in shifts.iter_mut().zip(orientation_errors(&contour, desired.poses(), &actual)) {
            shift.tool = error.vector;
        }
        correct_turns(desired, &actual, &mut shifts);
    }
    Ok(PoseErrors { contour, shifts, actual })
}

/// In turns about a tip that hardly moves, the error of the tip becomes that at the same instant, and that of the direction what is across the turn: along it
/// the tool is late, not wrong, and what is corrected there adds up to a turn beyond its end.
fn correct_turns(desired: &DesiredPath, actual: &[Pose], shifts: &mut [Shift]) {
    let poses = desired.poses();
    let stands =
        |turn: &Range<usize>| poses[turn.clone()].iter().all(|pose| (pose.tip - poses[turn.start].tip).norm() <= STANDS_MM);
    let upright = axis_turns(desired).into_iter().filter(stands);
    // By degrees, from a twentieth of the turn's way on, less was learned: 0.56 for 0.23 µm on a surface with one turn.
    for turn in turns(poses).into_iter().chain(upright) {
        // A run may end before its path does.
        for k in turn.start..turn.end.min(actual.len()).min(shifts.len()) {
            shifts[k].tip = poses[k].tip - actual[k].tip;
            let along = poses[(k + 1).min(turn.end - 1)].tool - poses[k.saturating_sub(1).max(turn.start)].tool;
            if let Some(along) = along.try_normalize(STILL) {
                shifts[k].tool -= along * along.dot(&shifts[k].tool);
            }
        }
    }
}

/// Way of a tip that stands while the table turns about an upright tool, mm.
const STANDS_MM: f64 = 0.05;
/// Change of the tool axis from one sample to the next but one below which it does not turn.
const STILL: f64 = 1e-9;
/// Lean of the tool from a pole below which its correction is tapered, rad: there a rotary axis
/// moves far for a small correction.
const POLE_RAD: f64 = 0.002;

/// `reference` with its poses moved by `shifts`, one per sample, transformed to axis positions.
///
/// # Errors
/// When a moved pose cannot be reached.
pub fn move_poses(desired: &DesiredPath, reference: &Trajectory, shifts: &[Shift]) -> Result<Trajectory, CompensationError> {
    let parts = shifts.par_chunks(SHARE).enumerate();
    let parts = parts.map(|(part, shifts)| move_part(desired.kinematics().as_ref(), reference, part * SHARE, shifts));
    let mut columns: Vec<Vec<f64>> = vec![Vec::with_capacity(reference.len()); reference.axes().len()];
    for part in parts.collect::<Vec<_>>() {
        columns.iter_mut().zip(part?).for_each(|(column, positions)| column.extend(positions));
    }
    Ok(reference.with_columns(columns)?)
}

/// The axis positions of the samples from `first` on, moved by `shifts`.
fn move_part(
    kinematics: &dyn Kinematics,
    reference: &Trajectory,
    first: usize,
    shifts: &[Shift],
) -> Result<Vec<Vec<f64>>, MotionError> {
    let mut columns: Vec<Vec<f64>> = vec![Vec::with_capacity(shifts.len()); reference.axes().len()];
    let mut joints = vec![0.0; columns.len()];
    for (k, shift) in shifts.iter().enumerate() {
        for (joint, position) in joints.iter_mut().zip(reference.at(first + k)) {
            *joint = position;
        }
        let mut pose = kinematics.forward(&joints);
        pose.tip += shift.tip;
        if shift.tool != Vec3::zeros() {
            let lean = kinematics.pole_distance_rad(&pose.tool).map_or(f64::INFINITY, |lean| lean / POLE_RAD);
            let kept = if lean.is_finite() { lean * lean / (1.0 + lean * lean) } else { 1.0 };
            pose.tool = (pose.tool + shift.tool * kept).try_normalize(0.0).unwrap_or(pose.tool);
        }
        kinematics.reach(&pose, &mut joints)?;
        for (column, position) in columns.iter_mut().zip(&joints) {
            column.push(*position);
        }
    }
    Ok(columns)
}
