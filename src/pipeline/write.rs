//! A learned reference on its way back to a file.

use anyhow::Result;
use gcode::edit;
use motion::Trajectory;

use super::{Part, RefitSettings, refit, verify};
use crate::output::Refusal;

/// The bytes of `part` with the points of `reference`, read again and checked; and the largest correction of a point, mm.
///
/// # Errors
/// When the program did not pass its check.
pub fn write_program(part: &Part, reference: &Trajectory, settings: &RefitSettings, max_shift_mm: f64) -> Result<(Vec<u8>, f64)> {
    let refitted = refit(part, reference, settings)?;
    let bytes = edit(&part.program, &refitted.edits)?;
    verify(part, &refitted, bytes.clone(), &part.options, max_shift_mm, settings.decimals)
        .map_err(|error| Refusal(format!("the compensated program did not pass its check and was not written: {error:#}")))?;
    Ok((bytes, refitted.largest_shift_mm))
}
