//! Options that several commands have.

use std::path::PathBuf;

use anyhow::Result;
use clap::{Args, ValueEnum};
use datasets::ReadOptions;
use gcode::{ArcCentres, DecimalPoint, Dialect, Macros, PassiveCodes};
use machine::{MachineSpec, WORK_SYSTEMS};
use pipeline::model_based_ilc::Settings;
use pipeline::model_based_ilc::{FewerPoints, LawName};
use pipeline::part::{GivenOffset, Subprograms};
use pipeline::refit::TimeEncoding;
use pipeline::setpoints::SetpointKind;
use pipeline::{OutputFormat, OutputSettings, ReadSettings, Setup};

pub use crate::numbers::{length_mm as parse_length, not_negative as parse_not_negative};
use crate::output::{Outputs, Printer};
use crate::progress::{Detail, Shown};
use crate::report::{Group, Page, render};
use crate::{numbers, read};

/// Options that every command has.
#[derive(Debug, Clone, Args)]
pub struct Common {
    /// Write the figures as JSON to this file; `-` writes them to standard output
    #[arg(long, value_name = "PATH", global = true)]
    pub json: Option<PathBuf>,
    /// Seed of everything random; the same seed, input and version give the same output
    #[arg(long, default_value_t = 1, global = true)]
    pub seed: u64,
    /// Print warnings and errors only
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Print every step of long work in a line of its own, with the time since its start, and every warning of a program
    #[arg(short, long, global = true)]
    pub verbose: bool,
}

impl Common {
    /// Where the lines of the command go.
    #[must_use]
    pub fn printer(&self) -> Printer {
        if self.quiet { Printer::quiet() } else { Printer::new(self.json.as_deref()) }
    }

    /// How far long work is.
    #[must_use]
    pub fn shown(&self) -> Shown {
        Shown::new(match (self.quiet, self.verbose) {
            (true, _) => Detail::None,
            (_, true) => Detail::Steps,
            _ => Detail::Bars,
        })
    }
}

/// Where the report goes.
#[derive(Debug, Clone, Args)]
pub struct ReportArgs {
    /// Write what was found as a page with pictures, for any browser
    #[arg(long, value_name = "HTML")]
    pub report: Option<PathBuf>,
}

impl ReportArgs {
    /// Adds the page to the outputs, where it is asked for.
    ///
    /// # Errors
    /// When the groups cannot be made, or the page cannot be rendered.
    pub fn add(
        &self,
        outputs: &mut Outputs,
        printer: &Printer,
        (title, lead): (&str, &str),
        groups: impl FnOnce() -> Result<Vec<Group>>,
    ) -> Result<()> {
        let Some(path) = &self.report else { return Ok(()) };
        let page = Page { title: title.to_owned(), lead: lead.to_owned(), groups: groups()? };
        outputs.add(path, render(&page)?);
        printer.line(format!("report in {}", path.display()));
        Ok(())
    }
}

/// What the machine is.
#[derive(Debug, Clone, Args)]
pub struct MachineArgs {
    /// Machine description: a TOML file, a built-in machine (ballscrew, maxwell, worn, bc, xyzac), or a random one (random:SEED)
    #[arg(long, value_name = "TOML", default_value = "ballscrew")]
    pub machine: String,
}

