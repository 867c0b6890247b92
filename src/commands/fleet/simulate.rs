//! `precomp fleet simulate`: logs of random machines.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::Result;
use chrono::NaiveDate;
use clap::Args;
use fleet::{Fault, SimulatedFleet, machine_name};
use serde_json::json;

use crate::args::Common;
use crate::files::Files;
use crate::numbers;
use crate::output::write_json;

/// Write the logs of simulated machines: random ones, each with other motion on every day, at 500 Hz
///
/// The machines are random:SEED, random:SEED+1, … with the `--seed` of the command. Their files machine.toml describe them without faults.
#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Examples:
  precomp fleet simulate plant --machines 3 --minutes 2 --days 12
  precomp fleet simulate plant --machines 3 --minutes 2 --days 12 --fault 2:x:friction=20@11 1:y:backlash=5@12"
)]
pub struct Simulate {
    /// Folder to write; machines that are there already are not overwritten
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    #[command(flatten)]
    common: Common,
    /// Number of machines
    #[arg(long, value_name = "NUMBER", default_value_t = 3, value_parser = machines)]
    machines: usize,
    /// Minutes of motion of each machine a day
    #[arg(long, value_name = "MINUTES", default_value_t = 2.0, value_parser = minutes)]
    minutes: f64,
    /// Number of days
    #[arg(long, value_name = "NUMBER", default_value_t = 12, value_parser = days)]
    days: usize,
    /// First day
    #[arg(long, value_name = "DATE", default_value = "2026-01-01")]
    first: NaiveDate,
    /// Fault MACHINE:AXIS:KIND=SIZE@DAY of one axis from a day on, machine and day counted from 1: friction in percent, backlash in µm, gain (of the
    /// position loop) in percent
    #[arg(long, value_name = "FAULT", num_args = 1..)]
    fault: Vec<Fault>,
}

fn machines(text: &str) -> Result<usize, String> {
    numbers::within(text, 1, 100_000)
}

fn minutes(text: &str) -> Result<f64, String> {
    numbers::within(text, 0.2, 1440.0)
}

fn days(text: &str) -> Result<usize, String> {
    numbers::within(text, 1, 3660)
}

impl Simulate {
    pub fn files(&self) -> Files {
        Files::of(self.common.json.as_deref()).writes_in("DIR", &*self.folder)
    }

    pub fn run(&self) -> Result<()> {
        let plan = SimulatedFleet {
            machines: self.machines,
            minutes: self.minutes,
            days: self.days,
            first: self.first,
            seed: self.common.seed,
            faults: self.fault.clone(),
        };
        plan.check(&self.folder)?;
        let (printer, started) = (self.common.printer(), Instant::now());
        let mut names = Vec::new();
        for index in 0..self.machines {
            let name = machine_name(self.common.seed.wrapping_add(index as u64));
            plan.write_machine(&self.folder, index, &mut |date| {
                if self.common.verbose {
                    eprintln!("{name} {date}");
                }
            })?;
            printer.line(format!("{name}: {} days", self.days));
            names.push(name);
        }
        let seconds = started.elapsed().as_secs_f64();
        printer.line(format!("{} machines in {}, {seconds:.1} s", self.machines, self.folder.display()));
        let faults: Vec<String> = self.fault.iter().map(ToString::to_string).collect();
        write_json(
            self.common.json.as_deref(),
            &json!({ "machines": names, "days": self.days, "faults": faults, "seconds": seconds }),
        )
    }
}
