//! Whether the logs are those of the programs that are said to have run.

use std::path::PathBuf;

use anyhow::Result;
use datasets::Log;
use models::Bundle;
use pipeline::refine::{command_apart_mm, is_compensated};
use pipeline::units::um;
use pipeline::{Input, Setup};

use super::Refine;
use crate::output::{Refusal, read_file};
use crate::read;

/// Distance of a command from the nearest program, as a share of that from its own, below which it is a run of that one, and the least
/// difference of the two, mm: compensated programs of one part differ by tenths of a micrometre and more.
const NEARER: f64 = 0.5;
const LEAST_APART_MM: f64 = 2e-4;

impl Refine {
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