/// How a part program is read and planned.
#[derive(Debug, Clone, Args)]
pub struct ProgramArgs {
    /// Control that a G-code program is written for; Heidenhain dialogue is recognised by its BEGIN PGM. When left out, the machine's profile or the program itself decides
    #[arg(long, value_enum)]
    pub dialect: Option<DialectName>,
    /// M codes that change neither path nor frame on this machine, as in M428,M140. Moves after an unknown M code are left unchanged
    #[arg(long, value_name = "M…", value_delimiter = ',', value_parser = parse_m_code)]
    pub passive: Vec<u16>,
    /// Whether the control skips blocks that begin with `/`. Without it these blocks and the moves that depend on them are left unchanged
    #[arg(long, value_enum, value_name = "ON|OFF")]
    pub block_delete: Option<Switch>,
    /// What a macro or subprogram that is not found (G65, M98, M97, O-words) leaves behind: `keep`, the modes and the coordinate system as they were, or `unknown`. With
    /// `unknown` moves are left unchanged until G90 or G91, plane, work offset, feed and position are stated again
    #[arg(long, value_enum, default_value_t = MacrosName::Unknown)]
    pub macros: MacrosName,
    /// Write the program without parameters, branches, loops and subprograms first, one block for every executed one. Without it programs are
    /// refused whose feed moves run several times or in other files. Refused with it: what acts on the control or is kept after the program, such
    /// as alarms, messages, outputs and kept variables
    #[arg(long)]
    pub expand: bool,
    /// How the control reads coordinates without a decimal point: X50 as 50 mm, or as 0.050 mm. When left out, the control's profile decides
    #[arg(long, value_enum)]
    pub decimal_point: Option<DecimalPointName>,
    /// How I, J and K state the centres of arcs where the program does not say so (G90.1, G91.1): as distances from the start, or as positions. When left out,
    /// the arcs decide, and a program of circles that fit both is refused
    #[arg(long, value_enum)]
    pub arc_centres: Option<ArcCentresName>,
    /// Work offset: machine minus program coordinates, mm; for one coordinate system with its name, as in G55=10,20,0. Without it
    /// terms that depend on position are left out
    #[arg(long, value_name = "[G54=]X,Y,Z", value_parser = parse_offset, allow_hyphen_values = true)]
    pub work_offset: Vec<GivenOffset>,
    /// Length of the tool, mm, where the offset's Z is without it: added to Z
    #[arg(long, value_name = "MM", value_parser = numbers::tool_length_mm, default_value_t = 0.0, allow_hyphen_values = true)]
    pub tool_length: f64,
    /// How far the control may round corners off where the program does not say so itself (G64 P), mm; 0 plans a stop at every corner. When left out, that of
    /// the machine file or of the model decides, else 0.002
    #[arg(long, value_name = "MM", value_parser = numbers::corner_tolerance_mm)]
    pub corner_tolerance: Option<f64>,
    /// Feed of built-in test curves (`curve:crown`), mm/s
    #[arg(long, value_name = "MM/S", default_value_t = 80.0, value_parser = numbers::feed_mm_s)]
    pub feed: f64,
}

/// The position of a switch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Switch {
    /// The switch is on.
    On,
    /// The switch is off.
    Off,
}

impl ProgramArgs {
    /// How programs are read.
    #[must_use]
    pub fn settings(&self) -> ReadSettings {
        ReadSettings {
            dialect: self.dialect.map(Into::into),
            passive: self.passive.iter().fold(PassiveCodes::default(), |passive, number| passive.with(*number)),
            block_delete: self.block_delete.map(|switch| switch == Switch::On),
            macros: self.macros.into(),
            expand: self.expand,
            // Those beside the program, once it is known.
            subprograms: Subprograms::default(),
            decimal_point: self.decimal_point.map(Into::into),
            arc_centres: self.arc_centres.map_or(ArcCentres::Auto, Into::into),
            work_offsets: self.work_offset.clone(),
            tool_length_mm: self.tool_length,
            at_zero: false,
            corner_tolerance_mm: self.corner_tolerance,
        }
    }

    /// The same for a simulated machine: it runs a program at 0,0,0 where no offset is given.
    #[must_use]
    pub fn simulated(&self) -> ReadSettings {
        ReadSettings { at_zero: true, ..self.settings() }
    }
}

/// How a log is read.
#[derive(Debug, Clone, Args)]
pub struct LogArgs {
    /// Column names, where they are not recognised: `t=time_s,x_ref=x_cmd_mm,x_act=pos:um`; `x:inch` is the unit of an axis. What
    /// states no whole axis (`t=t:ms`, `x:um`, `y_act=y_act*-1`) leaves the other columns to their names
    #[arg(long, value_name = "MAP")]
    pub columns: Option<String>,
    /// Sampling period of logs without time stamps, ms; also of logs nearly all of whose stamps stand still
    #[arg(long, value_name = "MS", value_parser = numbers::period_ms)]
    pub period: Option<f64>,
}

