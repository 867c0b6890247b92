//! `precomp measure`: tracking and contour error of a recorded run.

use std::path::PathBuf;

use anyhow::Result;
use clap::{Args, ValueEnum};
use datasets::{Log, LongFile};
use models::Bundle;
use motion::Axis;
use motion::contour::{ContourEstimator, Exact, HermiteFootPoint, MovingWindow, OsculatingCircle, SplineSearch, Tangent};
use pipeline::measure::LongLog;
use pipeline::{Input, Setup, measure};

use crate::args::{Common, LogArgs, ProgramArgs, ReportArgs};
use crate::files::Files;
use crate::kind::Kind;
use crate::output::{Outputs, Printer, Refusal, write_json};
use crate::plot::PlotArgs;
use crate::print::compensation::show_marked;
use crate::print::measurement as print;
use crate::read::{self, Source};
use crate::report::{Group, Run, Track, model_fit, sections};

/// Tracking and contour error of a recorded run
///
/// With --desired the run is laid over that path by itself: a late start, a work offset and a time law of its own are found and taken off.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  precomp measure run.csv
  precomp measure run.csv --desired part.nc --machine mill.toml
  precomp measure run.csv --desired compensated.nc --machine mill.toml --readback
  precomp measure today.csv --model mill.model --report run.html
  precomp measure circle.csv --desired curve:circle --feed 50 --machine mill.toml")]
pub struct Measure {
    /// The log: CSV, Parquet, JSON, NumPy, MATLAB, LabVIEW, halsampler, halscope, TwinCAT Scope, SINUMERIK Edge or trace
    log: PathBuf,
    #[command(flatten)]
    common: Common,
    /// Machine that made the log: a TOML file, a built-in one, or random:SEED; the model's when left out
    #[arg(long, value_name = "TOML")]
    machine: Option<String>,
    #[command(flatten)]
    program: ProgramArgs,
    /// The path that the part needs, where the log's command is a compensated one: program, reference or test curve (`curve:NAME`)
    #[arg(long, value_name = "INPUT")]
    desired: Option<PathBuf>,
    /// Judge the control instead of the machine: what it commanded against what the program --desired, the one that ran, was to make of it
    #[arg(long, requires = "desired", conflicts_with = "report")]
    readback: bool,
    /// Say whether this model still fits the machine: its prediction beside what the log shows
    #[arg(short, long, value_name = "MODEL")]
    model: Option<PathBuf>,
    /// How the contour error is found
    #[arg(long, value_enum, default_value_t = EstimatorName::Exact)]
    estimator: EstimatorName,
    #[command(flatten)]
    columns: LogArgs,
    #[command(flatten)]
    report: ReportArgs,
    #[command(flatten)]
    plot: PlotArgs,
}

/// A contour-error estimator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum EstimatorName {
    /// Newton's method on a spline of the path (default)
    Exact,
    /// Foot point on a Hermite spline (Paper A)
    HermiteFoot,
    /// Search on an interpolated spline (Paper D)
    SplineSearch,
    /// Adaptive window and chords (Paper C)
    MovingWindow,
    /// Osculating circle
    Circle,
    /// Tangent
    Tangent,
}

impl EstimatorName {
    /// The estimator of this name.
    #[must_use]
    pub fn estimator(self) -> Box<dyn ContourEstimator> {
        match self {
            Self::Exact => Box::new(Exact::default()),
            Self::HermiteFoot => Box::new(HermiteFootPoint::default()),
            Self::SplineSearch => Box::new(SplineSearch::default()),
            Self::MovingWindow => Box::new(MovingWindow::default()),
            Self::Circle => Box::new(OsculatingCircle::default()),
            Self::Tangent => Box::new(Tangent::default()),
        }
    }
}

impl Measure {
    pub fn files(&self) -> Files {
        Files::of(self.common.json.as_deref())
            .reads_logs("LOG", [&self.log])
            .reads("--desired", self.desired.as_deref())
            .reads("-m", self.model.as_deref())
            .reads_machine(self.machine.as_deref())
            .writes("--report", self.report.report.as_deref(), Kind::Report)
    }

