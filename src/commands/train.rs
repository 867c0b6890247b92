//! `precomp train`: learn a machine from its logs.

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::{Args, ValueEnum};
use datasets::{Log, Severity};
use models::FeatureSet;

use crate::adaptation;
use crate::cli::{Common, LogArgs};
use crate::files::Files;
use crate::input;
use crate::output::{Outputs, Printer, Refusal, table};
use crate::training_run::{self, TrainSettings};

/// Learn how a machine's axes lag, stick and snap back, from logs of commanded and actual positions
///
/// One file is one run. Whole runs are held out; the figures printed are of those.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  precomp train runs/*.csv --machine mill.toml -o mill.model
  precomp train ten-seconds.csv --from mill.model -o mill-today.model
  precomp train log.csv --columns t=time_s,x_ref=x_cmd_mm,x_act=x_act_mm -o x.model")]
pub struct Train {
    /// Logs, one a run: CSV, Parquet, halsampler, halscope, TwinCAT Scope, SINUMERIK Edge or trace
    #[arg(required = true)]
    logs: Vec<PathBuf>,
    #[command(flatten)]
    common: Common,
    /// The model to write
    #[arg(short, long, value_name = "MODEL")]
    out: PathBuf,
    /// Machine whose limits and kinematics go into the model: a TOML file, or a built-in one; taken from the log when left out
    #[arg(long, value_name = "TOML")]
    machine: Option<String>,
    /// How the axes are predicted: staged, linear, lstm, lstm-paper, gru, gru-paper, narx, or a recipe file (.toml)
    #[arg(long, value_name = "NAME|TOML", default_value = "staged")]
    predictor: String,
    /// Features of the networks (Paper D, table II)
    #[arg(long, value_enum, default_value_t = FeatureName::Iii)]
    features: FeatureName,
    #[command(flatten)]
    columns: LogArgs,
    /// Share of the samples that is held out, as whole runs
    #[arg(long, default_value_t = 0.2)]
    held_out: f64,
    /// Adapt this model with a short new log instead of training a new one: another machine of its kind, another day
    #[arg(long, value_name = "MODEL", conflicts_with_all = ["predictor", "features", "held_out", "checkpoints", "machine"])]
    from: Option<PathBuf>,
    /// Folder for checkpoints of the networks; an interrupted training goes on from there
    #[arg(long, value_name = "DIR")]
    checkpoints: Option<PathBuf>,
}

/// Features of the networks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum FeatureName {
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
            .reads_machine(self.machine.as_deref())
            .reads_recipe(&*self.predictor)
            .reads("--from", self.from.as_deref())
            .writes("-o", &*self.out)
            .writes_in("--checkpoints", self.checkpoints.as_deref())
    }

    pub fn run(&self) -> Result<()> {
        let printer = Printer::new(self.common.json.as_deref());
        let spec = self.machine.as_deref().map(input::machine).transpose()?;
        let mut logs: Vec<Log> = Vec::with_capacity(self.logs.len());
        let mut warnings = Vec::new();
        for path in &self.logs {
            let (log, report) = input::log(path, &self.columns)?;
            if let Some(reason) = report.of(Severity::Refuse).next() {
                return Err(Refusal(format!("{}: {reason}", path.display())).into());
            }
            warnings.extend(report.findings.into_iter().map(|finding| format!("{}: {finding}", path.display())));
            logs.push(log);
        }
        let (logs, joined) = datasets::joined(logs);
        warnings.extend(joined.iter().map(ToString::to_string));
        warnings.extend(
            training_run::check(&logs).findings.iter().filter(|f| f.severity != Severity::Refuse).map(ToString::to_string),
        );
        for warning in &warnings {
            printer.line(warning);
        }
        if let Some(model) = &self.from {
            return self.adapt(model, &logs, &warnings, &printer);
        }
        let settings = TrainSettings {
            recipe: input::recipe(&self.predictor)?.with_features(self.features.into()),
            held_out: self.held_out,
            seed: self.common.seed,
            checkpoints: self.checkpoints.clone(),
        };
        let trained = training_run::train(&logs, spec.as_ref(), &settings)?;
        printer.line(trained.table());
        for note in &trained.notes {
            printer.line(note);
        }
        if spec.is_none() {
            printer.line("note: no --machine was given; the model takes speed and acceleration limits from what the log reached");
        }
        let lags: Vec<String> = trained
            .bundle
            .manifest
            .axes
            .iter()
            .zip(&trained.lags_s)
            .filter_map(|(axis, lag)| Some(format!("{} {:.3} ms", axis.name, (*lag)? * 1e3)))
            .collect();
        printer.line(format!(
            "lag behind the command: {}; all axes together {:.3} ms",
            lags.join(", "),
            trained.bundle.manifest.common_delay_s * 1e3
        ));
        for axis in &trained.bundle.manifest.axes {
            let c = &axis.coverage;
            printer.line(format!(
                "coverage of {}: position {:.3} to {:.3}, speed to {:.2}, acceleration to {:.1}, {} reversals, {} starts, {:.1} s at rest",
                axis.name, c.position.0, c.position.1, c.velocity, c.acceleration, c.reversals, c.starts, c.dwell_s
            ));
        }
        let doubts = trained.doubts()?;
        doubts.iter().for_each(|doubt| printer.line(format!("warning: {doubt}")));
        warnings.extend(doubts);
        let mut outputs = Outputs::default();
        outputs.add(&self.out, trained.bundle.to_bytes()?);
        printer.line(format!("trained in {:.1} s; model in {}", trained.seconds, self.out.display()));
        let mut figures = trained.json();
        figures["warnings"] = serde_json::json!(warnings);
        outputs.write(self.common.json.as_deref(), &figures)
    }

    fn adapt(&self, model: &Path, logs: &[Log], warnings: &[String], printer: &Printer) -> Result<()> {
        let adapted = adaptation::adapt(&input::model(model)?, logs, self.common.seed)?;
        let rows: Vec<Vec<String>> = adapted
            .axes
            .iter()
            .map(|axis| {
                let verdict = if axis.taken { "adapted" } else { "kept as it was" };
                let unit = axis.unit;
                vec![unit.label(&axis.name), unit.number(axis.before), unit.number(axis.held_out), verdict.to_owned()]
            })
            .collect();
        printer.line(table(&["axis", "error before RMS", "adapted, held out RMS", ""], &rows));
        let mut outputs = Outputs::default();
        outputs.add(&self.out, adapted.bundle.to_bytes()?);
        printer.line(format!("adapted in {:.1} s; model in {}", adapted.seconds, self.out.display()));
        let axes: serde_json::Map<String, serde_json::Value> = adapted
            .axes
            .iter()
            .map(|axis| {
                let figures = serde_json::json!({
                    axis.unit.key("before_rms"): axis.unit.value(axis.before),
                    axis.unit.key("held_out_rms"): axis.unit.value(axis.held_out),
                    "adapted": axis.taken,
                });
                (axis.name.clone(), figures)
            })
            .collect();
        let figures = serde_json::json!({ "seconds": adapted.seconds, "axes": axes, "warnings": warnings });
        outputs.write(self.common.json.as_deref(), &figures)
    }
}
