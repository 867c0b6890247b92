//! `precomp fleet train`: a model for every machine.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::Result;
use clap::{Args, ValueEnum};
use diagnosis::Sensor;
use fleet::{MachineFolder, Store, TrainSettings, baseline_path, finished, model_path, train};
use serde_json::{Map, json};

use super::options::{FleetArgs, failures};
use crate::args::Common;
use crate::files::Files;
use crate::kind::Kind;
use crate::output::write_json;
use crate::print::fleet::{model, model_json};
use crate::{numbers, read};

/// Train a model for every machine of a fleet
///
/// The model is trained on the first days of a machine. The days after them are taken to be healthy: they show how much friction, backlash, lag and the error of
/// the model differ from day to day. A machine with a finished model is passed over, so that a command that was stopped goes on where it was.
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Examples:
  precomp fleet train plant -o models
  precomp fleet train plant -o models --days 3 --healthy-days 10 --only mill-7 mill-8"
)]
pub struct Train {
    #[command(flatten)]
    fleet: FleetArgs,
    #[command(flatten)]
    common: Common,
    /// Folder for the models: NAME.model and NAME.baseline.json for each machine
    #[arg(short, long, value_name = "MODELS")]
    out: PathBuf,
    /// Number of days on which a model is trained: the first ones of its machine
    #[arg(long, value_name = "NUMBER", default_value_t = 2, value_parser = days)]
    days: usize,
    /// Number of days after them that are taken to be healthy
    #[arg(long, value_name = "NUMBER", default_value_t = 8, value_parser = healthy_days)]
    healthy_days: usize,
    /// How the axes are predicted: staged, linear, …, or a recipe file (.toml), as in precomp train
    #[arg(long, value_name = "NAME|TOML", default_value = "staged")]
    predictor: String,
    /// Largest number of samples to train on; of longer logs the stretches of 10 s that show most of their motion are taken
    #[arg(long, value_name = "NUMBER", default_value_t = 120_000, value_parser = numbers::samples)]
    most_samples: usize,
    /// Where the positions of all machines are measured; when left out, as their machine files say
    #[arg(long, value_enum)]
    sensor: Option<SensorName>,
}

/// Where positions are measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum SensorName {
    /// The encoder of the motor: backlash is not seen
    Motor,
    /// A scale at the table
    Table,
}

fn days(text: &str) -> Result<usize, String> {
    numbers::within(text, 1, 365)
}

fn healthy_days(text: &str) -> Result<usize, String> {
    numbers::within(text, 0, 365)
}

impl Train {
    pub fn files(&self) -> Files {
        let machines = Store::new(&self.fleet.folder).machines(&self.fleet.only).unwrap_or_default();
        let paths = machines.iter().flat_map(|machine| {
            let name = &machine.name;
            [model_path(&self.out, name), baseline_path(&self.out, name)]
        });
        let files = self.fleet.files(self.common.json.as_deref()).reads_recipe(&*self.predictor).writes_in("-o", &*self.out);
        paths.fold(files, |files, path| files.writes("-o", &*path, Kind::Model))
    }

    pub fn run(&self) -> Result<()> {
        let machines = Store::new(&self.fleet.folder).machines(&self.fleet.only)?;
        let (settings, printer, began) = (self.settings()?, self.common.printer(), Instant::now());
        let (mut trained, mut kept, mut failed) = (Map::new(), Vec::new(), Vec::new());
        for machine in &machines {
            if finished(&self.out, &machine.name) {
                printer.line(format!("{}: has a model", machine.name));
                kept.push(machine.name.clone());
                continue;
            }
            let started = Instant::now();
            match self.train(machine, &settings) {
                Ok(done) => {
                    let seconds = started.elapsed().as_secs_f64();
                    printer.line(model(&done, seconds));
                    trained.insert(machine.name.clone(), model_json(&done, seconds));
                }
                Err(error) => {
                    let error = format!("{:#}", anyhow::Error::new(error));
                    printer.line(format!("warning: {error}"));
                    failed.push((machine.name.clone(), error));
                }
            }
        }
        let seconds = began.elapsed().as_secs_f64();
        printer.line(format!(
            "{} machines trained, {} had a model, {} failed; {seconds:.1} s",
            trained.len(),
            kept.len(),
            failed.len()
        ));
        let names: Vec<&String> = failed.iter().map(|(name, _)| name).collect();
        let figures = json!({ "trained": trained, "kept": kept, "failed": names, "seconds": seconds });
        write_json(self.common.json.as_deref(), &figures)?;
        Ok(failures("trained", &failed, machines.len())?)
    }

    fn train(&self, machine: &MachineFolder, settings: &TrainSettings) -> Result<fleet::Finished, fleet::FleetError> {
        let shown = self.common.shown();
        train(machine, &self.out, settings, &|event| shown.event(event))
    }

    fn settings(&self) -> Result<TrainSettings> {
        Ok(TrainSettings {
            recipe: read::recipe(&self.predictor)?,
            days: self.days,
            healthy_days: self.healthy_days,
            most_samples: self.most_samples,
            most_samples_a_day: self.fleet.most_samples_a_day,
            sensor: self.sensor.map(|name| match name {
                SensorName::Motor => Sensor::Motor,
                SensorName::Table => Sensor::Table,
            }),
            seed: self.common.seed,
        })
    }
}
