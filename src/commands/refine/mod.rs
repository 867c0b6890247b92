//! `precomp refine`: learning on a real machine, one command a run.

mod by_law;
mod by_model;
mod ran;

use std::path::PathBuf;

use anyhow::Result;
use clap::{Args, ValueEnum};
use datasets::Log;
use motion::{Trajectory, Vec3};
use pipeline::model_based_ilc::Outcome;
use pipeline::refine::{Ended, LOW_PASS_HZ, best_of};
use pipeline::refit::{Mark, comes_from};
use pipeline::statistics::Figures;
use pipeline::units::um;
use pipeline::{Input, Output, OutputSettings, Setup};
use serde_json::{Value, json};

use crate::args::{Common, LogArgs, OutputArgs, ProgramArgs, ReportArgs};
use crate::commands::compensate::merged;
use crate::files::Files;
use crate::kind::Kind;
use crate::numbers;
use crate::output::{Outputs, Printer, Refusal, Usage, read_file};
use crate::output_format;
use crate::print::figures::{contour_json, orientation_json, text};
use crate::print::written::{setpoints, setpoints_json};
use crate::read;
use crate::report::{Group, Run, Track, over_runs, sections};

/// The next program from the logs of all runs so far: iterative learning control on a real machine, one command a run
///
/// INPUT is always the original, which the part needs. Every new program is computed from it; what was commanded in the runs is read from
/// their logs. With a model of the machine, what is learned is the part of the model's error that repeats from run to run. A new program is
/// written only where it is expected to be better than the best one so far by more than 1 % RMS. Otherwise, and where the last run was worse
/// than the best one by more than 5 % RMS or 30 % MAX, learning has ended, and OUT is the best program of --ran, byte for byte.
#[derive(Debug, Args)]
#[command(after_help = "Example, the first run compensated by the model, then two runs of learning:
  precomp compensate part.nc -m mill.model -o run1.nc
  precomp refine part.nc -m mill.model --log run1.csv --ran run1.nc -o run2.nc
  precomp refine part.nc -m mill.model --log run1.csv run2.csv --ran run1.nc run2.nc -o run3.nc")]
pub struct Refine {
    /// The original: part program or reference (.csv, .parquet)
    input: PathBuf,
    #[command(flatten)]
    common: Common,
    /// Logs of all runs of this part so far, in order
    #[arg(long, value_name = "LOG", required = true, num_args = 1..)]
    log: Vec<PathBuf>,
    /// The programs that ran, one for each log: the best one is written to OUT where learning ends. Needed with several logs
    #[arg(long, value_name = "PROGRAM", num_args = 1..)]
    ran: Vec<PathBuf>,
    /// The next program or reference to write, of the same kind as INPUT
    #[arg(short, long, value_name = "OUT")]
    out: PathBuf,
    /// Machine that made the logs: a TOML file, a built-in one, or random:SEED; the model's when left out
    #[arg(long, value_name = "TOML")]
    machine: Option<String>,
    /// Model of that machine, from `precomp train`: limits and control are those in it
    #[arg(short, long, value_name = "MODEL")]
    model: Option<PathBuf>,
    #[command(flatten)]
    program: ProgramArgs,
    #[command(flatten)]
    output: OutputArgs,
    /// What is learned: with a model model-based, else spatial; spatial too where --gain or --low-pass is given
    #[arg(long, value_enum)]
    law: Option<LawArg>,
    /// Learning gain of the laws without a model; 1/RUN when left out, which averages the noise of the runs away
    #[arg(long, value_name = "Q", value_parser = numbers::gain)]
    gain: Option<f64>,
    /// Which run the last log is of, the first being 1; the number of logs when left out
    #[arg(long, value_name = "RUN", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    run: Option<u32>,
    /// Cut-off of the zero-phase low-pass on the update of the laws without a model, Hz [default: 100]
    #[arg(long, value_name = "HZ", value_parser = numbers::low_pass_hz)]
    low_pass: Option<f64>,
    /// Largest shift of the tool tip, mm: the length of the vector. When left out: from the largest error, from 0.1 to 1 mm
    #[arg(long, value_name = "MM", value_parser = numbers::max_shift_mm)]
    max_shift: Option<f64>,
    /// With a model: come to stops at the program's own feed, also where a slower end would lower the predicted error
    #[arg(long)]
    keep_stops: bool,
    #[command(flatten)]
    columns: LogArgs,
    #[command(flatten)]
    report: ReportArgs,
}

