//! Options that several jobs have.

use std::path::{Path, PathBuf};

use clap::Args;
use fleet::Store;

use crate::files::Files;
use crate::numbers;
use crate::output::Refusal;

/// The fleet whose logs are read.
#[derive(Debug, Args)]
pub struct FleetArgs {
    /// Folder of the fleet: logs as Parquet under machine=NAME/date=YYYY-MM-DD/
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Only these machines
    #[arg(long, value_name = "NAME", num_args = 1.., value_delimiter = ',')]
    pub only: Vec<String>,
    /// Largest number of samples that are read of a day; of more, the first part of every file
    #[arg(long, value_name = "NUMBER", default_value_t = 1_000_000, value_parser = numbers::samples)]
    pub most_samples_a_day: usize,
}

impl FleetArgs {
    /// All logs and machine files. What cannot be listed is reported when it is read.
    pub fn files(&self, json: Option<&Path>) -> Files {
        let machines = Store::new(&self.folder).machines(&[]).unwrap_or_default();
        let days = machines.iter().flat_map(|machine| machine.days().unwrap_or_default());
        let logs: Vec<PathBuf> = days.flat_map(|day| day.files).collect();
        let described: Vec<PathBuf> = machines.iter().map(|machine| machine.path.join("machine.toml")).collect();
        Files::of(json).reads_all("DIR", &logs).reads_all("DIR", &described)
    }
}

/// What is said where some machines could not be dealt with; the others were.
pub fn failures(what: &str, failed: &[(String, String)], of: usize) -> Result<(), Refusal> {
    if failed.is_empty() {
        return Ok(());
    }
    let reasons: Vec<String> = failed.iter().map(|(_, reason)| format!("  {reason}")).collect();
    Err(Refusal(format!("{} of {of} machines were not {what}:\n{}", failed.len(), reasons.join("\n"))))
}
