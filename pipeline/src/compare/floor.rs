//! Run-to-run repeatability: what no compensation can beat.

use std::sync::Arc;

use machine::Machine;
use motion::{DesiredPath, Trajectory};

use crate::error::{Error, Result};
use crate::part::Part;
use crate::statistics::{Figures, figures};

/// Runs from which the mean path is taken.
const FLOOR_RUNS: usize = 8;

/// Run-to-run repeatability, the expected error of a perfect compensation: contour error of each run against the mean of runs.
///
/// A single run, compensated or not, may lie below it; the spread of these figures says by how much.
///
/// # Errors
/// When the machine does not run the path.
pub(super) fn floor_runs(machine: &mut dyn Machine, desired: &DesiredPath, part: Option<&Part>) -> Result<Vec<Figures>> {
    let reference = desired.trajectory();
    let runs: Vec<Trajectory> = (0..FLOOR_RUNS).map(|_| machine.run(reference)).collect::<Result<_, _>>()?;
    let mean = |axis: usize| -> Vec<f64> {
        (0..reference.len()).map(|k| runs.iter().map(|run| run.columns()[axis][k]).sum::<f64>() / FLOOR_RUNS as f64).collect()
    };
    let mean = reference.with_columns((0..reference.axes().len()).map(mean).collect())?;
    let mean = DesiredPath::new(mean, Arc::clone(desired.kinematics()))?;
    // A run around a mean of n runs that contains it is √((n−1)/n) of one around the true mean.
    let unbias = (FLOOR_RUNS as f64 / (FLOOR_RUNS - 1) as f64).sqrt();
    let of = |run: &Trajectory| -> Result<Figures> {
        let mut floor = figures(&mean, part, run)?;
        floor.tip.rms_mm *= unbias;
        floor.tip.max_mm *= unbias;
        if let Some(orientation) = &mut floor.orientation {
            orientation.rms_rad *= unbias;
            orientation.max_rad *= unbias;
        }
        Ok(floor)
    };
    runs.iter().map(of).collect()
}

/// As the floor of the comparison: every figure the mean over the runs.
///
/// # Errors
/// When the machine does not run the path.
pub fn floor(machine: &mut dyn Machine, desired: &DesiredPath) -> Result<Figures> {
    Figures::mean(&floor_runs(machine, desired, None)?).ok_or(Error::NoRun("the floor"))
}
