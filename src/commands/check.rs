//! `precomp check`: what logs hold, and whether they are fit for training.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use datasets::{Finding, Inspection, Log, Purpose, Report, Severity, assess_runs};
use pipeline::training::HELD_OUT;
use serde_json::json;

use crate::args::{Common, LogArgs};
use crate::files::Files;
use crate::output::{Refusal, text, write_json};
use crate::print::check as print;
use crate::read;

/// Say what logs hold, and whether they are fit for training: columns, units, faults and their remedies
///
/// Prints what every column was taken for, a picture of every axis, and what is wrong. Ends with status 1 where the logs are not fit.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  precomp check runs/*.csv
  precomp check log.csv --columns t=time_s,x_ref=x_cmd_mm,x_act=x_act_mm")]
pub struct Check {
    /// Logs, one a run: CSV, Parquet, JSON, NumPy, MATLAB, LabVIEW, halsampler, halscope, TwinCAT Scope, SINUMERIK Edge or trace
    #[arg(required = true)]
    logs: Vec<PathBuf>,
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    columns: LogArgs,
}

impl Check {
    pub fn files(&self) -> Files {
        Files::of(self.common.json.as_deref()).reads_logs("LOG", &self.logs)
    }

    pub fn run(&self) -> Result<()> {
        let printer = self.common.printer();
        let options = self.columns.options();
        let mut found: Vec<Inspection> = Vec::new();
        // A file that cannot be read does not hide what the others hold.
        let mut unread = Vec::new();
        for path in &self.logs {
            match read::inspection(path, &options) {
                Ok(inspection) => found.push(inspection),
                Err(error) => unread.push(text(&error)),
            }
        }
        let (logs, joined): (Vec<Log>, _) = datasets::joined(found.iter().flat_map(|one| one.runs.iter().cloned()).collect());
        let mut report = Report::default();
        joined.into_iter().for_each(|finding| report.push(finding));
        if !logs.is_empty() {
            report.extend(assess_runs(&logs, Purpose::Training));
            // What `train` would refuse when it holds a part out.
            if let Err(error) = datasets::folds(&logs, HELD_OUT, 1, 0) {
                report.push(Finding::new(Severity::Refuse, datasets::Check::Rate, error.to_string()));
            }
        }
        found.iter().for_each(|one| print::show(&printer, one));
        unread.iter().for_each(|error| printer.line(format!("refused: {error}")));
        report.findings.iter().for_each(|finding| printer.line(finding));
        let worst = found.iter().filter_map(|one| one.report.worst()).chain(report.worst()).max();
        let verdict = if unread.is_empty() { worst } else { Some(Severity::Refuse) };
        printer.line(print::verdict(verdict));
        let logs: Vec<_> = found.iter().flat_map(print::json).collect();
        let figures = json!({ "logs": logs, "unread": unread, "findings": print::findings_json(&report), "verdict": print::verdict_name(verdict) });
        write_json(self.common.json.as_deref(), &figures)?;
        match verdict {
            Some(Severity::Refuse) => {
                let all = found.iter().flat_map(|one| &one.report.findings).chain(&report.findings);
                let refused = all.filter(|finding| finding.severity == Severity::Refuse).map(ToString::to_string);
                let why: Vec<String> = unread.into_iter().chain(refused).filter(|_| self.common.quiet).collect();
                let mut lines = vec!["the logs are not fit for training".to_owned()];
                lines.extend(why);
                Err(Refusal(lines.join("\n")).into())
            }
            _ => Ok(()),
        }
    }
}