impl LogArgs {
    /// The same for the reader.
    #[must_use]
    pub fn options(&self) -> ReadOptions {
        ReadOptions { columns: self.columns.clone(), period_s: self.period.map(|ms| ms * 1e-3) }
    }
}

/// A dialect of G-code.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DialectName {
    /// Fanuc and what follows it
    Fanuc,
    /// LinuxCNC 2.9
    Linuxcnc,
    /// SINUMERIK 840D, 828D, 808D, ONE in its own dialect
    Sinumerik,
}

impl From<DialectName> for Dialect {
    fn from(name: DialectName) -> Self {
        match name {
            DialectName::Fanuc => Self::Fanuc,
            DialectName::Linuxcnc => Self::LinuxCnc,
            DialectName::Sinumerik => Self::Sinumerik,
        }
    }
}

/// A reading of coordinates without a decimal point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DecimalPointName {
    /// Units: X50 is 50 mm (calculator-type input)
    Unit,
    /// Least input increments: X50 is 0.050 mm (IS-B)
    LeastIncrement,
}

impl From<DecimalPointName> for DecimalPoint {
    fn from(name: DecimalPointName) -> Self {
        match name {
            DecimalPointName::Unit => Self::Unit,
            DecimalPointName::LeastIncrement => Self::LeastIncrement,
        }
    }
}

/// How the centres of arcs are stated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ArcCentresName {
    /// As distances from the start of the arc (G91.1)
    Incremental,
    /// As positions (G90.1)
    Absolute,
}

impl From<ArcCentresName> for ArcCentres {
    fn from(name: ArcCentresName) -> Self {
        match name {
            ArcCentresName::Incremental => Self::Incremental,
            ArcCentresName::Absolute => Self::Absolute,
        }
    }
}

/// What is known after macros and subprograms that are not found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum MacrosName {
    /// Modes and coordinate system are as they were; the position is unknown
    Keep,
    /// Nothing
    Unknown,
}

impl From<MacrosName> for Macros {
    fn from(name: MacrosName) -> Self {
        match name {
            MacrosName::Keep => Self::Keep,
            MacrosName::Unknown => Self::Unknown,
        }
    }
}

/// How a compensated path is written.
#[derive(Debug, Clone, Args)]
pub struct OutputArgs {
    /// Profile of the control: linuxcnc, fanuc, siemens, grbl, generic, or a TOML file; the machine's own when left out
    #[arg(long, value_name = "NAME|TOML")]
    pub controller: Option<String>,
    /// What is written: a program whose points carry their time in this way, or a table of setpoints; the controller's profile decides when left out
    #[arg(long, alias = "carrier", value_enum)]
    pub format: Option<FormatName>,
    /// Decimals of coordinates in mm (one more in inch programs), at most 12
    #[arg(long, value_parser = parse_decimals)]
    pub decimals: Option<usize>,
    /// Least time between points within one move, or the time between setpoints, ms
    #[arg(long, value_name = "MS", value_parser = numbers::spacing_ms)]
    pub spacing: Option<f64>,
}

impl OutputArgs {
    /// Settings of learning for this output, with a limit of the cycle time's increase, percent. Who states the format or the distance of
    /// points has asked for what it costs.
    #[must_use]
    pub fn learning(&self, cycle_limit: Option<f64>) -> Settings {
        let own = Settings::default();
        let is_asked = self.format.is_some() || self.spacing.is_some();
        let usual = if is_asked { f64::INFINITY } else { own.cycle_limit };
        let cycle_limit = cycle_limit.map_or(usual, |percent| 0.01 * percent);
        let fewer_points = if self.spacing.is_none() { own.fewer_points } else { FewerPoints::Never };
        Settings { cycle_limit, fewer_points, ..own }
    }

