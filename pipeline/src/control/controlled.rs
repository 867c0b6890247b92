//! A machine behind its control, which derives its own command from a reference.

use machine::{Machine, MachineError};
use models::LearnedMachine;
use motion::{MotionError, Trajectory};

use super::replanned::Replanned;
use crate::error::Error;
use crate::part::Part;
use crate::refit::{RefitSettings, TimeEncoding};

/// Pairing of a run with the path for a law, where the run does not keep the path's time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pairing {
    /// By position: samples at the instants at which the command passes the path's samples.
    Place,
    /// By time: samples at the path's instants, as if the run kept the path's time.
    Time,
}

/// A run of a program in the time planned by its control.
#[derive(Debug, Clone)]
pub struct CommandedRun {
    /// Command of the control.
    pub command: Trajectory,
    /// Path position of every sample, as a sample index with fraction.
    pub path_positions: Vec<f64>,
    /// Actual positions at the same instants.
    pub actual: Trajectory,
}

/// Whether a control plans `part`, written with these settings, again: not where lines state their times, those of the program or of a recorded run. Those
/// of Fanuc are bounded, so that not every line can state its own.
#[must_use]
pub fn is_replanned(part: &Part, written: RefitSettings) -> bool {
    match written.encoding {
        TimeEncoding::Keep => !part.states_times() || part.counts_by_radius(),
        TimeEncoding::G93 | TimeEncoding::G94 => part.recording.is_none(),
    }
}

/// A machine behind a control. The control commands the reference itself, or the recorded command shifted by the
/// correction, or the plan of the program into which the reference is written. Runs are returned in the path's time in
/// all cases.
pub struct ControlledMachine<'a, M: ?Sized> {
    machine: &'a mut M,
    part: Option<&'a Part>,
    pub(super) replans: Option<RefitSettings>,
    pub(super) pairing: Pairing,
    /// Whether runs show what the axes do at standstills whose places the command does not quite reach.
    stands: bool,
    /// Gives the machine the command without correction, which sets its directions of motion.
    prepare: fn(&mut M, &Trajectory),
    /// Duration of every replanned program, s.
    durations_s: Vec<f64>,
    /// Runs of replanned programs, where they are kept.
    pub(super) runs: Option<Vec<CommandedRun>>,
    /// What is added to every run, one column an axis in the path's time, mm or rad.
    disturbance: Option<&'a [Vec<f64>]>,
}

impl<'a> ControlledMachine<'a, LearnedMachine> {
    /// A learned machine behind a control that commands the reference, or follows the recorded command of `part`.
    pub fn learned(machine: &'a mut LearnedMachine, part: Option<&'a Part>) -> Self {
        Self { prepare: LearnedMachine::freeze_flags, ..Self::new(machine, part) }
    }
}

impl<'a, M: Machine + ?Sized> ControlledMachine<'a, M> {
    /// A machine behind a control that commands the reference, or follows the recorded command of `part`.
    pub fn new(machine: &'a mut M, part: Option<&'a Part>) -> Self {
        let (replans, pairing, durations_s, runs) = (None, Pairing::Place, Vec::new(), None);
        Self { machine, part, replans, pairing, stands: false, prepare: |_, _| {}, durations_s, runs, disturbance: None }
    }

    /// The same machine with a disturbance that repeats in every run: actual minus undisturbed positions at the path's samples, one column
    /// an axis, mm or rad.
    #[must_use]
    pub fn disturbed(self, disturbance: Option<&'a [Vec<f64>]>) -> Self {
        Self { disturbance, ..self }
    }

    /// Switches to a control that reads and replans the program, written with these settings. Returns `false` without
    /// effect where there is no program, or where the program states the times of its lines.
    pub fn replans(&mut self, written: RefitSettings) -> bool {
        let replans = self.can_replan(written);
        if replans {
            self.replans = Some(written);
        }
        replans
    }

