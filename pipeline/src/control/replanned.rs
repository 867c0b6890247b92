//! Replanning of a compensated program by a control: a new feed profile for the moved points.

use motion::contour::follow_axes;
use motion::{MotionError, Trajectory};

use super::rerun::rerun;
use crate::error::Result;
use crate::part::Part;
use crate::path_time::{in_time_of, in_time_of_standing, linear};
use crate::refit::{RefitSettings, refit};

/// A program with moved points, planned as the control reads it; of a recorded run with what the control did otherwise.
#[derive(Debug)]
pub struct Replanned<'a> {
    original: &'a Part,
    /// Command of the control.
    pub command: Trajectory,
    /// Path position of every sample of the command on the original path, as a sample index with fraction; never
    /// decreasing.
    pub path_positions: Vec<f64>,
}

impl<'a> Replanned<'a> {
    /// Writes `reference` into `part` and plans the resulting program.
    ///
    /// # Errors
    /// When the program cannot be written or planned, or leaves the path.
    pub fn new(part: &'a Part, reference: &Trajectory, written: &RefitSettings) -> Result<Self> {
        let planned = part.replanned(part.edited(&refit(part, reference, written)?.edits)?)?;
        if let (Some(recording), Some(recorded)) = (&part.recording, &part.command) {
            let shifts = reference.tracking_error(part.plan.desired.trajectory())?;
            let (command, path_positions) = rerun(recorded, recording, &planned, &shifts)?;
            return Ok(Self { original: part, command, path_positions });
        }
        Self::of(part, planned)
    }

    /// A program as `planned`, whose points are near the path of `original`.
    ///
    /// # Errors
    /// When it leaves the path.
    pub fn of(original: &'a Part, planned: Part) -> Result<Self> {
        let path_positions = follow_axes(planned.plan.desired.trajectory(), &original.plan.desired)?;
        let command = planned.command.unwrap_or_else(|| planned.plan.desired.trajectory().clone());
        Ok(Self { original, command, path_positions })
    }

    /// Original path at the positions of the command. Its directions of motion are those of the program without the
    /// correction.
    ///
    /// # Errors
    /// As [`Trajectory::new`].
    pub fn path(&self) -> Result<Trajectory, MotionError> {
        let path = self.original.plan.desired.trajectory();
        let columns = path
            .columns()
            .iter()
            .map(|column| self.path_positions.iter().map(|position| linear(column, *position)).collect())
            .collect();
        Trajectory::new(path.period_s(), path.axes().to_vec(), columns)
    }

    /// A run of the command, resampled to the instants at which it passes the samples of the original path.
    ///
    /// # Errors
    /// When the samples of `actual` are not those of the command.
    pub fn in_path_time(&self, actual: &Trajectory) -> Result<Trajectory, MotionError> {
        in_time_of(self.original.plan.desired.trajectory(), actual, &self.path_positions)
    }

    /// The same with what the axes do at standstills ([`in_time_of_standing`]).
    ///
    /// # Errors
    /// As [`Self::in_path_time`].
    pub fn in_path_time_standing(&self, actual: &Trajectory) -> Result<Trajectory, MotionError> {
        in_time_of_standing(self.original.plan.desired.trajectory(), actual, &self.path_positions)
    }
}