    /// The setup of a machine with the profile of the control that was asked for.
    ///
    /// # Errors
    /// When there is no such profile, it is not sound, or the machine's axes cannot place a tool.
    pub fn setup(&self, machine: &MachineSpec) -> Result<Setup> {
        let asked = self.controller.as_deref().map(read::controller).transpose()?;
        Ok(Setup::new(machine, asked)?)
    }

    /// How output is written for a setup.
    #[must_use]
    pub fn settings(&self, setup: &Setup) -> OutputSettings {
        OutputSettings::new(setup, self.format.map(Into::into), self.decimals, self.spacing)
    }
}

/// What a compensated path is written as.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FormatName {
    /// Inverse time: `F` is one over the line's duration in minutes, at the largest speed planned in it
    G93,
    /// Units a minute, an `F` on every line
    G94,
    /// The program's own feed words, unchanged
    Keep,
    /// Setpoints instead of a program: a CSV table of time and axis positions, for controls that interpolate between them in straight lines
    Table,
    /// Setpoints with velocities (PVT): for controls that interpolate by cubics
    Pvt,
}

impl From<FormatName> for OutputFormat {
    fn from(name: FormatName) -> Self {
        match name {
            FormatName::G93 => Self::Program(TimeEncoding::G93),
            FormatName::G94 => Self::Program(TimeEncoding::G94),
            FormatName::Keep => Self::Program(TimeEncoding::Keep),
            FormatName::Table => Self::Setpoints(SetpointKind::Table),
            FormatName::Pvt => Self::Setpoints(SetpointKind::Pvt),
        }
    }
}

/// How the reference is learned on the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LawArg {
    /// Model-based ILC of the contour error: Gauss-Newton steps; spatial ILC where the tool turns (default)
    #[value(alias = "virtual")]
    ModelBased,
    /// One shift by the predicted contour error (Paper D)
    OneShot,
    /// Every axis driven to its desired position at its time, iterated on the model
    Tracking,
    /// Every axis's error with a bounded shift, iterated on the model (Paper E, N.O.-ILC)
    NormOptimal,
    /// The contour error alone with a bounded shift, iterated on the model (Paper E, N.O.-CCILC)
    CrossCoupled,
}

impl From<LawArg> for LawName {
    fn from(law: LawArg) -> Self {
        match law {
            LawArg::ModelBased => Self::ModelBased,
            LawArg::OneShot => Self::OneShot,
            LawArg::Tracking => Self::Tracking,
            LawArg::NormOptimal => Self::NormOptimal,
            LawArg::CrossCoupled => Self::CrossCoupled,
        }
    }
}

fn parse_decimals(text: &str) -> Result<usize, String> {
    text.trim()
        .parse()
        .ok()
        .filter(|decimals| *decimals <= 12)
        .ok_or_else(|| format!("`{text}` is not a whole number from 0 to 12"))
}

fn parse_m_code(text: &str) -> Result<u16, String> {
    let number = text.trim().trim_start_matches(['M', 'm']).parse::<u16>().ok().filter(|number| *number <= PassiveCodes::LARGEST);
    number.ok_or_else(|| format!("`{text}` is not an M code (M0 to M{})", PassiveCodes::LARGEST))
}

fn parse_offset(text: &str) -> Result<GivenOffset, String> {
    let (system, numbers) = match text.split_once('=') {
        Some((name, numbers)) => {
            let known = WORK_SYSTEMS.into_iter().find(|known| known.eq_ignore_ascii_case(name.trim()));
            (Some(known.ok_or_else(|| format!("`{name}` is not one of {}", WORK_SYSTEMS.join(", ")))?), numbers)
        }
        None => (None, text),
    };
    let values: Vec<f64> = numbers.split(',').map(numbers::offset_mm).collect::<Result<_, _>>()?;
    let offset = values.try_into().map_err(|_| "three numbers separated by commas are wanted: X,Y,Z".to_owned())?;
    Ok((system, offset))
}
