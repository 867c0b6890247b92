//! Whether the logs are those of the programs that are said to have run.

use std::path::PathBuf;

use anyhow::Result;
use datasets::Log;
use models::Bundle;
use motion::Trajectory;
use pipeline::refine::{Aligned, is_compensated};
use pipeline::units::um;
use pipeline::{Input, Setup};

use super::Refine;
use crate::output::{Refusal, read_file};
use crate::read;

/// Distance of a command from the nearest program, as a share of that from its own, below which the order of the programs is wrong, and the least
/// difference of the two, mm: compensated programs of one part differ by micrometres.
const NEARER: f64 = 0.5;
const LEAST_APART_MM: f64 = 1e-3;

impl Refine {
    /// Refuses a log whose command is far nearer to the plan of another program, the original among them, than to that of its own. `commands` are those
    /// of the runs, in the path's time.
    pub(super) fn check_order<'a>(
        &self,
        input: &Input,
        setup: &Setup,
        commands: impl Iterator<Item = &'a Trajectory>,
    ) -> Result<()> {
        if input.part().is_none() || self.ran.is_empty() {
            return Ok(());
        }
        let programs: Vec<&PathBuf> = self.ran.iter().chain([&self.input]).collect();
        let planned = programs.iter().map(|path| {
            let ran = read::input(path, setup, &self.program.settings(), self.program.feed)?;
            let plan = ran.command().clone();
            Ok(Aligned::of(input, &Log::new(path.display().to_string(), plan.clone(), plan)?)?.command)
        });
        // A program that cannot be planned as it is, such as one with times of its own on another machine, shows no order.
        let Ok(planned) = planned.collect::<Result<Vec<Trajectory>>>() else { return Ok(()) };
        for (run, command) in commands.enumerate() {
            let apart: Vec<f64> = planned.iter().map(|plan| apart_mm(command, plan)).collect();
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
    pub(super) fn check_originals<'a>(
        &self,
        input: &Input,
        model: &Bundle,
        commands: impl Iterator<Item = &'a Trajectory>,
    ) -> Result<()> {
        if input.part().is_none() || self.ran.is_empty() {
            return Ok(());
        }
        let original = read_file(&self.input)?;
        for ((ran, log), command) in self.ran.iter().zip(&self.log).zip(commands) {
            if read_file(ran)? == original && is_compensated(input, model, command)? {
                return Err(Refusal(format!(
                    "{} is no run of {}: its command is shifted as that of a compensated program; give the program that ran with --ran",
                    log.display(),
                    ran.display()
                ))
                .into());
            }
        }
        Ok(())
    }
}

/// RMS distance of two runs in the path's time, less their mean difference, mm or rad.
fn apart_mm(a: &Trajectory, b: &Trajectory) -> f64 {
    let of_axis = |(a, b): (&Vec<f64>, &Vec<f64>)| {
        let count = a.len().min(b.len()).max(1) as f64;
        let differences = || a.iter().zip(b).map(|(a, b)| a - b);
        let mean = differences().sum::<f64>() / count;
        differences().map(|difference| (difference - mean).powi(2)).sum::<f64>() / count
    };
    a.columns().iter().zip(b.columns()).map(of_axis).sum::<f64>().sqrt()
}