    /// A run of a replanned program, with what the axes do at standstills; `None` where the control takes the reference.
    ///
    /// # Errors
    /// As [`Machine::run`].
    pub fn run_standing(&mut self, reference: &Trajectory) -> Result<Option<Trajectory>, MachineError> {
        if self.replans.is_none() {
            return Ok(None);
        }
        self.stands = true;
        let run = self.run(reference);
        self.stands = false;
        run.map(Some)
    }

    /// Whether the control would plan the program, written with these settings, again.
    #[must_use]
    pub fn can_replan(&self, written: RefitSettings) -> bool {
        self.part.is_some_and(|part| is_replanned(part, written))
    }

    /// Duration of every replanned program, s.
    #[must_use]
    pub fn durations_s(&self) -> &[f64] {
        &self.durations_s
    }

    /// Duration of the last replanned program, s; 0 before the first.
    #[must_use]
    pub fn last_s(&self) -> f64 {
        self.durations_s.last().copied().unwrap_or_default()
    }

    fn run_replanned(
        &mut self,
        part: &Part,
        reference: &Trajectory,
        written: &RefitSettings,
    ) -> Result<Trajectory, MachineError> {
        let replanned = Replanned::new(part, reference, written).map_err(|error| {
            MachineError::Misfit(format!("the compensated program cannot be planned: {}", with_causes(&error)))
        })?;
        (self.prepare)(self.machine, &replanned.path()?);
        let actual = self.machine.run(&replanned.command)?;
        self.durations_s.push(replanned.command.duration_s());
        let seen = match self.pairing {
            // The command gives the intended position at every instant, to the micrometre. One delay for the whole run
            // is less exact.
            Pairing::Place if self.stands => replanned.in_path_time_standing(&actual)?,
            Pairing::Place => replanned.in_path_time(&actual)?,
            Pairing::Time => in_step(&actual, reference.len())?,
        };
        let Replanned { command, path_positions, .. } = replanned;
        if let Some(runs) = &mut self.runs {
            runs.push(CommandedRun { command, path_positions, actual });
        }
        Ok(seen)
    }
}

impl<M: Machine + ?Sized> Machine for ControlledMachine<'_, M> {
    fn run(&mut self, reference: &Trajectory) -> Result<Trajectory, MachineError> {
        let run = match (self.part, self.replans) {
            (Some(part), Some(written)) => self.run_replanned(part, reference, &written),
            (Some(part), None) => self.machine.run(&part.commanded(reference)?),
            (None, _) => self.machine.run(reference),
        }?;
        match self.disturbance {
            Some(disturbance) => Ok(plus(&run, disturbance)?),
            None => Ok(run),
        }
    }
}

/// A run with `columns` added to its positions, one column an axis.
///
/// # Errors
/// As [`Trajectory::with_columns`].
pub fn plus(run: &Trajectory, columns: &[Vec<f64>]) -> Result<Trajectory, MotionError> {
    let sums = run.columns().iter().zip(columns);
    run.with_columns(sums.map(|(column, added)| column.iter().zip(added).map(|(x, d)| x + d).collect()).collect())
}

/// First `samples` samples of a run, extended by its last position where it is shorter.
///
/// # Errors
/// As [`Trajectory::new`].
pub fn in_step(run: &Trajectory, samples: usize) -> Result<Trajectory, MotionError> {
    let columns = run.columns().iter().map(|column| {
        let last = column.last().copied().unwrap_or_default();
        column.iter().copied().chain(std::iter::repeat(last)).take(samples).collect()
    });
    Trajectory::new(run.period_s(), run.axes().to_vec(), columns.collect())
}

/// An error and its causes in one line.
fn with_causes(error: &Error) -> String {
    let causes = std::iter::successors(Some(error as &dyn std::error::Error), |error| error.source());
    causes.map(ToString::to_string).collect::<Vec<_>>().join(": ")
}