    pub fn run(&self) -> Result<()> {
        let printer = self.common.printer();
        if self.measures_alone()
            && let Some(file) = read::long_log(&self.log, &self.columns.options())?
            && self.run_long(&file, &printer)?
        {
            return Ok(());
        }
        let log = read::log_to_measure(&self.log, &self.columns.options(), &printer)?;
        let model = self.model.as_deref().map(read::model).transpose()?;
        let desired = self.desired(&log, model.as_ref(), &printer)?;
        note_turned_axes(&log, &desired, &printer);
        let (log, cut_s) = measure::without_approach(&log, desired.desired())?;
        if cut_s[0] + cut_s[1] > 0.0 {
            printer.line(format!("the way to the path and from it was left out: {:.3} s and {:.3} s", cut_s[0], cut_s[1]));
        }
        if self.readback {
            let (found, _) = measure::readback(&log, &desired, self.estimator.estimator().as_mut())?;
            print::show_readback(&printer, &found);
            return write_json(self.common.json.as_deref(), &print::readback_json(&found));
        }
        show_marked(&printer, &desired);
        let measured = measure::measure(&log, &desired, self.estimator.estimator().as_mut())?;
        print::show(&printer, &measured, self.desired.is_some());
        if self.desired.is_some() {
            let (planned, run) = measured.matched.samples_in_motion();
            if let Some(note) = print::other_time(planned * desired.trajectory().period_s(), run * log.period_s()) {
                printer.line(note);
            }
        }
        let mut figures = print::json(&measured);
        let fits = model.map(|model| measure::fits(&model, &log)).transpose()?;
        if let Some(fits) = &fits {
            print::show_fits(&printer, fits);
            figures["model"] = print::fits_json(fits);
        }
        if self.plot.plot {
            let track = Track::of_measured(&desired, &measured, log.period_s());
            self.plot.show(&printer, &track, &[Run::measured("run", &track, &desired, &log, &measured)?]);
        }
        let mut outputs = Outputs::default();
        let title = format!("Run recorded in {}", log.name);
        let lead = "What the axes did, as their encoders saw it, beside what was asked of them.";
        self.report.add(&mut outputs, &printer, (&title, lead), || {
            let track = Track::of_measured(&desired, &measured, log.period_s());
            let mut all = sections(&track, &[Run::measured("run", &track, &desired, &log, &measured)?]);
            all.extend(fits.as_deref().map(model_fit));
            Ok(vec![Group { name: desired.name().to_owned(), sections: all }])
        })?;
        outputs.write(self.common.json.as_deref(), &figures)
    }

    /// Whether only figures of the log against its own command are asked for: these do not need the whole log at once.
    fn measures_alone(&self) -> bool {
        self.desired.is_none() && self.report.report.is_none() && matches!(self.estimator, EstimatorName::Exact)
    }

    /// Measures a long log in pieces; `false` where that cannot be done.
    fn run_long(&self, file: &LongFile, printer: &Printer) -> Result<bool> {
        let model = self.model.as_deref().map(read::model).transpose()?;
        let machine = read::real_machine(self.machine.as_deref(), self.model.as_deref().zip(model.as_ref()))?;
        let setup = machine.as_ref().map(|(machine, _)| Setup::new(machine, None)).transpose()?;
        let Some((log, findings)) = LongLog::new(file, setup.as_ref(), None)? else { return Ok(false) };
        let mut report = file.report.clone();
        report.extend(findings);
        read::fit_to_measure(&self.log, &report, printer)?;
        let turned = |axis: &&Axis| axis.slot() >= Some(3);
        note_turned(&file.axes().iter().filter(turned).collect::<Vec<_>>(), printer);
        let (measured, fits) = log.measure(model.as_ref())?;
        print::show(printer, &measured, false);
        let mut figures = print::json(&measured);
        if let Some(fits) = &fits {
            print::show_fits(printer, fits);
            figures["model"] = print::fits_json(fits);
        }
        write_json(self.common.json.as_deref(), &figures)?;
        Ok(true)
    }

    /// The path to measure against: what --desired says, or the log's own command.
    fn desired(&self, log: &Log, model: Option<&Bundle>, printer: &Printer) -> Result<Input> {
        let machine = read::real_machine(self.machine.as_deref(), self.model.as_deref().zip(model))?;
        let setup = machine.as_ref().map(|(machine, _)| Setup::new(machine, None)).transpose()?;
        let Some(path) = &self.desired else {
            return Ok(Input::reference("command", log.reference.clone(), setup.as_ref())?);
        };
        let desired = match (Source::open(path)?.into_reference(), machine.zip(setup.clone())) {
            (Ok(reference), _) => Input::reference(path.display().to_string(), reference, setup.as_ref())?,
            (Err(source), Some(((_, which), setup))) => {
                printer.line(format!("{} is planned for the {which}", path.display()));
                // Planned at the log's own rate, so that samples pair up.
                let setup = Setup { period_s: log.period_s(), ..setup };
                source.on(&setup, &self.program.settings(), self.program.feed)?
            }
            (Err(_), None) => return Err(read::machine_wanted(&format!("{} has to be planned for a machine", path.display()))),
        };
        desired.trajectory().check_axes(log.axes()).map_err(|error| {
            Refusal(format!("path and log: {error}; give the machine that has the log's axes with --machine"))
        })?;
        Ok(desired)
    }
}

/// Says which rotary axes of a log are taken to turn nothing.
fn note_turned_axes(log: &Log, desired: &Input, printer: &Printer) {
    if !desired.desired().kinematics().has_rotary_axes() {
        note_turned(&log.axes().iter().filter(|axis| axis.slot() >= Some(3)).collect::<Vec<_>>(), printer);
    }
}

fn note_turned(axes: &[&Axis], printer: &Printer) {
    if !axes.is_empty() {
        let names: Vec<&str> = axes.iter().map(|axis| axis.name.as_str()).collect();
        printer.line(format!(
            "note: axes {} are taken to turn neither tool nor workpiece; say how they do with --machine",
            names.join(", ")
        ));
    }
}
