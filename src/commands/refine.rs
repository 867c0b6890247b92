//! `precomp refine`: one iteration of learning on a real machine.

use std::path::PathBuf;

use anyhow::Result;
use clap::{Args, ValueEnum};
use compensation::laws::{Gain, SpatialIlc, TrackingIlc};
use compensation::{CompensationLaw, Guard, LowPass};
use serde_json::json;

use crate::cli::{CarrierArgs, Common, LogArgs, ProgramArgs, parse_not_negative};
use crate::evaluate;
use crate::files::Files;
use crate::input::{self, Frame, Input};
use crate::learning::{FADE_S, shift_bound};
use crate::measurement::{in_path_time, match_run, without_approach};
use crate::output::{Outputs, Printer, Refusal, um};
use crate::pipeline::{Carried, RowsWritten, write_out};

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
    carrier: CarrierArgs,
    /// What is learned
    #[arg(long, value_enum, default_value_t = RefineLaw::Spatial)]
    law: RefineLaw,
    /// Learning gain; 1/RUN when left out, which averages the noise of the runs away
    #[arg(long, value_name = "Q")]
    gain: Option<f64>,
    /// Which run the log is of, the first being 1
    #[arg(long, value_name = "RUN", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    run: u32,
    /// Cut-off of the zero-phase low-pass on the update, Hz
    #[arg(long, value_name = "HZ", default_value_t = 100.0)]
    low_pass: f64,
    /// Largest shift of the tool tip, mm: the length of the vector. That of the last run and twice its largest error when left out, from 0.1 to 1 mm
    #[arg(long, value_name = "MM", value_parser = parse_not_negative)]
    max_shift: Option<f64>,
    #[command(flatten)]
    columns: LogArgs,
}

/// What is learned.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum RefineLaw {
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
            .reads_controller(self.carrier.controller.as_deref())
            .writes("-o", &*self.out)
    }

    pub fn run(&self) -> Result<()> {
        let printer = Printer::new(self.common.json.as_deref());
        let log = input::log_to_measure(&self.log, &self.columns, &printer)?;
        let bundle = self.model.as_deref().map(input::model).transpose()?;
        let machine = input::real_machine(self.machine.as_deref(), self.model.as_deref().zip(bundle.as_ref()))?;
        let Some((spec, which)) = machine else {
            return Err(input::machine_wanted(
                "the next program is planned and bounded by the limits of the machine that runs it",
            ));
        };
        printer.line(format!("planned for the {which}"));
        let spec = self.carrier.on(spec)?;
        let frame = Frame { period_s: log.period_s(), ..Frame::of(&spec)? };
        let mut path = Input::read(&self.input, &frame, &self.program)?;
        let carried = Carried::of(&self.carrier, &spec);
        carried.check(&path, &self.out)?;
        path.part.iter_mut().for_each(|part| carried.tell(part, &self.carrier, &spec));
        let desired = &path.desired;
        desired.trajectory().check_axes(log.axes()).map_err(|error| {
            Refusal(format!("path and log: {error}; give the machine that has the log's axes with --machine"))
        })?;

        let (log, _) = without_approach(&log, desired)?;
        let matched = match_run(desired, &desired.tips_of(&log.reference)?, log.period_s())?;
        let (reference, actual) = in_path_time(desired, &log, &matched)?;
        let before = evaluate::figures(desired, path.part.as_ref(), &actual)?;

        let low_pass = LowPass::new(self.low_pass, log.period_s())?;
        let gain = Gain::Constant(self.gain.unwrap_or(1.0 / f64::from(self.run)));
        let mut law: Box<dyn CompensationLaw> = match self.law {
            RefineLaw::Spatial => Box::new(SpatialIlc::new(gain, low_pass)?),
            RefineLaw::Tracking => Box::new(TrackingIlc::new(gain, low_pass)),
        };
        let weights = path.part.as_ref().map(|part| part.weights(FADE_S)).unwrap_or_default();
        let max_shift = self.max_shift.unwrap_or_else(|| shift_bound(path.largest_shift(&reference), before.tip.max_mm));
        let guard = Guard { max_shift, limits: Some(frame.limits.clone()), weights, ..Guard::default() };
        let next = guard.apply(desired, &law.update(desired, &reference, &actual)?)?;

        printer.line(format!("run {}: {}, {} µm at 95 %", self.run, evaluate::in_words(&before), um(before.tip.p95_mm)));
        let written = write_out(&path, &next, carried, &spec, &self.carrier, max_shift, &self.out)?;
        let mut outputs = Outputs::default();
        outputs.add(&self.out, written.content);
        printer.line(format!(
            "largest shift {} µm; the program of run {} is {}",
            um(written.largest_shift_mm),
            self.run + 1,
            self.out.display()
        ));
        written.rows.iter().flat_map(RowsWritten::in_words).for_each(|line| printer.line(line));
        outputs.write(
            self.common.json.as_deref(),
            &json!({
                "run": self.run,
                "contour_um": evaluate::contour_json(&before.tip),
                "orientation_urad": evaluate::orientation_json(before.orientation.as_ref()),
                "largest_shift_um": written.largest_shift_mm * 1e3,
                "rows": written.rows.map(|rows| rows.json()),
                "offset_mm": matched.offset.as_slice(),
            }),
        )
    }
}
