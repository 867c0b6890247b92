//! Whether the logs are those of the programs that are said to have run.

use std::path::PathBuf;

use anyhow::Result;
use datasets::Log;
use models::Bundle;
use pipeline::measure::fits;
use pipeline::refine::{command_apart_mm, is_compensated};
use pipeline::units::um;
use pipeline::{Input, Setup};

use super::Refine;
use crate::output::{Printer, Refusal, read_file};
use crate::read;

/// Distance of a command from the nearest program, as a share of that from its own, below which it is a run of that one, and the least
/// difference of the two, mm: compensated programs of one part differ by tenths of a micrometre and more.
const NEARER: f64 = 0.5;
const LEAST_APART_MM: f64 = 2e-4;

/// A log is of another machine where the model's error is so many times that on held-out runs, and this share of the tracking error.
const UNEXPLAINED: f64 = 10.0;
const LEAST_EXPLAINED: f64 = 0.3;

impl Refine {
    /// Warns of a recording that is given twice, and refuses one that the model does not explain: it is of another machine, or the model is of another time.
    pub(super) fn check_recordings(&self, logs: &[Log], model: Option<&Bundle>, printer: &Printer) -> Result<()> {
        for (index, log) in logs.iter().enumerate() {
            let path = self.log[index].display();
            if let Some(first) = logs[..index].iter().position(|other| other.actual == log.actual) {
                let first = self.log[first].display();
                printer.line(format!(
                    "warning: {path} is the same recording as {first}, to the last digit: given twice it passes for an error that repeats; give each recording once"
                ));
            }
            let Some(model) = model else { continue };
            for fit in fits(model, log)?.iter().filter(|fit| fit.stale) {
                let tracking = tracking_rms(log, &fit.axis).unwrap_or(f64::INFINITY);
                let (axis, unit) = (&fit.axis, fit.unit.sign());
                let [error, expected, own] = [fit.rms, fit.expected, tracking].map(|value| fit.unit.number(value));
                if fit.rms > UNEXPLAINED * fit.expected && fit.rms > LEAST_EXPLAINED * tracking {
                    return Err(Refusal(format!(
                        "{path} is not of the machine of the model, as it is now: the model is off by {error} {unit} RMS in {axis}, of a tracking error of {own}, \
                         and was by {expected} on held-out runs; train again, or give the log of this machine"
                    ))
                    .into());
                }
                printer.line(format!(
                    "warning: {path}: the model is off by {error} {unit} RMS in {axis}, and was by {expected} on held-out runs: adapt it with train --from"
                ));
            }
        }
        Ok(())
    }

    /// Refuses logs that are not of the programs of --ran. Without --ran nothing is said of the programs.
    pub(super) fn check_logs(&self, input: &Input, setup: &Setup, logs: &[Log], model: Option<&Bundle>) -> Result<()> {
        if input.part().is_none() || self.ran.is_empty() {
            return Ok(());
        }
        self.check_order(setup, logs)?;
        model.map_or(Ok(()), |model| self.check_originals(input, logs, model))
    }

    /// Refuses a log whose command is far nearer to the path of another program, the original among them, than to that of its own.
    fn check_order(&self, setup: &Setup, logs: &[Log]) -> Result<()> {
        let programs: Vec<&PathBuf> = self.ran.iter().chain([&self.input]).collect();
        let planned = programs.iter().map(|path| read::input(path, setup, &self.program.settings(), self.program.feed));
        // A program that cannot be planned as it is, such as one with times of its own on another machine, shows no order.
        let Ok(planned) = planned.collect::<Result<Vec<Input>>>() else { return Ok(()) };
        for (run, log) in logs.iter().enumerate() {
            let apart: Vec<f64> = planned.iter().map(|program| command_apart_mm(program, log).unwrap_or(f64::INFINITY)).collect();
            let Some((near, least)) = apart.iter().copied().enumerate().min_by(|a, b| a.1.total_cmp(&b.1)) else { continue };
            if least < NEARER * apart[run] && apart[run] - least > LEAST_APART_MM {
                return Err(Refusal(format!(
                    "{} is no run of {}: its command is {} µm from that program and {} µm from {}; give the programs with --ran in the order of the logs",
                    self.log[run].display(),
                    self.ran[run].display(),
                    um(apart[run]),
                    um(least),
                    programs[near].display()
                ))
                .into());
            }
        }
        Ok(())
    }

    /// Refuses a log that is said to be of the original, where its command is that of a compensated program.
    fn check_originals(&self, input: &Input, logs: &[Log], model: &Bundle) -> Result<()> {
        let original = read_file(&self.input)?;
        for ((ran, path), log) in self.ran.iter().zip(&self.log).zip(logs) {
            if read_file(ran)? == original && is_compensated(input, model, log)? {
                return Err(Refusal(format!(
                    "{} is no run of {}: its command is shifted as that of a compensated program; give the program that ran with --ran",
                    path.display(),
                    ran.display()
                ))
                .into());
            }
        }
        Ok(())
    }
}

/// RMS of command minus actual position of an axis, mm or rad.
fn tracking_rms(log: &Log, axis: &str) -> Option<f64> {
    let (command, actual) = (log.reference.column(axis)?, log.actual.column(axis)?);
    let square: f64 = command.iter().zip(actual).map(|(command, actual)| (command - actual).powi(2)).sum();
    Some((square / command.len().max(1) as f64).sqrt())
}
