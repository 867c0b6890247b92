//! `precomp demo`: the whole story on the built-in simulated machine.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::Result;
use clap::Args;
use datasets::Log;
use serde_json::json;

use super::compare::report_of;
use crate::cli::{Common, MachineArgs};
use crate::comparison::{self, CompareSettings, FEED_MM_S, Plant, UNSEEN, UNSEEN_TURNED};
use crate::files::Files;
use crate::input::{self, Frame, Input};
use crate::output::{Outputs, Printer};
use crate::recording::{TRAVEL_MM, record};
use crate::report::report_page;
use crate::training_run::{self, TrainSettings};

/// The whole story on a simulated machine: excite, train, compensate unseen curves, compare with learning on the machine
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  precomp demo --out demo")]
pub struct Demo {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    machine: MachineArgs,
    /// Folder for the model, the report and the figures
    #[arg(long, value_name = "DIR", default_value = "precomp-demo")]
    out: PathBuf,
    /// How the axes are predicted: staged, linear, lstm, lstm-paper, gru, gru-paper, narx, or a recipe file (.toml)
    #[arg(long, value_name = "NAME|TOML", default_value = "staged")]
    predictor: String,
    /// Seconds of excitation
    #[arg(long, default_value_t = 120.0)]
    seconds: f64,
    /// Noise seeds over which figures are averaged
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    seeds: u64,
}

/// Names of the files in the folder `--out`.
const MODEL: &str = "machine.model";
const REPORT: &str = "report.html";

impl Demo {
    pub fn files(&self) -> Files {
        Files::of(self.common.json.as_deref())
            .reads_machine(&*self.machine.machine)
            .reads_recipe(&*self.predictor)
            .writes("the model of --out", &*self.out.join(MODEL))
            .writes("the report of --out", &*self.out.join(REPORT))
    }

    pub fn run(&self) -> Result<()> {
        let printer = Printer::new(self.common.json.as_deref());
        let started = Instant::now();
        let spec = input::machine(&self.machine.machine)?;
        let frame = Frame::of(&spec)?;
        let logs = record(&spec, self.seconds, TRAVEL_MM, self.common.seed)?;
        let samples: usize = logs.iter().map(Log::len).sum();
        printer.line(format!("1. excited the machine `{}`: {} runs, {samples} samples", spec.name, logs.len()));
        let settings = TrainSettings::of(input::recipe(&self.predictor)?, self.common.seed);
        let trained = training_run::train(&logs, Some(&spec), &settings)?;
        printer.line(format!("2. trained in {:.1} s", trained.seconds));
        printer.line(trained.table());
        let model = self.out.join(MODEL);
        let mut outputs = Outputs::default();
        outputs.add(&model, trained.bundle.to_bytes()?);
        let unseen = if frame.kinematics.turns() { &UNSEEN_TURNED[..] } else { &UNSEEN[..] };
        printer.line(format!("3. compensated {} curves that training never saw, and ran them", unseen.len()));
        let paths: Vec<Input> = unseen.iter().map(|name| Input::curve(name, FEED_MM_S, &frame)).collect::<Result<_>>()?;
        let settings = CompareSettings { seeds: self.seeds, seed: self.common.seed, ..CompareSettings::default() };
        let plant = Plant::Simulated(&spec);
        let results = comparison::compare(&paths, plant, Some(&trained.bundle), &settings)?;
        printer.line(comparison::render(&results, &settings));
        printer.line("4. the same curves as G-code programs of short lines, whose time the control plans itself");
        let (programs, tuned) = comparison::compare_programs(unseen, plant, Some(&trained.bundle), &settings, &results.tuned)?;
        printer.line(comparison::render_programs(&programs, &tuned, &settings));
        let report = self.out.join(REPORT);
        outputs.add(&report, report_page("precomp demo", &report_of(&results.paths)?)?);
        printer.line(format!(
            "model in {}, report in {}; {:.0} s in all",
            model.display(),
            report.display(),
            started.elapsed().as_secs_f64()
        ));
        let mut figures = comparison::json(&results, &settings);
        figures["programs"] = comparison::programs_json(&programs, &tuned, &settings);
        figures["train"] = trained.json();
        figures["seconds"] = json!(started.elapsed().as_secs_f64());
        outputs.write(self.common.json.as_deref(), &figures)
    }
}
