//! Learning on a machine that is given programs: every reference is written as G-code, whose time the control plans anew.

use compensation::{CompensationLaw, CorrectionLimits, StopRule, learn};
use machine::Machine;
use motion::Trajectory;

use super::controlled::{CommandedRun, ControlledMachine, Pairing};
use super::replanned::Replanned;
use crate::error::Result;
use crate::part::Part;
use crate::refit::{DECIMALS, RefitSettings, TimeEncoding};
use crate::statistics::{self, Figures};

/// Points are moved, none is added: more of them where a program is slow would only bring noise there, which a control slows down for.
pub const MOVE_POINTS: RefitSettings = RefitSettings {
    encoding: TimeEncoding::Keep,
    decimals: DECIMALS,
    spacing_s: f64::INFINITY,
    chord_tolerance_mm: f64::INFINITY,
    path_tolerance_mm: None,
};

/// One run of a program, with its figures.
#[derive(Debug, Clone)]
pub struct ProgramRun {
    /// Command and actual positions.
    pub run: CommandedRun,
    /// Against the program's own path.
    pub figures: Figures,
}

impl ProgramRun {
    fn of(part: &Part, run: CommandedRun) -> Result<Self> {
        let figures = statistics::figures_along(&part.plan.desired, Some(part), &run.command, &run.actual)?;
        Ok(Self { run, figures })
    }
}

/// Runs a program with its points moved as `reference` says.
///
/// # Errors
/// When the program cannot be written or planned, or the run fails.
pub fn run_program(part: &Part, machine: &mut dyn Machine, reference: &Trajectory) -> Result<ProgramRun> {
    let Replanned { command, places, .. } = Replanned::new(part, reference, &MOVE_POINTS)?;
    let actual = machine.run(&command)?;
    ProgramRun::of(part, CommandedRun { command, places, actual })
}

/// Runs a program, lets `law` move its points within `bounds`, and runs it again, `updates` times. Nothing moves at a standstill.
///
/// # Errors
/// As [`run_program`], and when the law fails.
pub fn learn_program(
    part: &Part,
    machine: &mut dyn Machine,
    law: &mut dyn CompensationLaw,
    pairing: Pairing,
    updates: usize,
    bounds: &CorrectionLimits,
) -> Result<Vec<ProgramRun>> {
    let desired = &part.plan.desired;
    let guard = CorrectionLimits { weights: weights(desired.trajectory()), ..bounds.clone() };
    let mut control = ControlledMachine::new(machine, Some(part));
    (control.replans, control.pairing, control.runs) = (Some(MOVE_POINTS), pairing, Some(Vec::with_capacity(updates + 1)));
    learn(&mut control, law, desired, None, &guard, &StopRule::after(updates), &mut |_, _| 0.0)?;
    control.runs.unwrap_or_default().into_iter().map(|run| ProgramRun::of(part, run)).collect()
}

/// None of a correction where the path stands still, all of it elsewhere: a program begins and ends where it says, and there a servo's
/// integrator brings the axes to where they are commanded.
fn weights(path: &Trajectory) -> Vec<f64> {
    let moves = |k: usize| k + 1 < path.len() && path.at(k).ne(path.at(k + 1));
    (0..path.len()).map(|k| f64::from(u8::from(k > 0 && moves(k - 1) && moves(k)))).collect()
}
