//! A recorded run in the time of the path.

use datasets::Log;
use motion::Trajectory;

use crate::error::Result;
use crate::input::Input;
use crate::measure::{Match, match_run, without_approach, without_offset};
use crate::path_time::in_time_of;
use crate::statistics::{Figures, figures_at};

/// A recorded run, laid over the path.
#[derive(Debug)]
pub struct Aligned {
    /// Commanded positions, in the path's time.
    pub command: Trajectory,
    /// Actual positions, in the path's time.
    pub actual: Trajectory,
    /// Measured error, every sample of the path counted once.
    pub figures: Figures,
    /// Alignment with the path.
    pub matched: Match,
}

impl Aligned {
    /// The run that `log` recorded.
    ///
    /// # Errors
    /// When the log is not of a run of the path.
    pub fn of(input: &Input, log: &Log) -> Result<Self> {
        let desired = input.desired();
        desired.trajectory().check_axes(log.axes())?;
        let log = log.with_axes(desired.trajectory().axes())?.resampled(desired.trajectory().period_s())?.0;
        let (log, _) = without_approach(&log, desired)?;
        let matched = match_run(desired, &log.reference)?;
        let log = without_offset(log, &matched)?;
        let in_path_time = |run: &Trajectory| in_time_of(desired.trajectory(), run, &matched.path_positions);
        Ok(Self {
            command: in_path_time(&log.reference)?,
            actual: in_path_time(&log.actual)?,
            figures: figures_at(desired, input.part(), &matched.path_positions, &log.actual)?,
            matched,
        })
    }
}
