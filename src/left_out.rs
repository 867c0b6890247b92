//! What a forecast lacks of a program whose work offset is not known.

use anyhow::Result;
use machine::Machine;
use models::{Bundle, LearnedMachine};
use motion::Axis;
use serde_json::{Map, Value, json};

use crate::evaluate::{self, Figures, rms_max};
use crate::input::Input;
use crate::output::um;
use crate::pipeline::Part;
use crate::units::ErrorUnit;

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
pub struct LeftOut {
    /// Every axis that has such terms, with their root mean square over the path, mm or rad.
    axes: Vec<(Axis, f64)>,
    /// Forecast of the uncompensated path without them.
    without: Figures,
    /// And with them.
    with: Figures,
}

impl LeftOut {
    /// What is left out of the forecast of `path`; `None` where its place is known.
    ///
    /// # Errors
    /// When the path does not fit the model.
    pub fn of(bundle: &Bundle, path: &Input) -> Result<Option<Self>> {
        let Some(part) = path.part.as_ref().filter(|part| !part.placement.known()) else { return Ok(None) };
        let reference = path.desired.trajectory();
        let with = bundle.machine()?.run(reference)?;
        let without = machine_for(bundle, Some(part))?.run(reference)?;
        let terms = with.tracking_error(&without)?;
        let axes = reference.axes().iter().cloned().zip(terms.iter().map(|terms| rms_max(terms).0));
        Ok(Some(Self {
            axes: axes.filter(|(_, rms)| *rms > 0.0).collect(),
            without: evaluate::figures(&path.desired, Some(part), &without)?,
            with: evaluate::figures(&path.desired, Some(part), &with)?,
        }))
    }

    /// What it costs, in words; `None` where the model has no such terms.
    #[must_use]
    pub fn in_words(&self) -> Option<String> {
        let axes: Vec<String> =
            self.axes.iter().map(|(axis, rms)| format!("{axis} {}", ErrorUnit::from(axis).text(*rms))).collect();
        (!axes.is_empty()).then(|| {
            format!(
                "note: the work offset is not known: terms that depend on position (screw pitch, ripple, friction along the axis) are left out. With the \
                 part at 0,0,0 they would be {} RMS, and the uncompensated forecast {} instead of {} µm RMS. Give --work-offset X,Y,Z",
                axes.join(", "),
                um(self.with.tip.rms_mm),
                um(self.without.tip.rms_mm)
            )
        })
    }

    /// The figures as JSON.
    #[must_use]
    pub fn json(&self) -> Value {
        let axes: Map<String, Value> = self
            .axes
            .iter()
            .map(|(axis, rms)| {
                let unit = ErrorUnit::from(axis);
                (axis.name.clone(), json!({ unit.key("rms"): unit.value(*rms) }))
            })
            .collect();
        json!({
            "axes": axes,
            "contour_um_without": evaluate::contour_json(&self.without.tip),
            "contour_um_at_zero": evaluate::contour_json(&self.with.tip),
        })
    }
}
