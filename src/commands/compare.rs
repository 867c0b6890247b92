//! `precomp compare`: every method on the same unseen paths.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use machine::SimulationOptions;
use pipeline::compare::{CompareSettings, Plant, UNSEEN, UNSEEN_TURNED, compare, compare_programs};
use pipeline::model_based_ilc::Settings;
use pipeline::{Event, Input, Setup};

use super::simulate::SensorName;
use crate::args::{Common, LawArg, MachineArgs, ProgramArgs, ReportArgs};
use crate::files::Files;
use crate::kind::Kind;
use crate::numbers;
use crate::output::Outputs;
use crate::print::comparison as print;
use crate::read;
use crate::report::comparison;

/// Compare first runs with iterative learning control, on a simulated or learned machine and paths that training never saw
///
/// Every ILC gets its best settings: gain, cut-off and the window at stops and turns (norm-optimal laws: their weights) are chosen on the machine
/// that is compared, by the RMS of the last runs on a curve and a noise seed that are not reported.
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
    #[arg(long, default_value_t = 1, value_parser = numbers::count)]
    seeds: u64,
    /// Learning runs of every ILC, the last of which counts
    #[arg(long, default_value_t = CompareSettings::default().ilc_runs, value_parser = numbers::learning_runs)]
    runs: usize,
    /// Learning gain of every ILC with a constant one; tuned on the machine when left out
    #[arg(long, value_name = "Q", value_parser = numbers::gain)]
    gain: Option<f64>,
    /// Cut-off of ILC's zero-phase low-pass, Hz; tuned on the machine when left out. With --gain nothing is tuned
    #[arg(long, value_name = "HZ", value_parser = numbers::low_pass_hz)]
    low_pass: Option<f64>,
    /// How the first run is learned on the model
    #[arg(long, value_enum, default_value = "model-based")]
    law: LawArg,
    /// Compare as G-code too, in a second table: part programs, and built-in curves as programs of short lines; the control plans their time
    #[arg(long)]
    programs: bool,
    /// Updates of model-based ILC
    #[arg(long, default_value_t = 4, value_parser = numbers::iterations)]
    iterations: usize,
    /// Where positions are measured [default: the machine's own]
    #[arg(long, value_enum)]
    sensor: Option<SensorName>,
    /// Factor on run-to-run noise
    #[arg(long, default_value_t = 1.0, value_parser = numbers::noise)]
    noise: f64,
    #[command(flatten)]
    report: ReportArgs,
}

impl Compare {
    pub fn files(&self) -> Files {
        let files = Files::of(self.common.json.as_deref()).reads("-m", self.model.as_deref()).reads("--on", self.on.as_deref());
        let files = self.inputs.iter().fold(files, |files, input| files.reads("INPUT", &**input));
        files.reads_machine(&*self.machine.machine).writes("--report", self.report.report.as_deref(), Kind::Report)
    }

    pub fn run(&self) -> Result<()> {
        let learned = self.on.as_deref().map(read::model).transpose()?;
        let machine = match &learned {
            Some(learned) => pipeline::machine_of(learned)?,
            None => read::machine(&self.machine.machine)?,
        };
        let setup = Setup::new(&machine, None)?;
        let model = self.model.as_deref().map(read::model).transpose()?;
        let (paths, settings) = (self.paths(&setup)?, self.settings());
        let plant = learned.as_ref().map_or(Plant::Simulated(&machine), Plant::Learned);
        let shown = self.common.shown();
        let progress = |event: Event<'_>| shown.event(event);
        let results = compare(&paths, plant, model.as_ref(), &settings, &progress)?;
        let printer = self.common.printer();
        let on = if learned.is_some() { "learned" } else { "simulated" };
        printer.line(format!("{on} machine `{}`", machine.name));
        printer.line(print::render(&results, &settings));
        let mut figures = print::json(&results, &settings);
        if self.programs {
            let (programs, tuned) = compare_programs(paths, plant, model.as_ref(), &settings, &results.tuned, &progress)?;
            printer.line(print::render_programs(&programs, &tuned, &settings));
            figures["programs"] = print::programs_json(&programs, &tuned, &settings);
        }
        let mut outputs = Outputs::default();
        self.report.add(&mut outputs, &printer, ("Comparison", LEAD), || comparison(&results.paths))?;
        outputs.write(self.common.json.as_deref(), &figures)
    }

    /// The paths that are named, else the unseen curves.
    fn paths(&self, setup: &Setup) -> Result<Vec<Input>> {
        let unseen = unseen(setup).iter().map(|name| PathBuf::from(format!("curve:{name}")));
        let named = if self.inputs.is_empty() { unseen.collect() } else { self.inputs.clone() };
        named.iter().map(|path| read::input(path, setup, &self.program.simulated(), self.program.feed)).collect()
    }

    fn settings(&self) -> CompareSettings {
        CompareSettings {
            seeds: self.seeds,
            ilc_runs: self.runs,
            ilc_gain: self.gain,
            ilc_low_pass_hz: self.low_pass,
            simulation: SimulationOptions {
                sensor: self.sensor.map(Into::into),
                noise_scale: self.noise,
                ..SimulationOptions::default()
            },
            learning: Settings { law: self.law.into(), iterations: self.iterations, ..Settings::default() },
            seed: self.common.seed,
        }
    }
}

/// The curves that no training saw, for a machine.
pub fn unseen(setup: &Setup) -> &'static [&'static str] {
    if setup.kinematics.has_rotary_axes() { &UNSEEN_TURNED } else { &UNSEEN }
}

/// What the report shows.
pub const LEAD: &str = "First runs by a model beside learning on the machine, on paths that training never saw.";
