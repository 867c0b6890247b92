//! `precomp refine`: one iteration of learning on a real machine.

use std::path::PathBuf;

use anyhow::Result;
use clap::{Args, ValueEnum};
use datasets::Log;
use pipeline::refine::{LOW_PASS_HZ, RefineLaw, RefineSettings, refine_from_log};
use pipeline::refit::Mark;
use pipeline::units::um;
use pipeline::{Input, Setup};
use serde_json::json;

use crate::args::{Common, LogArgs, OutputArgs, ProgramArgs, parse_not_negative};
use crate::files::Files;
use crate::output::{Outputs, Printer, Refusal};
use crate::output_format;
use crate::print::compensation::{setpoints, setpoints_json};
use crate::print::figures::{contour_json, orientation_json, text};
use crate::read;

/// The next program from the last run's log: iterative learning control on a real machine, one command a run
///
/// INPUT is always the original, which the part needs. What was commanded in the last run is read from its log, so that learning can start
/// from the original, from a pre-compensated program, or go on after any run.
#[derive(Debug, Args)]
#[command(after_help = "Example, the first run compensated by the model, then two runs of learning:
  precomp compensate part.nc -m mill.model -o run1.nc
  precomp refine part.nc --log run1.csv -m mill.model --run 1 -o run2.nc
  precomp refine part.nc --log run2.csv -m mill.model --run 2 -o run3.nc")]
pub struct Refine {
    /// The original: part program or reference (.csv, .parquet)
    input: PathBuf,
    #[command(flatten)]
    common: Common,
    /// Log of the last run
    #[arg(long, value_name = "LOG")]
    log: PathBuf,
    /// The next program or reference to write, of the same kind as INPUT
    #[arg(short, long, value_name = "OUT")]
    out: PathBuf,
    /// Machine that made the log: a TOML file, or a built-in one; the model's when left out
    #[arg(long, value_name = "TOML")]
    machine: Option<String>,
    /// Model of that machine, from `precomp train`: limits and control are those in it
    #[arg(short, long, value_name = "MODEL")]
    model: Option<PathBuf>,
    #[command(flatten)]
    program: ProgramArgs,
    #[command(flatten)]
    output: OutputArgs,
    /// What is learned
    #[arg(long, value_enum, default_value = "spatial")]
    law: LawArg,
    /// Learning gain; 1/RUN when left out, which averages the noise of the runs away
    #[arg(long, value_name = "Q")]
    gain: Option<f64>,
    /// Which run the log is of, the first being 1
    #[arg(long, value_name = "RUN", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    run: u32,
    /// Cut-off of the zero-phase low-pass on the update, Hz
    #[arg(long, value_name = "HZ", default_value_t = LOW_PASS_HZ)]
    low_pass: f64,
    /// Largest shift of the tool tip, mm: the length of the vector. That of the last run and twice its largest error when left out, from 0.1 to 1 mm
    #[arg(long, value_name = "MM", value_parser = parse_not_negative)]
    max_shift: Option<f64>,
    #[command(flatten)]
    columns: LogArgs,
}

/// What is learned.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum LawArg {
    /// The contour error (Papers A and B)
    Spatial,
    /// The tracking error
    Tracking,
}

impl Refine {
    pub fn files(&self) -> Files {
        Files::of(self.common.json.as_deref())
            .reads("INPUT", &*self.input)
            .reads_logs("--log", [&self.log])
            .reads("-m", self.model.as_deref())
            .reads_machine(self.machine.as_deref())
            .reads_controller(self.output.controller.as_deref())
            .writes("-o", &*self.out)
    }

    pub fn run(&self) -> Result<()> {
        let printer = Printer::new(self.common.json.as_deref());
        let log = read::log_to_measure(&self.log, &self.columns.options(), &printer)?;
        let setup = Setup { period_s: log.period_s(), ..self.setup(&printer)? };
        let format = self.output.settings(&setup).marked(Mark::of_run(self.run));
        let mut input = read::input(&self.input, &setup, &self.program.settings(), self.program.feed)?;
        output_format::check(&format, &input, &self.out)?;
        if let Some(part) = input.part_mut() {
            format.prepare(part);
        }
        check_axes(&input, &log)?;

        let (refined, matched) = refine_from_log(&input, &log, &self.settings())?;
        let before = &refined.before;
        printer.line(format!("run {}: {}, {} µm at 95 %", self.run, text(before), um(before.tip.p95_mm)));
        let output = input.write(&refined.reference, &format, refined.max_shift, &self.out)?;
        printer.line(format!(
            "largest shift {} µm; the program of run {} is {}",
            um(output.largest_shift_mm),
            self.run + 1,
            self.out.display()
        ));
        output.setpoints.iter().flat_map(setpoints).for_each(|line| printer.line(line));
        let figures = json!({
            "run": self.run,
            "contour_um": contour_json(&before.tip),
            "orientation_urad": orientation_json(before.orientation.as_ref()),
            "largest_shift_um": output.largest_shift_mm * 1e3,
            "rows": output.setpoints.as_ref().map(setpoints_json),
            "offset_mm": matched.offset.as_slice(),
        });
        let mut outputs = Outputs::default();
        outputs.add(&self.out, output.content);
        outputs.write(self.common.json.as_deref(), &figures)
    }

    /// The machine that made the log, with its control.
    fn setup(&self, printer: &Printer) -> Result<Setup> {
        let model = self.model.as_deref().map(read::model).transpose()?;
        let machine = read::real_machine(self.machine.as_deref(), self.model.as_deref().zip(model.as_ref()))?;
        let Some((machine, which)) = machine else {
            return Err(read::machine_wanted(
                "the next program is planned and bounded by the limits of the machine that runs it",
            ));
        };
        printer.line(format!("planned for the {which}"));
        self.output.setup(&machine)
    }

    fn settings(&self) -> RefineSettings {
        let settings = RefineSettings::of_run(self.run);
        let law = match self.law {
            LawArg::Spatial => RefineLaw::Spatial,
            LawArg::Tracking => RefineLaw::Tracking,
        };
        let gain = self.gain.unwrap_or(settings.gain);
        RefineSettings { law, gain, low_pass_hz: self.low_pass, max_shift: self.max_shift, ..settings }
    }
}

/// Refuses a log with other axes than the path.
fn check_axes(input: &Input, log: &Log) -> Result<()> {
    input.trajectory().check_axes(log.axes()).map_err(|error| {
        Refusal(format!("path and log: {error}; give the machine that has the log's axes with --machine")).into()
    })
}