/// What is learned.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum LawArg {
    /// The part of the model's error that repeats from run to run; needs a model
    ModelBased,
    /// The contour error of the last run (Papers A and B)
    Spatial,
    /// The tracking error of the last run
    Tracking,
}

impl Refine {
    pub fn files(&self) -> Files {
        Files::of(self.common.json.as_deref())
            .reads("INPUT", &*self.input)
            .reads_logs("--log", &self.log)
            .reads_all("--ran", &self.ran)
            .reads("-m", self.model.as_deref())
            .reads_machine(self.machine.as_deref())
            .reads_controller(self.output.controller.as_deref())
            .writes("-o", &*self.out, Kind::Path)
            .writes("--report", self.report.report.as_deref(), Kind::Report)
    }

    pub fn run(&self) -> Result<()> {
        self.check_ran()?;
        match self.law() {
            LawArg::ModelBased => rayon::scope(|_| self.learn_by_model()),
            LawArg::Spatial | LawArg::Tracking => self.learn_by_law(),
        }
    }

    fn law(&self) -> LawArg {
        let has_filter = self.gain.is_some() || self.low_pass.is_some();
        let by_model = self.model.is_some() && !has_filter;
        self.law.unwrap_or(if by_model { LawArg::ModelBased } else { LawArg::Spatial })
    }

    /// Number of the last run, from 1.
    fn last_run(&self) -> u32 {
        self.run.unwrap_or_else(|| u32::try_from(self.log.len()).unwrap_or(u32::MAX))
    }

    /// Number of the run of the log with this index, from 1.
    fn run_of(&self, index: usize) -> usize {
        (self.last_run() as usize + 1 + index).saturating_sub(self.log.len())
    }

    fn check_ran(&self) -> Result<()> {
        let (logs, ran) = (self.log.len(), self.ran.len());
        if logs == ran || (logs == 1 && ran == 0) {
            return Ok(());
        }
        let why = format!("{logs} logs and {ran} programs: give the program of every run with --ran, in the order of the logs");
        Err(Usage(format!("{why}; the best one is written where learning ends")).into())
    }

    /// The logs, in the order of the runs.
    fn logs(&self, printer: &Printer) -> Result<Vec<Log>> {
        self.log.iter().map(|log| read::log_to_measure(log, &self.columns.options(), printer)).collect()
    }

    /// The input on the machine that made the logs, sampled every `period_s` or as that machine is, and how the output is written.
    fn input(&self, period_s: Option<f64>, printer: &Printer) -> Result<(Input, OutputSettings, Setup)> {
        let setup = self.setup(printer)?;
        let setup = Setup { period_s: period_s.unwrap_or(setup.period_s), ..setup };
        let format = self.output.settings(&setup).marked(Mark::of_run(self.last_run()));
        let mut input = read::input(&self.input, &setup, &self.program.settings(), self.program.feed)?;
        output_format::check(&format, &input, &self.out)?;
        if let Some(part) = input.part_mut() {
            format.prepare(part);
        }
        Ok((input, format, setup))
    }

    /// The machine that made the logs, with its control.
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

    /// The programs that ran, as they are: the original, or computed from it. Tables of setpoints do not state their original.
    fn programs(&self, input: &Input, format: &OutputSettings) -> Result<Vec<Vec<u8>>> {
        let programs: Vec<Vec<u8>> = self.ran.iter().map(|path| read_file(path)).collect::<Result<_>>()?;
        let Some(part) = input.part().filter(|_| format.program().is_some()) else { return Ok(programs) };
        // With --expand the part is the flat program.
        let original = read_file(&self.input)?;
        for (path, bytes) in self.ran.iter().zip(&programs) {
            if *bytes != original && !comes_from(&gcode::parse(bytes.clone()), &part.program) {
                let (path, original) = (path.display(), self.input.display());
                return Err(Refusal(format!(
                    "{path} is not {original}, nor does it state at its head that it was computed from it; give the programs that ran with --ran"
                ))
                .into());
            }
        }
        Ok(programs)
    }

