//! A learned reference on its way back to a file.

use std::path::Path;

use anyhow::{Context, Result};
use gcode::edit;
use machine::MachineSpec;
use motion::Trajectory;

use super::{Carrier, Part, RefitSettings, refit, verify};
use crate::cli::CarrierArgs;
use crate::output::{Refusal, write_file};

/// Largest distance of a written line from the corrected curve between its ends, mm.
const CHORD_TOLERANCE_MM: f64 = 2e-4;
/// Decimals of coordinates in mm, and time between points, ms, where neither the user nor the machine's profile says: what LinuxCNC needs.
pub(super) const DECIMALS: usize = 6;
const SPACING_MS: f64 = 4.0;

/// Writes `part` with the points of `reference` to `out`, after reading it again and checking it; gives the largest correction of a point, mm.
///
/// # Errors
/// When a setting is out of range, or the program did not pass its check; nothing is written then.
pub fn write_program(
    part: &Part,
    reference: &Trajectory,
    spec: &MachineSpec,
    wanted: &CarrierArgs,
    carrier: Carrier,
    max_shift_mm: f64,
    out: &Path,
) -> Result<f64> {
    let profile = spec.controller;
    let settings = RefitSettings {
        carrier,
        decimals: wanted.decimals.unwrap_or(profile.map_or(DECIMALS, |profile| usize::from(profile.decimals))),
        spacing_s: wanted.spacing.unwrap_or(profile.map_or(SPACING_MS, |profile| profile.point_spacing_ms)) * 1e-3,
        chord_tolerance_mm: CHORD_TOLERANCE_MM,
        path_tolerance_mm: profile.and_then(|profile| profile.path_tolerance_mm),
    };
    let refitted = refit(part, reference, &settings)?;
    let bytes = edit(&part.program, &refitted.edits)?;
    verify(part, &refitted, bytes.clone(), &part.options, max_shift_mm, settings.decimals)
        .map_err(|error| Refusal(format!("the compensated program did not pass its check and was not written: {error:#}")))?;
    write_file(out, &bytes).context("the compensated program")?;
    Ok(refitted.largest_shift_mm)
}
