//! A learned reference on its way to the control: as a program, as setpoints, or as the reference that it is.

use std::path::Path;

use datasets::reference_content;
use gcode::Dialect;
use machine::ControllerSpec;
use motion::Trajectory;
use serde::Serialize;

use crate::error::Result;
use crate::input::Input;
use crate::part::Part;
use crate::refit::{DECIMALS, RefitSettings, TimeEncoding, write_program};
use crate::setpoints::{SetpointKind, SetpointSettings, SetpointsWritten, write_setpoints};
use crate::setup::Setup;

/// Time between setpoints with velocities, ms, where neither the user nor the machine's profile says.
const PVT_MS: f64 = 4.0;

/// What a compensated path is written as.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(untagged)]
pub enum OutputFormat {
    /// The program, with points that carry their time in this way.
    Program(TimeEncoding),
    /// Setpoints: rows of axis positions.
    Setpoints(SetpointKind),
}

impl From<machine::Carrier> for OutputFormat {
    fn from(carrier: machine::Carrier) -> Self {
        match carrier {
            machine::Carrier::G93 => Self::Program(TimeEncoding::G93),
            machine::Carrier::G94 => Self::Program(TimeEncoding::G94),
            machine::Carrier::Keep => Self::Program(TimeEncoding::Keep),
            machine::Carrier::Table => Self::Setpoints(SetpointKind::Table),
            machine::Carrier::Pvt => Self::Setpoints(SetpointKind::Pvt),
        }
    }
}

impl OutputFormat {
    /// How a program says its time in this format; one beside setpoints keeps its feeds.
    #[must_use]
    pub fn encoding(self) -> TimeEncoding {
        match self {
            Self::Program(encoding) => encoding,
            Self::Setpoints(_) => TimeEncoding::Keep,
        }
    }
}

/// How a compensated path is written: what was asked for, else what the profile of the control says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutputSettings {
    /// What is written.
    pub format: OutputFormat,
    decimals: Option<usize>,
    spacing_ms: Option<f64>,
    controller: Option<ControllerSpec>,
}

impl OutputSettings {
    /// The setup's own way, but for what is given: format, decimals of coordinates in mm, time between points or rows in ms.
    #[must_use]
    pub fn new(setup: &Setup, format: Option<OutputFormat>, decimals: Option<usize>, spacing_ms: Option<f64>) -> Self {
        // Measured with our own planner in the control's place: G93 costs up to 13 % of the cycle time, the program's own feeds nothing.
        let own = setup.controller.map_or(OutputFormat::Program(TimeEncoding::Keep), |profile| profile.carrier.into());
        Self { format: format.unwrap_or(own), decimals, spacing_ms, controller: setup.controller }
    }

    /// How programs are written; `None` where setpoints are.
    #[must_use]
    pub fn program(&self) -> Option<RefitSettings> {
        matches!(self.format, OutputFormat::Program(_)).then(|| self.refit())
    }

    /// How programs are written, beside setpoints too.
    #[must_use]
    pub fn refit(&self) -> RefitSettings {
        RefitSettings::of(self.format.encoding(), self.decimals, self.spacing_ms, self.controller)
    }

    /// Tells a part whether its compensated segments will state a path mode, as LinuxCNC's do.
    pub fn prepare(&self, part: &mut Part) {
        let stated = self.program().and_then(|settings| settings.path_tolerance_mm);
        part.states_path = stated.is_some() && part.options.dialect == Dialect::LinuxCnc;
    }

    /// How setpoints of this kind are written beside a reference with this period, s.
    fn setpoints(&self, kind: SetpointKind, period_s: f64) -> SetpointSettings {
        let profile = self.controller.filter(|profile| OutputFormat::from(profile.carrier) == self.format);
        let usual_ms = match kind {
            SetpointKind::Table => period_s * 1e3,
            SetpointKind::Pvt => PVT_MS,
        };
        let interval_ms = self.spacing_ms.or(profile.map(|profile| profile.point_spacing_ms)).unwrap_or(usual_ms);
        let decimals = self.decimals.or(profile.map(|profile| usize::from(profile.decimals))).unwrap_or(DECIMALS);
        SetpointSettings { kind, interval_s: interval_ms * 1e-3, decimals }
    }
}

/// What is written.
#[derive(Debug, Clone)]
pub struct Output {
    /// The bytes of the file.
    pub content: Vec<u8>,
    /// Largest correction of a point, mm.
    pub largest_shift_mm: f64,
    /// What it was written as; `None` for a reference.
    pub format: Option<OutputFormat>,
    /// The setpoints, where it was written as such.
    pub setpoints: Option<SetpointsWritten>,
}

impl Input {
    /// The bytes of `reference`, learned for this input with corrections of at most `max_shift_mm`. The ending of `name` says in which
    /// format a reference is written, `.csv` or `.parquet`.
    ///
    /// # Errors
    /// When a setting is out of range, or what is to be written did not pass its check.
    pub fn write(&self, reference: &Trajectory, settings: &OutputSettings, max_shift_mm: f64, name: &Path) -> Result<Output> {
        let largest_shift_mm = || self.largest_shift(reference);
        match (settings.format, self.part()) {
            (OutputFormat::Setpoints(kind), _) => {
                let (text, written) = write_setpoints(self, reference, &settings.setpoints(kind, reference.period_s()))?;
                let setpoints = Some(written);
                let format = Some(settings.format);
                Ok(Output { content: text.into(), largest_shift_mm: largest_shift_mm(), format, setpoints })
            }
            (OutputFormat::Program(_), Some(part)) => {
                let (content, largest_shift_mm) = write_program(part, reference, &settings.refit(), max_shift_mm)?;
                Ok(Output { content, largest_shift_mm, format: Some(settings.format), setpoints: None })
            }
            (OutputFormat::Program(_), None) => {
                let content = reference_content(name, reference)?;
                Ok(Output { content, largest_shift_mm: largest_shift_mm(), format: None, setpoints: None })
            }
        }
    }
}