    /// Prints the figures of all runs, and returns them with those of the last one.
    fn show_runs(&self, printer: &Printer, runs: &[Figures], offset: Option<&Vec3>) -> Value {
        for (index, run) in runs.iter().enumerate() {
            printer.line(format!("run {}: {}, {} µm at 95 %", self.run_of(index), text(run), um(run.tip.p95_mm)));
        }
        let last = runs.last();
        json!({
            "run": self.last_run(),
            "runs": runs.iter().map(|run| contour_json(&run.tip)).collect::<Vec<_>>(),
            "best_run": best_of(runs).map(|best| self.run_of(best)),
            "contour_um": last.map(|run| contour_json(&run.tip)),
            "orientation_urad": last.map(|run| orientation_json(run.orientation.as_ref())),
            "offset_mm": offset.map(|offset| offset.as_slice().to_vec()),
        })
    }

    /// Title of the report.
    fn title(&self) -> String {
        format!("Runs of {}", self.input.file_name().unwrap_or_default().to_string_lossy())
    }

    /// What the report shows of the runs, whose command and actual positions are in the path's time, and of what comes next.
    fn pages(
        &self,
        input: &Input,
        runs: &[(Trajectory, Trajectory)],
        figures: &[Figures],
        next: Option<&Outcome>,
    ) -> Result<Vec<Group>> {
        let track = Track::of(input);
        let name = |index: usize| format!("run {}", self.run_of(index));
        let measured = runs.iter().zip(figures).enumerate().map(|(index, ((command, actual), figures))| -> Result<Run> {
            let run = Run::of(&name(index), &track, Some(command), actual)?;
            Ok(Run { figures: figures.tip, turn: figures.orientation, ..run })
        });
        let mut all = measured.collect::<Result<Vec<Run>>>()?;
        if let Some(next) = next {
            all.push(Run::of("next (forecast)", &track, Some(&next.reference), &next.forecast)?);
        }
        let mut shown = sections(&track, &all);
        shown.extend(over_runs(self.run_of(0), figures));
        Ok(vec![Group { name: input.name().to_owned(), sections: shown }])
    }

    /// Writes a new program with the figures.
    fn write_program(&self, output: Output, figures: Value, pages: Pages<'_>, printer: &Printer) -> Result<()> {
        printer.line(format!(
            "largest shift {} µm; the program of run {} is {}",
            um(output.largest_shift_mm),
            self.last_run() + 1,
            self.out.display()
        ));
        output.setpoints.iter().flat_map(setpoints).for_each(|line| printer.line(line));
        let own = json!({
            "ended": null,
            "largest_shift_um": output.largest_shift_mm * 1e3,
            "rows": output.setpoints.as_ref().map(setpoints_json),
        });
        let mut outputs = Outputs::default();
        outputs.add(&self.out, output.content);
        self.report.add(&mut outputs, printer, (&self.title(), LEAD), pages)?;
        outputs.write(self.common.json.as_deref(), &merged(figures, own))
    }

    /// Writes the program of the best run once more.
    fn write_best(
        &self,
        (best, program): (usize, &[u8]),
        ended: Ended,
        figures: Value,
        pages: Pages<'_>,
        printer: &Printer,
    ) -> Result<()> {
        let own = json!({ "ended": ended.name(), "written_run": self.run_of(best) });
        let mut outputs = Outputs::default();
        outputs.add(&self.out, program);
        self.report.add(&mut outputs, printer, (&self.title(), LEAD), pages)?;
        outputs.write(self.common.json.as_deref(), &merged(figures, own))
    }
}

/// Makes what the report shows, where it is asked for.
type Pages<'a> = &'a dyn Fn() -> Result<Vec<Group>>;

/// What the report shows.
const LEAD: &str = "The runs of the part so far, as the encoders saw them, each at the place of the path where it was.";

/// Refuses a log with other axes than the path.
fn check_axes(input: &Input, log: &Log) -> Result<()> {
    input.trajectory().check_axes(log.axes()).map_err(|error| {
        Refusal(format!("path and log: {error}; give the machine that has the log's axes with --machine")).into()
    })
}
