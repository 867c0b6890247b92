//! Whether an output can be what it is asked to be.

use std::path::Path;

use anyhow::Result;
use pipeline::{Input, OutputFormat, OutputSettings};

use crate::output::Usage;
use crate::read::is_reference;

/// Whether `input` can be written to `out` in this format.
///
/// # Errors
/// Says what `out` or the format has to be.
pub fn check(settings: &OutputSettings, input: &Input, out: &Path) -> Result<()> {
    let wrong = match settings.format {
        OutputFormat::Setpoints(_) if !out.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("csv")) => {
            "setpoints are a table: name OUT with the ending .csv"
        }
        OutputFormat::Program(_) if input.part().is_some() == is_reference(out) => {
            "INPUT and OUT must both be part programs or both be references; a table of setpoints from a program needs --format table or pvt"
        }
        _ => return check_encoding(settings, input),
    };
    Err(Usage(wrong.into()).into())
}

/// Whether the language of a program has this time encoding.
fn check_encoding(settings: &OutputSettings, input: &Input) -> Result<()> {
    if let (Some(written), Some(part)) = (settings.program(), input.part()) {
        written.suited_to(part)?;
    }
    Ok(())
}
