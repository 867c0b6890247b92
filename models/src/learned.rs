//! A model in place of a machine.

use machine::{Machine, MachineError};
use motion::{Axis, AxisKind, Trajectory};
use rayon::prelude::*;

use crate::{AxisPredictor, AxisSignal, ModelError};

/// Largest plausible tracking error, mm or rad: a metre. The supervision of a drive stops it long before.
const LARGEST_ERROR: f64 = 1e3;

/// A machine whose axes are predicted: `actual = reference − predicted tracking error`.
#[derive(Debug)]
pub struct LearnedMachine {
    period_s: f64,
    axes: Vec<Axis>,
    predictors: Vec<Box<dyn AxisPredictor>>,
    desired: Option<Trajectory>,
    /// Whether the positions of the linear axes are in machine coordinates.
    placed: bool,
}

impl LearnedMachine {
    /// The machine with one predictor per axis.
    ///
    /// # Errors
    /// When the number of predictors is not the number of axes.
    pub fn new(period_s: f64, axes: Vec<Axis>, predictors: Vec<Box<dyn AxisPredictor>>) -> Result<Self, ModelError> {
        if axes.len() != predictors.len() || axes.is_empty() {
            return Err(ModelError::Misfit(format!("{} predictors for {} axes", predictors.len(), axes.len())));
        }
        Ok(Self { period_s, axes, predictors, desired: None, placed: true })
    }

    /// Takes the reversal and start flags of all following runs from `desired`, so that small
    /// shifts near a standstill do not toggle them.
    pub fn freeze_flags(&mut self, desired: &Trajectory) {
        self.desired = Some(desired.clone());
    }

    /// The linear axes of all following runs have an unknown work offset: position-dependent terms
    /// are left out.
    pub fn leave_out_position(&mut self) {
        self.placed = false;
    }

    /// Whether the positions of the axis with this index are in machine coordinates. A work offset
    /// does not apply to rotary axes.
    #[must_use]
    pub fn is_placed(&self, axis: usize) -> bool {
        self.placed || self.axes.get(axis).is_some_and(|axis| axis.kind == AxisKind::Rotary)
    }

    /// The axes, in order.
    #[must_use]
    pub fn axes(&self) -> &[Axis] {
        &self.axes
    }

    /// Sampling period, s.
    #[must_use]
    pub fn period_s(&self) -> f64 {
        self.period_s
    }

    /// The predictors, in axis order.
    #[must_use]
    pub fn predictors(&self) -> &[Box<dyn AxisPredictor>] {
        &self.predictors
    }

    /// Predicted tracking error of every axis, mm or rad, one value per sample.
    ///
    /// # Errors
    /// When the reference's axes or period are not the model's.
    pub fn tracking_errors(&self, reference: &Trajectory) -> Result<Vec<Vec<f64>>, ModelError> {
        if reference.axes() != self.axes {
            let names = |axes: &[Axis]| axes.iter().map(|a| a.name.as_str()).collect::<Vec<_>>().join(" ");
            return Err(ModelError::Misfit(format!(
                "the model knows the axes {}, the path moves {}",
                names(&self.axes),
                names(reference.axes())
            )));
        }
        if (reference.period_s() / self.period_s - 1.0).abs() > 1e-6 {
            return Err(ModelError::Misfit(format!(
                "the model was trained at a sampling period of {} ms, the path is sampled every {} ms",
                self.period_s * 1e3,
                reference.period_s() * 1e3
            )));
        }
        let desired = match &self.desired {
            Some(desired) if desired.check_matches(reference).is_ok() => Some(desired),
            _ => None,
        };
        let of_axis = |axis: usize| {
            self.predictors[axis].predict(&AxisSignal {
                reference: &reference.columns()[axis],
                desired: desired.map(|desired| desired.columns()[axis].as_slice()),
                period_s: self.period_s,
                placed: self.is_placed(axis),
            })
        };
        let errors: Vec<Vec<f64>> = (0..self.axes.len()).into_par_iter().map(of_axis).collect();
        self.check_errors(&errors)?;
        Ok(errors)
    }

    /// Refuses predictions that no axis can have.
    fn check_errors(&self, errors: &[Vec<f64>]) -> Result<(), ModelError> {
        for (axis, errors) in self.axes.iter().zip(errors) {
            // A value that is no number is not within the bound either.
            if let Some(sample) = errors.iter().position(|error| !(-LARGEST_ERROR..=LARGEST_ERROR).contains(error)) {
                let time_s = sample as f64 * self.period_s;
                return Err(ModelError::Implausible { axis: axis.name.clone(), time_s, error: errors[sample] });
            }
        }
        Ok(())
    }
}

impl Machine for LearnedMachine {
    fn run(&mut self, reference: &Trajectory) -> Result<Trajectory, MachineError> {
        let errors = self.tracking_errors(reference).map_err(|error| MachineError::Misfit(error.to_string()))?;
        let columns =
            reference.columns().iter().zip(errors).map(|(r, e)| r.iter().zip(e).map(|(r, e)| r - e).collect()).collect();
        Ok(reference.with_columns(columns)?)
    }
}
