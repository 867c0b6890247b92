//! Position-dependent terms of a model, which are unknown for a program without a work offset.

use machine::Machine;
use models::{Bundle, LearnedMachine};
use motion::Axis;

use crate::error::Result;
use crate::input::Input;
use crate::part::Part;
use crate::statistics::{self, Figures, rms_max};

/// Machine of a model for `part`. Position-dependent terms are left out where the work offset is unknown.
///
/// # Errors
/// When a predictor of the bundle is invalid.
pub fn machine_for(bundle: &Bundle, part: Option<&Part>) -> Result<LearnedMachine> {
    let mut machine = bundle.machine()?;
    if part.is_some_and(|part| !part.placement.known()) {
        machine.leave_out_position();
    }
    Ok(machine)
}

/// Position-dependent terms, evaluated with the part at 0,0,0.
#[derive(Debug)]
pub struct PositionTerms {
    /// RMS of the terms over the path for every axis that has them, mm or rad.
    pub axes: Vec<(Axis, f64)>,
    /// Forecast of the uncompensated path without the terms.
    pub without: Figures,
    /// Forecast of the uncompensated path with the terms.
    pub with: Figures,
}

impl PositionTerms {
    /// Terms that the forecast of `path` leaves out; `None` where the work offset is known or the path has no program.
    ///
    /// # Errors
    /// When the path does not fit the model.
    pub fn of(bundle: &Bundle, path: &Input) -> Result<Option<Self>> {
        let Some(part) = path.part().filter(|part| !part.placement.known()) else { return Ok(None) };
        let reference = path.trajectory();
        let with = bundle.machine()?.run(reference)?;
        let without = machine_for(bundle, Some(part))?.run(reference)?;
        let terms = with.tracking_error(&without)?;
        let axes = reference.axes().iter().cloned().zip(terms.iter().map(|terms| rms_max(terms).0));
        Ok(Some(Self {
            axes: axes.filter(|(_, rms)| *rms > 0.0).collect(),
            without: statistics::figures(path.desired(), Some(part), &without)?,
            with: statistics::figures(path.desired(), Some(part), &with)?,
        }))
    }
}
