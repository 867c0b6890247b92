//! `precomp fleet`: the logs of many machines.

mod options;
mod simulate;
mod train;
mod watch;

use anyhow::Result;
use clap::{Args, Subcommand};

use crate::files::Files;

/// The logs of many machines: a model for each of them, and what changes on it from day to day
///
/// Logs are Parquet files under DIR/machine=NAME/date=YYYY-MM-DD/. A machine file DIR/machine=NAME/machine.toml, if there is one, states limits, kinematics and
/// sensor of the machine.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  precomp fleet simulate plant --machines 3 --minutes 2 --days 12 --fault 2:x:friction=20@11
  precomp fleet train plant -o models
  precomp fleet watch plant -m models -o watch.parquet")]
pub struct Fleet {
    #[command(subcommand)]
    job: Job,
}

#[derive(Debug, Subcommand)]
enum Job {
    Simulate(simulate::Simulate),
    Train(train::Train),
    Watch(watch::Watch),
}

impl Fleet {
    pub fn files(&self) -> Files {
        match &self.job {
            Job::Simulate(job) => job.files(),
            Job::Train(job) => job.files(),
            Job::Watch(job) => job.files(),
        }
    }

    pub fn run(&self) -> Result<()> {
        match &self.job {
            Job::Simulate(job) => job.run(),
            Job::Train(job) => job.run(),
            Job::Watch(job) => job.run(),
        }
    }
}
