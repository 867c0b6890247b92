//! Learning on a machine that runs programs: every reference is written as G-code, and the control replans its feed
//! profile.

use compensation::{CompensationLaw, CorrectionLimits, StopRule, learn};
use machine::Machine;
use motion::Trajectory;

use super::controlled::{CommandedRun, ControlledMachine, Pairing};
use super::replanned::Replanned;
use crate::error::Result;
use crate::part::Part;
use crate::refit::{DECIMALS, RefitSettings, TimeEncoding};
use crate::statistics::{self, Figures};

/// Output settings that move existing points and add none. Additional points in slow segments would add noise, for
/// which a control slows down.
pub const MOVE_POINTS: RefitSettings = RefitSettings {
    encoding: TimeEncoding::Keep,
    decimals: DECIMALS,
    increment_decimals: None,
    spacing_s: f64::INFINITY,
    chord_tolerance_mm: f64::INFINITY,
    path_tolerance_mm: None,
    slow_stop: None,
};

/// A run of a program with its error figures.
#[derive(Debug, Clone)]
pub struct ProgramRun {
    /// Command and actual positions.
    pub run: CommandedRun,
    /// Figures against the path of the original program.
    pub figures: Figures,
}

impl ProgramRun {
    fn of(part: &Part, run: CommandedRun) -> Result<Self> {
        let figures = statistics::figures_along(&part.plan.desired, Some(part), &run.command, &run.actual)?;
        Ok(Self { run, figures })
    }
}

/// Runs a program whose points are moved to `reference`, written with these settings.
///
/// # Errors
/// When the program cannot be written or planned, or the run fails.
pub fn run_program(
    part: &Part,
    machine: &mut dyn Machine,
    reference: &Trajectory,
    written: &RefitSettings,
) -> Result<ProgramRun> {
    let Replanned { command, path_positions, .. } = Replanned::new(part, reference, written)?;
    let actual = machine.run(&command)?;
    ProgramRun::of(part, CommandedRun { command, path_positions, actual })
}

/// Iterates `law` on a program: runs it, moves its points within `bounds`, and runs it again, `updates` times. Points
/// at a standstill do not move, nor do those to which `bounds` give no weight. The programs are written with the settings `points`.
///
/// # Errors
/// As [`run_program`], and when the law fails.
pub fn learn_program(
    part: &Part,
    machine: &mut dyn Machine,
    law: &mut dyn CompensationLaw,
    (pairing, points): (Pairing, RefitSettings),
    updates: usize,
    bounds: &CorrectionLimits,
) -> Result<Vec<ProgramRun>> {
    let desired = &part.plan.desired;
    let mut weights = moving_weights(desired.trajectory());
    weights.iter_mut().zip(&bounds.weights).for_each(|(weight, given)| *weight *= given);
    let correction_limits = CorrectionLimits { weights, ..bounds.clone() };
    let mut control = ControlledMachine::new(machine, Some(part));
    (control.replans, control.pairing, control.runs) = (Some(points), pairing, Some(Vec::with_capacity(updates + 1)));
    learn(&mut control, law, desired, None, &correction_limits, &StopRule::after(updates), &mut |_, _| 0.0)?;
    control.runs.unwrap_or_default().into_iter().map(|run| ProgramRun::of(part, run)).collect()
}

/// Correction weights: 0 at a standstill of the path, 1 elsewhere. The program keeps its start and end, where the
/// servo's integrator removes the error.
fn moving_weights(path: &Trajectory) -> Vec<f64> {
    let moves = |k: usize| k + 1 < path.len() && path.at(k).ne(path.at(k + 1));
    (0..path.len()).map(|k| f64::from(u8::from(k > 0 && moves(k - 1) && moves(k)))).collect()
}
