//! What a forecast lacks of a program whose work offset is not known.

use machine::Machine;
use models::{Bundle, LearnedMachine};
use motion::Axis;

use crate::error::Result;
use crate::input::Input;
use crate::part::Part;
use crate::statistics::{self, Figures, rms_max};

/// The machine of a model as it runs `part`: without the terms that depend on position where the work offset is not known.
///
/// # Errors
/// When a predictor of the bundle is not usable.
pub fn machine_for(bundle: &Bundle, part: Option<&Part>) -> Result<LearnedMachine> {
    let mut machine = bundle.machine()?;
    if part.is_some_and(|part| !part.placement.known()) {
        machine.leave_out_position();
    }
    Ok(machine)
}

/// The terms that depend on position, as they would be with the part at 0,0,0.
#[derive(Debug)]
pub struct PositionTerms {
    /// Every axis that has such terms, with their root mean square over the path, mm or rad.
    pub axes: Vec<(Axis, f64)>,
    /// Forecast of the uncompensated path without them.
    pub without: Figures,
    /// And with them.
    pub with: Figures,
}

impl PositionTerms {
    /// What is left out of the forecast of `path`; `None` where its place is known.
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
