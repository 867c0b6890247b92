//! `precomp simulate`: run a path on the simulated machine.

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::{Args, ValueEnum};
use datasets::Log;
use machine::{Machine, Sensor, SimulatedMachine, SimulationOptions};
use pipeline::Setup;
use pipeline::statistics::figures_along;
use serde_json::json;

use crate::args::{Common, MachineArgs, ProgramArgs};
use crate::files::Files;
use crate::kind::Kind;
use crate::numbers;
use crate::output::Outputs;
use crate::print::compensation::show_read;
use crate::print::figures::{contour_json, orientation_json, text, tracking_json};
use crate::read;

/// Run a program, reference or test curve on the simulated machine and write the log
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  precomp simulate part.nc -o part.csv
  precomp simulate compensated.nc --against part.nc -o after.csv
  precomp simulate curve:crown --machine maxwell -o crown.csv")]
pub struct Simulate {
    /// Part program, reference (.csv, .parquet) or test curve (`curve:NAME`)
    input: PathBuf,
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    machine: MachineArgs,
    #[command(flatten)]
    program: ProgramArgs,
    /// The log to write (.csv, .parquet)
    #[arg(short, long, value_name = "LOG")]
    out: PathBuf,
    /// The path that the part needs, where INPUT is a compensated one: the contour error is measured against it
    #[arg(long, value_name = "INPUT")]
    against: Option<PathBuf>,
    /// Where positions are measured [default: the machine's own]
    #[arg(long, value_enum)]
    sensor: Option<SensorName>,
    /// Factor on run-to-run noise; 0 repeats every run exactly
    #[arg(long, default_value_t = 1.0, value_parser = numbers::noise)]
    noise: f64,
}

/// Where positions are measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SensorName {
    /// Encoder on the motor: does not see backlash and the screw's stretch
    Motor,
    /// Scale on the table
    Table,
}

impl From<SensorName> for Sensor {
    fn from(name: SensorName) -> Self {
        match name {
            SensorName::Motor => Self::Motor,
            SensorName::Table => Self::Table,
        }
    }
}

impl Simulate {
    pub fn files(&self) -> Files {
        Files::of(self.common.json.as_deref())
            .reads("INPUT", &*self.input)
            .reads("--against", self.against.as_deref())
            .reads_machine(&*self.machine.machine)
            .writes("-o", &*self.out, Kind::Table)
    }

    pub fn run(&self) -> Result<()> {
        let machine = read::machine(&self.machine.machine)?;
        let setup = Setup::new(&machine, None)?;
        let read = |path: &Path| read::input(path, &setup, &self.program.simulated(), self.program.feed);
        let input = read(&self.input)?;
        let options =
            SimulationOptions { sensor: self.sensor.map(Into::into), noise_scale: self.noise, ..SimulationOptions::default() };
        let mut simulated = SimulatedMachine::new(&machine, self.common.seed)?.with_options(options)?;
        let reference = input.command();
        let actual = simulated.run(reference)?;
        let against = self.against.as_deref().map(read).transpose()?;
        let needed = against.as_ref().unwrap_or(&input);
        let figures = figures_along(needed.desired(), needed.part(), reference, &actual)?;
        let mut outputs = Outputs::default();
        outputs.add_log(&self.out, &Log::new(input.name(), reference.clone(), actual.clone())?)?;
        let printer = self.common.printer();
        show_read(&printer, &input, self.common.verbose);
        printer.line(format!(
            "{} on the machine `{}`: {:.2} s; {}; log in {}",
            input.name(),
            machine.name,
            reference.duration_s(),
            text(&figures),
            self.out.display()
        ));
        outputs.write(
            self.common.json.as_deref(),
            &json!({
                "seconds": reference.duration_s(),
                "contour_um": contour_json(&figures.tip),
                "orientation_urad": orientation_json(figures.orientation.as_ref()),
                "tracking_um": tracking_json(reference, &actual)?,
            }),
        )
    }
}
