//! `precomp measure`: tracking and contour error of a recorded run.

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::Result;
use clap::Args;
use datasets::{Purpose, ReadOptions, assess, read_log};
use motion::{Cartesian, DesiredPath};
use serde_json::json;

use crate::cli::{Common, MachineArgs, ProgramArgs};
use crate::evaluate;
use crate::input::{self, Frame, Input};
use crate::output::{Printer, Refusal, Usage, table, um, write_json};

/// Tracking and contour error of a recorded run
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  precomp measure run.csv\n  precomp measure run.csv --desired part.nc --machine mill.toml")]
pub struct Measure {
    /// The log (.csv, .parquet)
    log: PathBuf,
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    machine: MachineArgs,
    #[command(flatten)]
    program: ProgramArgs,
    /// The path that the part needs, where the log's command is a compensated one
    #[arg(long, value_name = "INPUT")]
    desired: Option<PathBuf>,
    /// Column names, where they are not recognised
    #[arg(long, value_name = "MAP")]
    columns: Option<String>,
}

impl Measure {
    pub fn run(&self) -> Result<()> {
        if !self.log.is_file() {
            return Err(Usage(format!("cannot read {}: there is no such file", self.log.display())).into());
        }
        let options = ReadOptions { columns: self.columns.clone(), period_s: None };
        let (log, mut report) = read_log(&self.log, &options).map_err(|error| Refusal(error.to_string()))?;
        report.extend(assess(&log, Purpose::Measuring));
        let printer = Printer::new(self.common.json.as_deref());
        for finding in &report.findings {
            printer.line(finding);
        }
        if report.is_refused() {
            return Err(Refusal("the log is not fit for measuring".into()).into());
        }
        let desired = match &self.desired {
            Some(path) => Input::read(path, &Frame::of(&input::machine(&self.machine.machine)?), &self.program)?.desired,
            None => DesiredPath::new(log.reference.clone(), Arc::new(Cartesian::new(log.axes().to_vec())))?,
        };
        let contour = evaluate::contour(&desired, &log.actual)?;
        let rows: Vec<Vec<String>> = log
            .axes()
            .iter()
            .zip(log.reference.tracking_error(&log.actual)?)
            .map(|(axis, error)| {
                let (rms, max) = evaluate::rms_max(&error);
                vec![axis.name.clone(), um(rms), um(max)]
            })
            .collect();
        printer.line(table(&["axis", "tracking error RMS µm", "MAX µm"], &rows));
        printer.line(format!(
            "contour error {} µm RMS, {} µm MAX, {} µm at 95 %; worst at t = {:.3} s",
            um(contour.rms_mm),
            um(contour.max_mm),
            um(contour.p95_mm),
            contour.max_at as f64 * log.period_s()
        ));
        write_json(
            self.common.json.as_deref(),
            &json!({
                "contour_um": evaluate::contour_json(&contour),
                "tracking_um": evaluate::tracking_json(&log.reference, &log.actual)?,
            }),
        )
    }
}
