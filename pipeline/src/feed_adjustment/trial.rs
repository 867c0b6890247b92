//! A program with some feeds: planned, compensated and forecast.

use models::{Bundle, OperatingRange};
use motion::Trajectory;

use crate::error::{Error, Result};
use crate::input::Input;
use crate::model_based_ilc::{Outcome, Settings, model_based_ilc};
use crate::part::Part;
use crate::progress::Progress;
use crate::statistics::{self, contour_errors};

/// A planned and compensated program with its forecast.
pub(super) struct Trial {
    pub input: Input,
    pub outcome: Outcome,
    /// Predicted contour error of every sample, mm; zero where it does not count, as on rapids.
    pub errors_mm: Vec<f64>,
}

impl Trial {
    pub fn of(part: Part, model: &Bundle, settings: &Settings, progress: Progress<'_>) -> Result<Self> {
        let input = Input::from(part);
        let outcome = model_based_ilc(&input, model, settings, progress)?;
        let errors_mm = errors_mm(&input, &outcome)?;
        Ok(Self { input, outcome, errors_mm })
    }

    pub fn part(&self) -> Result<&Part> {
        self.input.program()
    }

    pub fn into_part(self) -> Result<Part> {
        match self.input {
            Input::Program(part) => Ok(*part),
            Input::Path(_) => Err(Error::NoProgram),
        }
    }

    /// Planned duration without the effect of points on the control, s.
    pub fn planned_s(&self) -> f64 {
        self.input.trajectory().duration_s()
    }

    /// Duration of the program as written, s.
    pub fn cycle_s(&self) -> f64 {
        self.outcome.cycle_s.map_or_else(|| self.planned_s(), |(_, after_s)| after_s)
    }

    pub fn max_mm(&self) -> f64 {
        self.errors_mm.iter().copied().fold(0.0, f64::max)
    }

    /// Largest predicted error of every move, mm.
    pub fn worst_mm(&self) -> Result<Vec<f64>> {
        let part = self.part()?;
        let mut worst = vec![0.0_f64; part.toolpath.moves.len()];
        for (k, error) in self.errors_mm.iter().enumerate() {
            if let Some(index) = part.move_at(k) {
                worst[index] = worst[index].max(*error);
            }
        }
        Ok(worst)
    }

    /// Whether each sample is faster than the training data of the model by more than its margin. No forecast holds there.
    pub fn too_fast(&self, ranges: &[OperatingRange]) -> Vec<bool> {
        too_fast(self.input.command(), ranges)
    }
}

/// Predicted contour error of every sample of a program, mm; zero where it does not count.
pub(super) fn errors_mm(input: &Input, outcome: &Outcome) -> Result<Vec<f64>> {
    let part = input.part();
    let errors = contour_errors(input.desired(), &outcome.forecast)?;
    let counted = |(k, error): (usize, &motion::contour::ContourError)| {
        if statistics::counts(part, k) { error.vector.norm() } else { 0.0 }
    };
    Ok(errors.iter().enumerate().map(counted).collect())
}

/// Speed of an axis up to which its model is trusted, as a multiple of that in its training data; as where corrections fade.
const SPEED_MARGIN: f64 = 1.1;

fn too_fast(command: &Trajectory, ranges: &[OperatingRange]) -> Vec<bool> {
    let mut fast = vec![false; command.len()];
    for (column, range) in command.columns().iter().zip(ranges) {
        let most = SPEED_MARGIN * range.velocity * command.period_s();
        for (k, pair) in column.windows(2).enumerate() {
            fast[k] |= (pair[1] - pair[0]).abs() > most;
        }
    }
    fast
}
