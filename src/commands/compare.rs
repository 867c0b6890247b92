//! `precomp compare`: every method on the same unseen paths.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use machine::SimulationOptions;

use super::simulate::SensorName;
use crate::cli::{Common, MachineArgs, ProgramArgs};
use crate::comparison::{self, CompareSettings, PathComparison, Plant};
use crate::input::{self, Frame, Input};
use crate::learning::{LawName, Settings};
use crate::output::{Printer, write_json};
use crate::report::{PathReport, Series, write_report};

/// Compare first runs with iterative learning control, on a simulated or learned machine and paths that training never saw
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  precomp compare -m mill.model
  precomp compare part.nc curve:butterfly -m mill.model --machine maxwell --seeds 3 --report compare.html")]
pub struct Compare {
    /// Part programs, references or test curves (`curve:NAME`); four unseen curves when none is given
    inputs: Vec<PathBuf>,
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    machine: MachineArgs,
    #[command(flatten)]
    program: ProgramArgs,
    /// Model of the machine; without one only the methods that learn on the machine are compared
    #[arg(short, long, value_name = "MODEL")]
    model: Option<PathBuf>,
    /// Run on what this model says of a machine instead of on a simulated one; it knows no noise
    #[arg(long, value_name = "MODEL", conflicts_with = "machine")]
    on: Option<PathBuf>,
    /// Fresh noise seeds over which figures are averaged
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    seeds: u64,
    /// Learning runs of every ILC
    #[arg(long, default_value_t = 6)]
    runs: usize,
    /// Learning gain Q of the spatial ILC
    #[arg(long, default_value_t = 0.8)]
    gain: f64,
    /// Cut-off of ILC's zero-phase low-pass, Hz
    #[arg(long, value_name = "HZ", default_value_t = 100.0)]
    low_pass: f64,
    /// How the first run is learned on the model
    #[arg(long, value_enum, default_value_t = Settings::default().law)]
    law: LawName,
    /// Updates of virtual learning on the model
    #[arg(long, default_value_t = 4)]
    iterations: usize,
    /// Where positions are measured [default: the machine's own]
    #[arg(long, value_enum)]
    sensor: Option<SensorName>,
    /// Factor on run-to-run noise
    #[arg(long, default_value_t = 1.0)]
    noise: f64,
    /// Write pictures and table as a page
    #[arg(long, value_name = "HTML")]
    report: Option<PathBuf>,
}

/// The curves that are compared when none is named: none of them is in any excitation.
pub const UNSEEN: [&str; 4] = ["crown", "spiral", "flower", "nurbs-1"];
/// The same on a machine that turns tool or workpiece (Paper C).
pub const UNSEEN_TURNED: [&str; 2] = ["saddle", "saddle-butterfly"];

impl Compare {
    pub fn run(&self) -> Result<()> {
        let learned = self.on.as_deref().map(input::model).transpose()?;
        let spec = match &learned {
            Some(learned) => input::machine_of(learned)?,
            None => input::machine(&self.machine.machine)?,
        };
        let frame = Frame::of(&spec)?;
        let bundle = self.model.as_deref().map(input::model).transpose()?;
        let inputs: Vec<PathBuf> = if self.inputs.is_empty() {
            let unseen = if frame.kinematics.turns() { &UNSEEN_TURNED[..] } else { &UNSEEN[..] };
            unseen.iter().map(|name| PathBuf::from(format!("curve:{name}"))).collect()
        } else {
            self.inputs.clone()
        };
        let paths: Vec<Input> = inputs.iter().map(|path| Input::read(path, &frame, &self.program)).collect::<Result<_>>()?;
        let settings = CompareSettings {
            seeds: self.seeds,
            ilc_runs: self.runs,
            ilc_gain: self.gain,
            ilc_low_pass_hz: self.low_pass,
            simulation: SimulationOptions {
                sensor: self.sensor.map(Into::into),
                noise_scale: self.noise,
                ..SimulationOptions::default()
            },
            learning: Settings { law: self.law, iterations: self.iterations, ..Settings::default() },
            seed: self.common.seed,
        };
        let plant = learned.as_ref().map_or(Plant::Simulated(&spec), Plant::Learned);
        let results = comparison::compare(&paths, plant, bundle.as_ref(), &settings)?;
        let printer = Printer::new(self.common.json.as_deref());
        printer.line(comparison::render(&results, &settings));
        if let Some(report) = &self.report {
            write_report(report, "Comparison", &report_of(&results)?)?;
            printer.line(format!("report in {}", report.display()));
        }
        write_json(self.common.json.as_deref(), &comparison::json(&results, &settings))
    }
}

/// Pictures of every path.
pub fn report_of(results: &[PathComparison]) -> Result<Vec<PathReport>> {
    results
        .iter()
        .map(|result| {
            let series =
                result.runs.iter().map(|(name, actual)| Series::of(name, &result.desired, actual)).collect::<Result<Vec<_>>>()?;
            Ok(PathReport::new(&result.name, &result.desired, series))
        })
        .collect()
}
