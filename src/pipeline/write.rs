//! A learned reference on its way back to a file.

use std::path::Path;

use anyhow::{Context, Result};
use gcode::edit;
use motion::Trajectory;

use super::{Part, RefitSettings, refit, verify};
use crate::output::{Refusal, write_file};

/// Writes `part` with the points of `reference` to `out`, after reading it again and checking it; gives the largest correction of a point, mm.
///
/// # Errors
/// When the program did not pass its check; nothing is written then.
pub fn write_program(
    part: &Part,
    reference: &Trajectory,
    settings: &RefitSettings,
    max_shift_mm: f64,
    out: &Path,
) -> Result<f64> {
    let refitted = refit(part, reference, settings)?;
    let bytes = edit(&part.program, &refitted.edits)?;
    verify(part, &refitted, bytes.clone(), &part.options, max_shift_mm, settings.decimals)
        .map_err(|error| Refusal(format!("the compensated program did not pass its check and was not written: {error:#}")))?;
    write_file(out, &bytes).context("the compensated program")?;
    Ok(refitted.largest_shift_mm)
}
