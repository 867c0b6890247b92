//! The command line.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::Result;
use clap::{Args, Parser, Subcommand, ValueEnum};
use gcode::PassiveCodes;
use machine::{MachineSpec, WORK_SYSTEMS};

use crate::commands;
use crate::files::Files;
use crate::input;
use crate::output::Refusal;
use crate::pipeline::Carried;

/// Learns how a CNC machine's axes lag, stick and snap back, and shifts a part program's points the other way before its first run.
#[derive(Debug, Parser)]
#[command(name = "precomp", version, max_term_width = 120, propagate_version = true)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Demo(commands::demo::Demo),
    Excite(commands::excite::Excite),
    Simulate(commands::simulate::Simulate),
    Train(commands::train::Train),
    Predict(commands::predict::Predict),
    Compensate(commands::compensate::Compensate),
    Measure(commands::measure::Measure),
    Refine(commands::refine::Refine),
    Compare(commands::compare::Compare),
    Reproduce(commands::reproduce::Reproduce),
}

impl Command {
    /// What it reads and writes.
    fn files(&self) -> Files {
        match self {
            Self::Demo(command) => command.files(),
            Self::Excite(command) => command.files(),
            Self::Simulate(command) => command.files(),
            Self::Train(command) => command.files(),
            Self::Predict(command) => command.files(),
            Self::Compensate(command) => command.files(),
            Self::Measure(command) => command.files(),
            Self::Refine(command) => command.files(),
            Self::Compare(command) => command.files(),
            Self::Reproduce(command) => command.files(),
        }
    }

    fn run(&self) -> Result<()> {
        match self {
            Self::Demo(command) => command.run(),
            Self::Excite(command) => command.run(),
            Self::Simulate(command) => command.run(),
            Self::Train(command) => command.run(),
            Self::Predict(command) => command.run(),
            Self::Compensate(command) => command.run(),
            Self::Measure(command) => command.run(),
            Self::Refine(command) => command.run(),
            Self::Compare(command) => command.run(),
            Self::Reproduce(command) => command.run(),
        }
    }
}

/// Options that every command has.
#[derive(Debug, Clone, Args)]
pub struct Common {
    /// Write the figures as JSON to this file; `-` writes them to standard output
    #[arg(long, value_name = "PATH", global = true)]
    pub json: Option<PathBuf>,
    /// Seed of everything random; the same seed, input and version give the same output
    #[arg(long, default_value_t = 1, global = true)]
    pub seed: u64,
}

/// What the machine is.
#[derive(Debug, Clone, Args)]
pub struct MachineArgs {
    /// Machine description: a TOML file, or a built-in one (ballscrew, maxwell, worn, bc, xyzac), or one drawn at random (random:SEED)
    #[arg(long, value_name = "TOML", default_value = "ballscrew")]
    pub machine: String,
}

