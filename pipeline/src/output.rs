//! Output of a learned reference: a part program, a setpoint table, or the reference itself.

use std::path::Path;

use datasets::reference_content;
use machine::ControllerSpec;
use motion::Trajectory;
use serde::Serialize;

use crate::error::Result;
use crate::input::Input;
use crate::part::Part;
use crate::refit::{DECIMALS, Mark, RefitSettings, TimeEncoding, write_program};
use crate::setpoints::{SetpointKind, SetpointSettings, SetpointsWritten, write_setpoints};
use crate::setup::Setup;

/// Default interval of a PVT table, ms, where neither the caller nor the control profile states one.
const PVT_MS: f64 = 4.0;

/// Output format of a compensated path.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(untagged)]
pub enum OutputFormat {
    /// Part program, with the time encoding of its points.
    Program(TimeEncoding),
    /// Setpoints: a table of axis positions over time.
    Setpoints(SetpointKind),
}

impl From<machine::ProfileFormat> for OutputFormat {
    fn from(format: machine::ProfileFormat) -> Self {
        match format {
            machine::ProfileFormat::G93 => Self::Program(TimeEncoding::G93),
            machine::ProfileFormat::G94 => Self::Program(TimeEncoding::G94),
            machine::ProfileFormat::Keep => Self::Program(TimeEncoding::Keep),
            machine::ProfileFormat::Table => Self::Setpoints(SetpointKind::Table),
            machine::ProfileFormat::Pvt => Self::Setpoints(SetpointKind::Pvt),
        }
    }
}

impl OutputFormat {
    /// Time encoding of a program in this format; [`TimeEncoding::Keep`] for setpoints.
    #[must_use]
    pub fn encoding(self) -> TimeEncoding {
        match self {
            Self::Program(encoding) => encoding,
            Self::Setpoints(_) => TimeEncoding::Keep,
        }
    }
}

/// Settings of the output: the caller's values, else those of the control profile.
#[derive(Debug, Clone, PartialEq)]
pub struct OutputSettings {
    /// Output format.
    pub format: OutputFormat,
    /// Comment at the head of a changed program. Without it [`Input::check_original`] cannot recognise the output.
    pub mark: Option<Mark>,
    decimals: Option<usize>,
    spacing_ms: Option<f64>,
    controller: Option<ControllerSpec>,
    /// Points of a program in place of those by the other settings.
    points: Option<RefitSettings>,
}

impl OutputSettings {
    /// Settings for the control of `setup`. `None` takes the value of the control profile. `decimals` is the number of
    /// decimals of coordinates in mm, `spacing_ms` the time between points or setpoints, ms.
    #[must_use]
    pub fn new(setup: &Setup, format: Option<OutputFormat>, decimals: Option<usize>, spacing_ms: Option<f64>) -> Self {
        // Measured with the planner of this project in place of the control: G93 lengthens the cycle by up to 13 %, the
        // program's own feeds do not lengthen it.
        let own = setup.controller.map_or(OutputFormat::Program(TimeEncoding::Keep), |profile| profile.format.into());
        Self { format: format.unwrap_or(own), mark: None, decimals, spacing_ms, controller: setup.controller, points: None }
    }

    /// The same, with this comment at the head of a changed program.
    #[must_use]
    pub fn marked(self, mark: Mark) -> Self {
        let comments = self.controller.map(|profile| profile.comments).unwrap_or_default();
        Self { mark: Some(mark.in_comments(comments)), ..self }
    }

    /// The same with the points of a program that were chosen by its forecast. Without effect where the output is setpoints.
    #[must_use]
    pub fn with_points(self, points: RefitSettings) -> Self {
        match self.format {
            OutputFormat::Program(_) => Self { format: OutputFormat::Program(points.encoding), points: Some(points), ..self },
            OutputFormat::Setpoints(_) => self,
        }
    }

    /// Settings for writing a program; `None` where the output is setpoints.
    #[must_use]
    pub fn program(&self) -> Option<RefitSettings> {
        matches!(self.format, OutputFormat::Program(_)).then(|| self.refit())
    }

    /// Settings for writing a program, also where the output is setpoints.
    #[must_use]
    pub fn refit(&self) -> RefitSettings {
        self.points.unwrap_or_else(|| RefitSettings::of(self.format.encoding(), self.decimals, self.spacing_ms, self.controller))
    }

    /// Sets [`Part::states_path`], whether compensated segments state a path mode of their own, as on LinuxCNC, and [`Part::states_line_times`].
    pub fn prepare(&self, part: &mut Part) {
        part.states_path = self.states_path() && part.has_path_tolerance();
        part.states_line_times = self.program().is_some_and(|settings| settings.encoding == TimeEncoding::G93);
    }

    /// Whether segments state a path mode where the program's dialect has one.
    #[must_use]
    pub fn states_path(&self) -> bool {
        self.program().is_some_and(|settings| settings.path_tolerance_mm.is_some())
    }

    /// Settings of a setpoint table of this kind for a reference with this sampling period, s.
    fn setpoints(&self, kind: SetpointKind, period_s: f64) -> SetpointSettings {
        let profile = self.controller.filter(|profile| OutputFormat::from(profile.format) == self.format);
        let usual_ms = match kind {
            SetpointKind::Table => period_s * 1e3,
            SetpointKind::Pvt => PVT_MS,
        };
        let interval_ms = self.spacing_ms.or(profile.map(|profile| profile.point_spacing_ms)).unwrap_or(usual_ms);
        let decimals = self.decimals.or(profile.map(|profile| usize::from(profile.decimals))).unwrap_or(DECIMALS);
        SetpointSettings { kind, interval_s: interval_ms * 1e-3, decimals }
    }
}

/// A compensated path as bytes.
#[derive(Debug, Clone)]
pub struct Output {
    /// Content of the file.
    pub content: Vec<u8>,
    /// Largest correction of a point, mm.
    pub largest_shift_mm: f64,
    /// Output format; `None` for a reference.
    pub format: Option<OutputFormat>,
    /// Properties of the setpoint table, where one was written.
    pub setpoints: Option<SetpointsWritten>,
}

impl Input {
    /// Writes `reference`, which was learned for this input with corrections of at most `max_shift_mm`.
    ///
    /// A program is read again and verified. The extension of `name` selects the format of a reference: `.csv` or
    /// `.parquet`.
    ///
    /// # Errors
    /// When a setting is out of range, or the output fails verification.
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
                let (content, largest_shift_mm) =
                    write_program(part, reference, &settings.refit(), max_shift_mm, settings.mark.as_ref())?;
                Ok(Output { content, largest_shift_mm, format: Some(settings.format), setpoints: None })
            }
            (OutputFormat::Program(_), None) => {
                let content = reference_content(name, reference)?;
                Ok(Output { content, largest_shift_mm: largest_shift_mm(), format: None, setpoints: None })
            }
        }
    }
}
