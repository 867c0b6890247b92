//! Floor: run-to-run repeatability, the expected error of a perfect compensation.

use std::sync::Arc;

use machine::Machine;
use motion::{DesiredPath, Trajectory};

use crate::error::{Error, Result};
use crate::part::Part;
use crate::statistics::{Figures, figures};

/// Number of runs for the mean path.
const FLOOR_RUNS: usize = 8;

/// Floor: contour error of each of several runs against their mean path, the expected error of a perfect compensation.
///
/// A single run may lie below the floor; the spread of these figures shows by how much.
///
/// # Errors
/// When the machine cannot run the path.
pub(super) fn floor_runs(machine: &mut dyn Machine, desired: &DesiredPath, part: Option<&Part>) -> Result<Vec<Figures>> {
    let reference = desired.trajectory();
    let runs: Vec<Trajectory> = (0..FLOOR_RUNS).map(|_| machine.run(reference)).collect::<Result<_, _>>()?;
    let mean = |axis: usize| -> Vec<f64> {
        (0..reference.len()).map(|k| runs.iter().map(|run| run.columns()[axis][k]).sum::<f64>() / FLOOR_RUNS as f64).collect()
    };
    let mean = reference.with_columns((0..reference.axes().len()).map(mean).collect())?;
    let mean = DesiredPath::new(mean, Arc::clone(desired.kinematics()))?;
    // The deviation from a mean of n runs that includes the run is √((n−1)/n) of the deviation from the true mean.
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

/// Mean over the runs of the floor figures.
///
/// # Errors
/// When the machine cannot run the path.
pub fn floor(machine: &mut dyn Machine, desired: &DesiredPath) -> Result<Figures> {
    Figures::mean(&floor_runs(machine, desired, None)?).ok_or(Error::NoRun("the floor"))
}