/// How a part program is read and planned.
#[derive(Debug, Clone, Args)]
pub struct ProgramArgs {
    /// Control that the program is written for; the machine's profile says, or the program itself, when left out
    #[arg(long, value_enum)]
    pub dialect: Option<DialectName>,
    /// M codes with which this machine changes nothing of path or frame, as in M428,M140; an unknown one leaves the moves after it as they are
    #[arg(long, value_name = "M…", value_delimiter = ',', value_parser = parse_m_code)]
    pub passive: Vec<u16>,
    /// Whether the control skips blocks that begin with `/`; without it they and what depends on them are left alone
    #[arg(long, value_enum, value_name = "ON|OFF")]
    pub block_delete: Option<Switch>,
    /// Machine minus program coordinates, mm: where the part lies on the machine; of one coordinate system with its name, as in
    /// G55=10,20,0. Without it terms that depend on position are left out
    #[arg(long, value_name = "[G54=]X,Y,Z", value_parser = parse_offset, allow_hyphen_values = true)]
    pub work_offset: Vec<GivenOffset>,
    /// Length of the tool, mm, where the offset's Z is without it: added to Z
    #[arg(long, value_name = "MM", value_parser = parse_finite, default_value_t = 0.0, allow_hyphen_values = true)]
    pub tool_length: f64,
    /// Whether a simulated machine runs the program, which is at 0,0,0 where no offset is given.
    #[arg(skip)]
    pub simulated: bool,
    /// How far the control may round corners off where the program does not say so itself (G64 P), mm; 0 plans a stop at every corner
    #[arg(long, value_name = "MM", default_value_t = 0.002, value_parser = parse_not_negative)]
    pub corner_tolerance: f64,
    /// Feed of built-in test curves (`curve:crown`), mm/s
    #[arg(long, value_name = "MM/S", default_value_t = 80.0, value_parser = parse_positive)]
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

/// A work offset: the coordinate system that it is of, if not of all, and machine minus program coordinates, mm.
pub type GivenOffset = (Option<&'static str>, [f64; 3]);

impl ProgramArgs {
    /// The same for a simulated machine: it runs a program at 0,0,0 where no offset is given.
    #[must_use]
    pub fn placed(&self) -> Self {
        Self { simulated: true, ..self.clone() }
    }
}

/// How a log is read.
#[derive(Debug, Clone, Args)]
pub struct LogArgs {
    /// Column names, where they are not recognised: `t=time_s,x_ref=x_cmd_mm,x_act=x_act_mm`
    #[arg(long, value_name = "MAP")]
    pub columns: Option<String>,
    /// Sampling period of logs without time stamps, ms
    #[arg(long, value_name = "MS", value_parser = parse_positive)]
    pub period: Option<f64>,
}

/// A dialect of G-code.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DialectName {
    /// Fanuc and what follows it
    Fanuc,
    /// LinuxCNC 2.9
    Linuxcnc,
}

/// How a compensated path is written.
#[derive(Debug, Clone, Args)]
pub struct CarrierArgs {
    /// Profile of the control: linuxcnc, fanuc, siemens, grbl, generic, or a TOML file; the machine's own when left out
    #[arg(long, value_name = "NAME|TOML")]
    pub controller: Option<String>,
    /// How points carry their time; the controller's profile decides when left out
    #[arg(long, value_enum)]
    pub carrier: Option<Carried>,
    /// Decimals of coordinates in mm (one more in inch programs), at most 12
    #[arg(long, value_parser = parse_decimals)]
    pub decimals: Option<usize>,
    /// Least time between points within one move, or the time between rows of a table, ms
    #[arg(long, value_name = "MS", value_parser = parse_spacing)]
    pub spacing: Option<f64>,
}

impl CarrierArgs {
    /// The machine with the profile of the control that was asked for.
    ///
    /// # Errors
    /// When there is no such profile, or it is not sound.
    pub fn on(&self, spec: MachineSpec) -> Result<MachineSpec> {
        let asked = self.controller.as_deref().map(input::controller).transpose()?;
        Ok(MachineSpec { controller: asked.or(spec.controller), ..spec })
    }
}

/// A positive, finite number.
pub fn parse_positive(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err(format!("`{text}` is not a positive number")),
    }
}

/// Time between points, ms, within the range of a controller profile's.
fn parse_spacing(text: &str) -> Result<f64, String> {
    let value = parse_positive(text)?;
    if (0.01..=1e4).contains(&value) { Ok(value) } else { Err(format!("`{text}` is not within 0.01 to 10000 ms")) }
}

fn parse_decimals(text: &str) -> Result<usize, String> {
    text.trim()
        .parse()
        .ok()
        .filter(|decimals| *decimals <= 12)
        .ok_or_else(|| format!("`{text}` is not a whole number from 0 to 12"))
}

/// A finite number, zero or more.
pub fn parse_not_negative(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() && value >= 0.0 => Ok(value),
        _ => Err(format!("`{text}` is not a number of zero or more")),
    }
}

/// A length with its unit, in mm: `2um`, `2µm`, `0.002mm`, `0.0001in`.
pub fn parse_length(text: &str) -> Result<f64, String> {
    let units = [("µm", 1e-3), ("um", 1e-3), ("mm", 1.0), ("in", 25.4)];
    let (number, scale) = units
        .iter()
        .find_map(|(unit, scale)| Some((text.strip_suffix(unit)?, scale)))
        .ok_or_else(|| format!("`{text}` needs a unit: um, mm or in, as in 2um"))?;
    match number.trim().parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value * scale),
        _ => Err(format!("`{text}` is not a positive length")),
    }
}

/// A finite number.
pub fn parse_finite(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!("`{text}` is not a number")),
    }
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
    let values: Vec<f64> = numbers.split(',').map(parse_finite).collect::<Result<_, _>>()?;
    let offset = values.try_into().map_err(|_| "three numbers separated by commas are wanted: X,Y,Z".to_owned())?;
    Ok((system, offset))
}

/// Runs the command line of this process and returns its exit status: 0 done, 1 refused, 2 error in use.
#[must_use]
pub fn main() -> ExitCode {
    models::keep_memory();
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            let code = if error.use_stderr() { 2 } else { 0 };
            // Nothing is left to tell if even this cannot be printed.
            let _ = error.print();
            return ExitCode::from(code);
        }
    };
    let result = cli.command.files().check().and_then(|()| cli.command.run());
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::from(if error.is::<crate::output::Usage>() { 2 } else { Refusal::CODE })
        }
    }
}
