//! What a control makes of a compensated program: it plans the time of the moved points anew.

use gcode::edit;
use motion::contour::follow;
use motion::{MotionError, Trajectory};

use crate::error::Result;
use crate::measure::in_time_of;
use crate::part::Part;
use crate::refit::{RefitSettings, refit};

/// A program with moved points, planned as it will be read.
#[derive(Debug)]
pub struct Replanned<'a> {
    original: &'a Part,
    /// What the control commands.
    pub command: Trajectory,
    /// For every sample of the command its place on the original's path, as a sample index with fraction; never decreasing.
    pub places: Vec<f64>,
}

impl<'a> Replanned<'a> {
    /// Writes `reference` into `part` and plans the program that comes of it.
    ///
    /// # Errors
    /// When it cannot be written or planned, or leads elsewhere.
    pub fn new(part: &'a Part, reference: &Trajectory, written: &RefitSettings) -> Result<Self> {
        let planned = part.replanned(edit(&part.program, &refit(part, reference, written)?.edits)?)?;
        let command = planned.plan.desired.trajectory().clone();
        let places = follow(&planned.plan.desired.tips(), &part.plan.desired.tips())?;
        Ok(Self { original: part, command, places })
    }

    /// The original's path at the places of the command: its directions of motion are those of the program, without the correction.
    ///
    /// # Errors
    /// As [`Trajectory::new`].
    pub fn path(&self) -> Result<Trajectory, MotionError> {
        let path = self.original.plan.desired.trajectory();
        let at = |column: &Vec<f64>, place: f64| {
            let before = (place as usize).min(column.len() - 1);
            let after = (before + 1).min(column.len() - 1);
            column[before] + (column[after] - column[before]) * (place - before as f64)
        };
        let columns = path.columns().iter().map(|column| self.places.iter().map(|place| at(column, *place)).collect()).collect();
        Trajectory::new(path.period_s(), path.axes().to_vec(), columns)
    }

    /// A run of the command, at the instants at which it passes the samples of the original's path.
    ///
    /// # Errors
    /// When `actual` does not have the command's samples.
    pub fn in_path_time(&self, actual: &Trajectory) -> Result<Trajectory, MotionError> {
        in_time_of(self.original.plan.desired.trajectory(), actual, &self.places)
    }
}
