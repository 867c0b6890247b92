//! `precomp train`: learn a machine from its logs.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Result;
use clap::{Args, ValueEnum};
use datasets::{Log, LongFile, Recording, Severity};
use machine::MachineSpec;
use models::FeatureSet;
use pipeline::identification::{Identified, KnownRun, identify};
use pipeline::machine_of;
use pipeline::training::{self, HELD_OUT, MOST_SAMPLES, TrainSettings, Trained};

use super::diagnose;
use crate::args::{Common, LogArgs, ReportArgs};
use crate::date;
use crate::files::Files;
use crate::kind::Kind;
use crate::numbers;
use crate::output::{Outputs, Printer, Refusal, Usage, read_file};
use crate::print::{identification, training as print};
use crate::progress::Shown;
use crate::read;
use crate::report::{Group, adaptation, held_out, known, trained_range};

/// Learn how a machine's axes lag, stick and snap back, from logs of commanded and actual positions
///
/// One file is one run. Whole runs are held out; the figures printed are of those.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  precomp train runs/*.csv --machine mill.toml -o mill.model
  precomp train runs/*.csv --programs excitation/*.nc -o mill.model
  precomp train ten-seconds.csv --from mill.model -o mill-today.model
  precomp train log.csv --columns t=time_s,x_ref=x_cmd_mm,x_act=x_act_mm -o x.model")]
pub struct Train {
    /// Logs, one a run: CSV, Parquet, JSON, NumPy, MATLAB, LabVIEW, halsampler, halscope, TwinCAT Scope, SINUMERIK Edge or trace
    #[arg(required = true)]
    logs: Vec<PathBuf>,
    #[command(flatten)]
    common: Common,
    /// The model to write
    #[arg(short, long, value_name = "MODEL")]
    out: PathBuf,
    /// Machine whose limits and kinematics go into the model: a TOML file, a built-in one, or random:SEED; taken from the log when left out
    #[arg(long, value_name = "TOML")]
    machine: Option<String>,
    /// Programs that ran while logs were recorded, paired with them by name (`part.nc` and `part.csv`): from these the control is
    /// learned, how it accelerates and passes corners, so that programs are planned as it will command them
    #[arg(long, value_name = "FILE", num_args = 1..)]
    programs: Vec<PathBuf>,
    /// How the axes are predicted: staged, linear, lstm, lstm-paper, gru, gru-paper, narx, or a recipe file (.toml)
    #[arg(long, value_name = "NAME|TOML", default_value = "staged")]
    predictor: String,
    /// Features of the networks (Paper D, table II) [default: iii]
    #[arg(long, value_enum)]
    features: Option<FeatureName>,
    #[command(flatten)]
    columns: LogArgs,
    /// Share of the samples that is held out, as whole runs
    #[arg(long, default_value_t = HELD_OUT, value_parser = numbers::held_out)]
    held_out: f64,
    /// Largest number of samples to train on; of longer logs the stretches of 10 s that show most of their motion are taken
    #[arg(long, value_name = "NUMBER", default_value_t = MOST_SAMPLES, value_parser = numbers::samples)]
    most_samples: usize,
    /// Adapt this model with a short new log instead of training a new one: another machine of its kind, another day
    #[arg(long, value_name = "MODEL", conflicts_with_all = ["predictor", "features", "held_out", "most_samples", "checkpoints", "machine", "programs"])]
    from: Option<PathBuf>,
    /// Folder for checkpoints of the networks; an interrupted training goes on from there
    #[arg(long, value_name = "DIR")]
    checkpoints: Option<PathBuf>,
    #[command(flatten)]
    report: ReportArgs,
}

/// Features of the networks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FeatureName {
    /// Past velocities
    I,
    /// Position, velocity, acceleration
    Ii,
    /// Velocities around the sample, backlash flag, start flag
    Iii,
}

impl From<FeatureName> for FeatureSet {
    fn from(name: FeatureName) -> Self {
        match name {
            FeatureName::I => Self::I,
            FeatureName::Ii => Self::Ii,
            FeatureName::Iii => Self::Iii,
        }
    }
}

impl Train {
    pub fn files(&self) -> Files {
        Files::of(self.common.json.as_deref())
            .reads_logs("LOG", &self.logs)
            .reads_all("--programs", &self.programs)
            .reads_machine(self.machine.as_deref())
            .reads_recipe(&*self.predictor)
            .reads("--from", self.from.as_deref())
            .writes("-o", &*self.out, Kind::Model)
            .writes("--report", self.report.report.as_deref(), Kind::Report)
            .writes_in("--checkpoints", self.checkpoints.as_deref())
    }

    pub fn run(&self) -> Result<()> {
        let printer = self.common.printer();
        let machine = self.machine.as_deref().map(read::machine).transpose()?;
        if let Some((recordings, warnings)) = self.long_recordings()? {
            return self.run_on_stretches(&recordings, warnings, machine.as_ref(), &printer);
        }
        let (logs, mut warnings) = self.logs()?;
        let programs = self.programs_of(&logs)?;
        let (logs, joined) = datasets::joined(logs.concat());
        warnings.extend(joined.iter().map(ToString::to_string));
        let found = training::check(&logs).findings;
        warnings.extend(found.iter().filter(|f| f.severity != Severity::Refuse).map(ToString::to_string));
        warnings.iter().for_each(|warning| printer.line(warning));
        if let Some(model) = &self.from {
            return self.adapt(model, &logs, &warnings, &printer);
        }
        let (started, shown) = (Instant::now(), self.common.shown());
        let control = self.control(&programs, machine.as_ref(), &shown)?;
        let identified_s = started.elapsed().as_secs_f64();
        if let Some(control) = &control {
            identification::show(&printer, control, identified_s);
            warnings.extend(identification::warning(control));
        }
        let given = machine.clone().filter(|_| control.is_none());
        let machine = control.as_ref().map(|control| control.machine.clone()).or(machine);
        let today = date::today()?;
        let mut trained = training::train(&logs, machine.as_ref(), &self.settings()?, &|event| shown.event(event))?;
        trained.bundle.manifest.date = Some(today);
        trained.bundle.manifest.control = control.as_ref().map(Identified::summary);
        let seconds = started.elapsed().as_secs_f64();
        if let Some(unreached) = given.as_ref().and_then(|machine| training::unreached(&trained.bundle, machine)) {
            let warning = print::unreached(&unreached);
            printer.line(format!("warning: {warning}"));
            warnings.push(warning);
        }
        let control = control.map_or(serde_json::Value::Null, |control| identification::json(&control, identified_s));
        self.write(&trained, &logs, (seconds, control), warnings, &printer)
    }

    /// Prints what was found, and writes the model.
    fn write(
        &self,
        trained: &Trained,
        logs: &[Log],
        (seconds, control): (f64, serde_json::Value),
        mut warnings: Vec<String>,
        printer: &Printer,
    ) -> Result<()> {
        show(printer, trained);
        let doubts: Vec<String> = trained.doubts()?.iter().map(ToString::to_string).collect();
        doubts.iter().for_each(|doubt| printer.line(format!("warning: {doubt}")));
        warnings.extend(doubts);
        let mut outputs = Outputs::default();
        outputs.add(&self.out, trained.bundle.to_bytes()?);
        printer.line(format!("trained in {seconds:.1} s; model in {}", self.out.display()));
        self.report.add(&mut outputs, printer, (&self.title(), LEAD), || {
            let machine = machine_of(&trained.bundle)?;
            Ok(vec![model_group(trained, logs), diagnose::group(trained.runs(logs), Some(&machine))])
        })?;
        let mut figures = print::json(trained, seconds);
        figures["warnings"] = serde_json::json!(warnings);
        figures["control"] = control;
        outputs.write(self.common.json.as_deref(), &figures)
    }

    /// The logs and what was found in them, where one of them is read in pieces: a new model of more samples than are trained on, without programs.
    fn long_recordings(&self) -> Result<Option<(Vec<Recording>, Vec<String>)>> {
        if self.from.is_some() || !self.programs.is_empty() {
            return Ok(None);
        }
        let options = self.columns.options();
        let mut files: Vec<Option<LongFile>> = Vec::with_capacity(self.logs.len());
        for path in &self.logs {
            files.push(read::long_log(path, &options)?);
        }
        let samples: usize = files.iter().flatten().map(LongFile::len).sum();
        if samples <= self.most_samples {
            return Ok(None);
        }
        let (mut recordings, mut warnings) = (Vec::new(), Vec::new());
        for (path, file) in self.logs.iter().zip(files) {
            let Some(file) = file else {
                let (runs, found) = self.runs(path)?;
                recordings.extend(runs.into_iter().map(Recording::Held));
                warnings.extend(found);
                continue;
            };
            warnings.extend(file.report.findings.iter().map(|finding| format!("{}: {finding}", path.display())));
            recordings.push(Recording::File(file));
        }
        Ok(Some((recordings, warnings)))
    }

    fn run_on_stretches(
        &self,
        recordings: &[Recording],
        warnings: Vec<String>,
        machine: Option<&MachineSpec>,
        printer: &Printer,
    ) -> Result<()> {
        warnings.iter().for_each(|warning| printer.line(warning));
        let (started, shown) = (Instant::now(), Shown::default());
        let today = date::today()?;
        let mut trained = training::train_on_stretches(recordings, machine, &self.settings()?, &|event| shown.event(event))?;
        trained.bundle.manifest.date = Some(today);
        drop(shown);
        let seconds = started.elapsed().as_secs_f64();
        self.write(&trained, &[], (seconds, serde_json::Value::Null), warnings, printer)
    }

    /// Title of the report.
    fn title(&self) -> String {
        format!("Model {}", file_name(&self.out))
    }

    /// The runs of every log, and what was found in them.
    fn logs(&self) -> Result<(Vec<Vec<Log>>, Vec<String>)> {
        let found = self.logs.iter().map(|path| self.runs(path)).collect::<Result<Vec<_>>>()?;
        let (logs, warnings): (Vec<_>, Vec<_>) = found.into_iter().unzip();
        Ok((logs, warnings.concat()))
    }

    /// The runs of a log, and what was found in them.
    fn runs(&self, path: &Path) -> Result<(Vec<Log>, Vec<String>)> {
        let (logs, report) = read::runs(path, &self.columns.options())?;
        if let Some(reason) = report.of(Severity::Refuse).next() {
            return Err(Refusal(format!("{}: {reason}", path.display())).into());
        }
        let warnings = report.findings.into_iter().map(|finding| format!("{}: {finding}", path.display()));
        Ok((logs, warnings.collect()))
    }

    /// Every program with the log of its run: the file of the same name but for its ending.
    fn programs_of(&self, logs: &[Vec<Log>]) -> Result<Vec<(Vec<u8>, Log)>> {
        let pair = |program: &PathBuf| {
            let runs = self.logs.iter().zip(logs).find(|(log, _)| stem(log) == stem(program));
            let Some((path, runs)) = runs else {
                let (program, stem) = (program.display(), stem(program).unwrap_or_default());
                return Err(
                    Usage(format!("no log belongs to {program}; give the log of its run the same name: {stem}.csv")).into()
                );
            };
            let [log] = &runs[..] else {
                let why = "its time stamps have gaps; log the whole run of a program, or train without --programs";
                return Err(Refusal(format!("{}: {why}", path.display())).into());
            };
            Ok((read_file(program)?, Log { name: file_name(program), ..log.clone() }))
        };
        self.programs.iter().map(pair).collect()
    }

    /// The control that ran the programs.
    fn control(&self, programs: &[(Vec<u8>, Log)], machine: Option<&MachineSpec>, shown: &Shown) -> Result<Option<Identified>> {
        if programs.is_empty() {
            return Ok(None);
        }
        let named = programs.iter().map(|(program, log)| KnownRun { name: log.name.clone(), program: program.clone(), log });
        let runs: Vec<KnownRun<'_>> = named.collect();
        Ok(Some(identify(&runs, machine, &|event| shown.event(event))?))
    }

    fn settings(&self) -> Result<TrainSettings> {
        let recipe = read::recipe(&self.predictor)?;
        if recipe.network.is_none() && (self.features.is_some() || self.checkpoints.is_some()) {
            let why = format!("--features and --checkpoints are of networks, and `{}` has none", self.predictor);
            return Err(Usage(format!("{why}; leave them out, or choose --predictor lstm, gru or narx")).into());
        }
        Ok(TrainSettings {
            recipe: recipe.with_features(self.features.unwrap_or(FeatureName::Iii).into()),
            held_out: self.held_out,
            most_samples: self.most_samples,
            seed: self.common.seed,
            checkpoints: self.checkpoints.clone(),
        })
    }

    fn adapt(&self, model: &Path, logs: &[Log], warnings: &[String], printer: &Printer) -> Result<()> {
        let started = Instant::now();
        let today = date::today()?;
        let mut adapted = training::adapt(&read::model(model)?, logs, self.common.seed)?;
        adapted.bundle.manifest.date = Some(today);
        let seconds = started.elapsed().as_secs_f64();
        printer.line(print::adapted(&adapted));
        let mut outputs = Outputs::default();
        outputs.add(&self.out, adapted.bundle.to_bytes()?);
        printer.line(format!("adapted in {seconds:.1} s; model in {}", self.out.display()));
        self.report.add(&mut outputs, printer, (&self.title(), LEAD), || {
            let (name, bundle) = ("Model".to_owned(), &adapted.bundle);
            let sections = vec![adaptation(&adapted), known(bundle), trained_range(bundle)];
            Ok(vec![Group { name, sections }, diagnose::group(logs, Some(&machine_of(bundle)?))])
        })?;
        outputs.write(self.common.json.as_deref(), &print::adapted_json(&adapted, seconds, warnings))
    }
}

/// What the report shows.
const LEAD: &str = "How the axes lag and stick, how well the model predicts that on runs that it was not fitted to, and in which range it holds.";

/// What the report shows of a model and the logs that it was trained on.
pub fn model_group(trained: &Trained, logs: &[Log]) -> Group {
    let mut sections = vec![known(&trained.bundle)];
    sections.extend(held_out(trained, trained.runs(logs)));
    sections.push(trained_range(&trained.bundle));
    Group { name: "Model".to_owned(), sections }
}

/// Name of a file without its last ending.
fn stem(path: &Path) -> Option<String> {
    Some(path.file_stem()?.to_string_lossy().into_owned())
}

fn file_name(path: &Path) -> String {
    path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

fn show(printer: &Printer, trained: &Trained) {
    print::stretches(trained).iter().for_each(|line| printer.line(line));
    printer.line(print::held_out(&trained.bundle));
    trained.notes.iter().for_each(|note| printer.line(note));
    if trained.bundle.manifest.limits_from_log {
        printer.line("note: no --machine was given; the model takes speed and acceleration limits from what the log reached");
    }
    printer.line(print::lags(trained));
    print::coverage(&trained.bundle).iter().for_each(|line| printer.line(line));
}
