//! `precomp fleet watch`: what changes from day to day.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::Result;
use chrono::NaiveDate;
use clap::Args;
use fleet::{AxisDay, Limits, Store, WatchSettings, baseline_path, content, model_path, watch};

use super::options::{FleetArgs, failures};
use crate::args::Common;
use crate::files::Files;
use crate::kind::Kind;
use crate::numbers;
use crate::output::Outputs;
use crate::print::fleet::{alarms, summary, watch_json};

/// Show what changes on every machine from day to day: error of its model, friction, backlash, lag
///
/// A change is an alarm where it exceeds what the healthy days and the accepted rate of false alarms allow. Days of the training and healthy days give no alarm.
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Examples:
  precomp fleet watch plant -m models -o watch.parquet
  precomp fleet watch plant -m models -o today.parquet --since 2026-11-24 --json alarms.json"
)]
pub struct Watch {
    #[command(flatten)]
    fleet: FleetArgs,
    #[command(flatten)]
    common: Common,
    /// Folder of the models that precomp fleet train wrote
    #[arg(short, long, value_name = "MODELS")]
    models: PathBuf,
    /// Table to write (.parquet): a row for every machine, day and axis
    #[arg(short, long, value_name = "PARQUET")]
    out: PathBuf,
    /// Leave out the days before this one
    #[arg(long, value_name = "DATE")]
    since: Option<NaiveDate>,
    /// Accepted false alarms of a machine in 30 days
    #[arg(long, value_name = "NUMBER", default_value_t = 0.5, value_parser = false_alarms)]
    false_alarms: f64,
}

fn false_alarms(text: &str) -> Result<f64, String> {
    numbers::within(text, 1e-6, 100.0)
}

impl Watch {
    pub fn files(&self) -> Files {
        let machines = Store::new(&self.fleet.folder).machines(&self.fleet.only).unwrap_or_default();
        let read = machines.iter().flat_map(|machine| {
            let name = &machine.name;
            [model_path(&self.models, name), baseline_path(&self.models, name)]
        });
        let files = self.fleet.files(self.common.json.as_deref()).writes("-o", &*self.out, Kind::Table);
        read.fold(files, |files, path| files.reads("-m", &*path))
    }

    pub fn run(&self) -> Result<()> {
        let machines = Store::new(&self.fleet.folder).machines(&self.fleet.only)?;
        let settings = WatchSettings {
            limits: Limits { false_alarms_per_month: self.false_alarms },
            since: self.since.map(|date| date.to_string()),
            most_samples_a_day: self.fleet.most_samples_a_day,
        };
        let (printer, started) = (self.common.printer(), Instant::now());
        let (mut rows, mut failed) = (Vec::<AxisDay>::new(), Vec::new());
        for machine in &machines {
            match watch(machine, &self.models, &settings) {
                Ok(found) => rows.extend(found),
                Err(error) => failed.push((machine.name.clone(), format!("{:#}", anyhow::Error::new(error)))),
            }
        }
        if machines.len() == failed.len() {
            return Ok(failures("watched", &failed, machines.len())?);
        }
        printer.line(summary(&rows));
        alarms(&rows).iter().for_each(|line| printer.line(line));
        let seconds = started.elapsed().as_secs_f64();
        printer.line(format!("{} machines in {seconds:.1} s; table in {}", machines.len() - failed.len(), self.out.display()));
        let mut outputs = Outputs::default();
        outputs.add(&self.out, content(&rows)?);
        outputs.write(self.common.json.as_deref(), &watch_json(&rows, seconds))?;
        Ok(failures("watched", &failed, machines.len())?)
    }
}
