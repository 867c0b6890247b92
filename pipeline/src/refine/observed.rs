//! A recorded run beside the model's prediction of it.

use datasets::Log;
use machine::Machine;
use models::Bundle;
use motion::Trajectory;

use crate::control::plus;
use crate::error::Result;
use crate::input::Input;
use crate::measure::{Match, match_run, without_approach, without_offset};
use crate::path_time::in_time_of;
use crate::position_terms::machine_for;
use crate::statistics::{Figures, figures_at};

/// A run of a program of the path.
#[derive(Debug)]
pub struct ObservedRun {
    /// Measured contour error, every sample of the path counted once.
    pub figures: Figures,
    /// Commanded positions, in the path's time.
    pub command: Trajectory,
    /// Predicted positions, in the path's time.
    pub predicted: Trajectory,
    /// Error of the model: actual minus predicted position at every sample of the path, one column an axis, mm or rad.
    pub model_error: Vec<Vec<f64>>,
    /// Alignment of the run with the path.
    pub matched: Match,
}

impl ObservedRun {
    /// The run that `log` recorded. The model predicts it from the recorded command.
    ///
    /// # Errors
    /// When the log is not of a run of the path, or does not fit the model.
    pub fn of(input: &Input, log: &Log, model: &Bundle) -> Result<Self> {
        let desired = input.desired();
        desired.trajectory().check_axes(log.axes())?;
        let log = log.with_axes(desired.trajectory().axes())?.resampled(desired.trajectory().period_s())?.0;
        let (log, _) = without_approach(&log, desired)?;
        let matched = match_run(desired, &log.reference)?;
        let log = without_offset(log, &matched)?;
        let mut machine = machine_for(model, input.part())?;
        machine.freeze_flags(&path_in_time_of(desired.trajectory(), &log.reference, &matched)?);
        let predicted = machine.run(&log.reference)?;
        let run = |run: &Trajectory| in_time_of(desired.trajectory(), run, &matched.path_positions);
        let (actual, predicted) = (run(&log.actual)?, run(&predicted)?);
        let differences = actual.columns().iter().zip(predicted.columns());
        Ok(Self {
            figures: figures_at(desired, input.part(), &matched.path_positions, &log.actual)?,
            model_error: differences.map(|(x, p)| x.iter().zip(p).map(|(x, p)| x - p).collect()).collect(),
            command: run(&log.reference)?,
            predicted,
            matched,
        })
    }

    /// Actual positions, in the path's time.
    ///
    /// # Errors
    /// When the columns are not those of the path.
    pub fn actual(&self) -> Result<Trajectory> {
        Ok(plus(&self.predicted, &self.model_error)?)
    }

    /// Contour error that the model predicts for another run of the same program, with this part of its error known.
    ///
    /// # Errors
    /// When the columns are not those of the path.
    pub fn forecast(&self, input: &Input, repeated: &[Vec<f64>]) -> Result<Figures> {
        input.figures(&plus(&self.predicted, repeated)?)
    }
}

/// The path at the positions of the command, one sample for each of the command's. Its directions of motion are those without correction.
fn path_in_time_of(path: &Trajectory, command: &Trajectory, matched: &Match) -> Result<Trajectory> {
    let columns = path.columns().iter();
    let columns = columns.map(|column| matched.path_positions.iter().map(|at| linear(column, *at)).collect());
    Ok(Trajectory::new(path.period_s(), command.axes().to_vec(), columns.collect())?)
}

/// Value at a fractional index. A cubic would turn back beside a standstill.
fn linear(values: &[f64], at: f64) -> f64 {
    let last = values.len().saturating_sub(1);
    let before = (at as usize).min(last);
    values[before] + (values[(before + 1).min(last)] - values[before]) * (at - before as f64)
}
