//! The desired path, sampled in time.

use std::sync::Arc;

use rayon::prelude::*;

use crate::{Curve, Kinematics, MotionError, Pose, SHARE, Trajectory, Vec3};

/// The desired path. It does not change during reference iterations.
#[derive(Debug, Clone)]
pub struct DesiredPath {
    trajectory: Trajectory,
    poses: Vec<Pose>,
    kinematics: Arc<dyn Kinematics>,
    curve: Option<Arc<dyn Curve>>,
}

impl DesiredPath {
    /// The desired path whose axis positions are `trajectory`.
    ///
    /// # Errors
    /// If the axes of the trajectory are not those of the kinematics, in that order.
    pub fn new(trajectory: Trajectory, kinematics: Arc<dyn Kinematics>) -> Result<Self, MotionError> {
        let poses = poses_of(&trajectory, kinematics.as_ref())?;
        Ok(Self { trajectory, poses, kinematics, curve: None })
    }

    /// The same path with the analytic curve that it samples, which allows exact errors.
    #[must_use]
    pub fn with_curve(mut self, curve: Arc<dyn Curve>) -> Self {
        self.curve = Some(curve);
        self
    }

    /// Axis positions, one sample per period: the reference of an uncompensated run.
    #[must_use]
    pub fn trajectory(&self) -> &Trajectory {
        &self.trajectory
    }

    /// Tool poses in the workpiece frame, one per sample.
    #[must_use]
    pub fn poses(&self) -> &[Pose] {
        &self.poses
    }

    /// Tool tips in the workpiece frame, mm, one per sample.
    #[must_use]
    pub fn tips(&self) -> Vec<Vec3> {
        self.poses.iter().map(|pose| pose.tip).collect()
    }

    /// Tool tips of other axis positions on the same machine, mm, workpiece frame, one per sample.
    ///
    /// # Errors
    /// If the axes are not those of the kinematics, in that order.
    pub fn tips_of(&self, trajectory: &Trajectory) -> Result<Vec<Vec3>, MotionError> {
        Ok(poses_of(trajectory, self.kinematics.as_ref())?.into_iter().map(|pose| pose.tip).collect())
    }

    /// The analytic curve, if known.
    #[must_use]
    pub fn curve(&self) -> Option<&Arc<dyn Curve>> {
        self.curve.as_ref()
    }

    /// Kinematics of the machine.
    #[must_use]
    pub fn kinematics(&self) -> &Arc<dyn Kinematics> {
        &self.kinematics
    }
}

/// Tool poses of axis positions, one per sample.
///
/// # Errors
/// If the axes of the trajectory are not those of the kinematics, in that order.
pub fn poses_of(trajectory: &Trajectory, kinematics: &dyn Kinematics) -> Result<Vec<Pose>, MotionError> {
    if trajectory.axes() != kinematics.axes() {
        return Err(MotionError::Mismatch("the trajectory's axes are not the machine's".into()));
    }
    let buffer = || vec![0.0; trajectory.axes().len()];
    let pose = |joints: &mut Vec<f64>, k| {
        joints.iter_mut().zip(trajectory.at(k)).for_each(|(joint, position)| *joint = position);
        kinematics.forward(joints)
    };
    Ok((0..trajectory.len()).into_par_iter().with_min_len(SHARE).map_init(buffer, pose).collect())
}
