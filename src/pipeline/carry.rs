//! A learned reference on its way to the control: as a program, as rows, or as the reference that it is.

use std::path::Path;

use anyhow::Result;
use clap::ValueEnum;
use clap::builder::PossibleValue;
use datasets::reference_content;
use gcode::Dialect;
use machine::MachineSpec;
use motion::Trajectory;
use serde::Serialize;

use super::refit::DECIMALS;
use super::rows::{RowSettings, Rows, RowsWritten, write_rows};
use super::{Carrier, Part, RefitSettings, write_program};
use crate::cli::CarrierArgs;
use crate::input::{self, Input};
use crate::output::Usage;

/// Time between rows with velocities, ms, where neither the user nor the machine's profile says.
const PVT_MS: f64 = 4.0;

/// What a compensated path is written as.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(untagged)]
pub enum Carried {
    /// The program, with points that carry their time in this way.
    Program(Carrier),
    /// Rows of axis positions.
    Rows(Rows),
}

impl ValueEnum for Carried {
    fn value_variants<'a>() -> &'a [Self] {
        &[
            Self::Program(Carrier::G93),
            Self::Program(Carrier::G94),
            Self::Program(Carrier::Keep),
            Self::Rows(Rows::Table),
            Self::Rows(Rows::Pvt),
        ]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        match self {
            Self::Program(carrier) => carrier.to_possible_value(),
            Self::Rows(rows) => rows.to_possible_value(),
        }
    }
}

impl From<machine::Carrier> for Carried {
    fn from(carrier: machine::Carrier) -> Self {
        match carrier {
            machine::Carrier::G93 => Self::Program(Carrier::G93),
            machine::Carrier::G94 => Self::Program(Carrier::G94),
            machine::Carrier::Keep => Self::Program(Carrier::Keep),
            machine::Carrier::Table => Self::Rows(Rows::Table),
            machine::Carrier::Pvt => Self::Rows(Rows::Pvt),
        }
    }
}

impl Carried {
    /// What `wanted` says, else the profile of the control.
    #[must_use]
    pub fn of(wanted: &CarrierArgs, spec: &MachineSpec) -> Self {
        // Measured with our own planner in the control's place: G93 costs up to 13 % of the cycle time, the program's own feeds nothing.
        let profile = spec.controller.map_or(Self::Program(Carrier::Keep), |profile| profile.carrier.into());
        wanted.carrier.unwrap_or(profile)
    }

    /// How programs are written in this way; `None` for rows.
    #[must_use]
    pub fn program(self, wanted: &CarrierArgs, spec: &MachineSpec) -> Option<RefitSettings> {
        match self {
            Self::Program(carrier) => Some(RefitSettings::of(carrier, wanted, spec)),
            Self::Rows(_) => None,
        }
    }

    /// Tells a part whether its compensated stretches will state a path mode, as LinuxCNC's do.
    pub fn tell(self, part: &mut Part, wanted: &CarrierArgs, spec: &MachineSpec) {
        let stated = self.program(wanted, spec).and_then(|settings| settings.path_tolerance_mm);
        part.states_path = stated.is_some() && part.options.dialect == Dialect::LinuxCnc;
    }

    /// How a program says its time; one beside rows keeps its feeds.
    #[must_use]
    pub fn program_carrier(self) -> Carrier {
        match self {
            Self::Program(carrier) => carrier,
            Self::Rows(_) => Carrier::Keep,
        }
    }

    /// Whether `path` can be written to `out` in this way.
    ///
    /// # Errors
    /// Says what `out` has to be.
    pub fn check(self, path: &Input, out: &Path) -> Result<()> {
        let wrong = match self {
            Self::Rows(_) if !out.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("csv")) => {
                "rows of positions are a table: name OUT with the ending .csv"
            }
            Self::Program(_) if path.part.is_some() == input::is_reference(out) => {
                "INPUT and OUT must both be part programs or both be references; a table of positions from a program needs --carrier table or pvt"
            }
            _ => return Ok(()),
        };
        Err(Usage(wrong.into()).into())
    }
}

/// What is written.
#[derive(Debug, Clone)]
pub struct Written {
    /// The bytes of the file.
    pub content: Vec<u8>,
    /// Largest correction of a point, mm.
    pub largest_shift_mm: f64,
    /// What it was written as; `None` for a reference.
    pub carried: Option<Carried>,
    /// The rows, where it was written as such.
    pub rows: Option<RowsWritten>,
}

/// What `reference`, learned for `path`, is written to `out` as, carried so; spacing and decimals are as `wanted` and the machine's profile say.
///
/// # Errors
/// When a setting is out of range, or what is to be written did not pass its check.
pub fn write_out(
    path: &Input,
    reference: &Trajectory,
    carried: Carried,
    spec: &MachineSpec,
    wanted: &CarrierArgs,
    max_shift_mm: f64,
    out: &Path,
) -> Result<Written> {
    match (carried, &path.part) {
        (Carried::Rows(rows), _) => {
            let profile = spec.controller.filter(|profile| Carried::from(profile.carrier) == carried);
            let usual_ms = match rows {
                Rows::Table => reference.period_s() * 1e3,
                Rows::Pvt => PVT_MS,
            };
            let interval_ms = wanted.spacing.or(profile.map(|profile| profile.point_spacing_ms)).unwrap_or(usual_ms);
            let decimals = wanted.decimals.or(profile.map(|profile| usize::from(profile.decimals))).unwrap_or(DECIMALS);
            let settings = RowSettings { rows, interval_s: interval_ms * 1e-3, decimals };
            let (text, written) = write_rows(path, reference, &settings)?;
            Ok(Written {
                content: text.into(),
                largest_shift_mm: path.largest_shift(reference),
                carried: Some(carried),
                rows: Some(written),
            })
        }
        (Carried::Program(carrier), Some(part)) => {
            let settings = RefitSettings::of(carrier, wanted, spec);
            let (content, largest_shift_mm) = write_program(part, reference, &settings, max_shift_mm)?;
            Ok(Written { content, largest_shift_mm, carried: Some(carried), rows: None })
        }
        (Carried::Program(_), None) => {
            let content = reference_content(out, reference)?;
            Ok(Written { content, largest_shift_mm: path.largest_shift(reference), carried: None, rows: None })
        }
    }
}
