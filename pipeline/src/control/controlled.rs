//! A machine behind its control, which commands what it makes of a reference.

use machine::{Machine, MachineError};
use models::LearnedMachine;
use motion::{MotionError, Trajectory};

use super::replanned::Replanned;
use crate::error::Error;
use crate::part::Part;
use crate::refit::{RefitSettings, TimeEncoding};

/// How a law sees a run that does not keep the path's time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pairing {
    /// At the instants at which its own command passes the path's places.
    Place,
    /// At the path's instants, as if it had kept them.
    Time,
}

/// One run of a program in the time that its control planned.
#[derive(Debug, Clone)]
pub struct CommandedRun {
    /// What the control commanded.
    pub command: Trajectory,
    /// For every sample its place on the path, as a sample index with fraction.
    pub places: Vec<f64>,
    /// What the machine did, at the same instants.
    pub actual: Trajectory,
}

/// A machine behind a control that commands the reference itself; or what it did in a recorded run, shifted by as much; or what it plans when
/// it reads the program that the reference is written into. Its runs are in the path's time, whatever the control's.
pub struct ControlledMachine<'a, M: ?Sized> {
    machine: &'a mut M,
    part: Option<&'a Part>,
    pub(super) replans: Option<RefitSettings>,
    pub(super) pairing: Pairing,
    /// Tells the machine which way a command leads without its correction.
    prepare: fn(&mut M, &Trajectory),
    /// How long every program that was replanned takes, s.
    durations_s: Vec<f64>,
    /// Every run of a program that was replanned, where they are kept.
    pub(super) runs: Option<Vec<CommandedRun>>,
}

impl<'a> ControlledMachine<'a, LearnedMachine> {
    /// A learned machine behind a control that keeps the reference, or leaves it as in the recorded run of `part`.
    pub fn learned(machine: &'a mut LearnedMachine, part: Option<&'a Part>) -> Self {
        Self { prepare: LearnedMachine::freeze_flags, ..Self::new(machine, part) }
    }
}

impl<'a, M: Machine + ?Sized> ControlledMachine<'a, M> {
    /// A machine behind a control that keeps the reference, or leaves it as in the recorded run of `part`.
    pub fn new(machine: &'a mut M, part: Option<&'a Part>) -> Self {
        let (replans, pairing, durations_s, runs) = (None, Pairing::Place, Vec::new(), None);
        Self { machine, part, replans, pairing, prepare: |_, _| {}, durations_s, runs }
    }

    /// From here on the control reads the program, written so, and plans it anew. `false` where there is none, where a recorded run
    /// says what the control commands, or where the program states the times of its lines.
    pub fn replans(&mut self, written: RefitSettings) -> bool {
        let timed = |part: &Part| written.encoding == TimeEncoding::Keep && part.states_times();
        let replans = self.part.is_some_and(|part| part.command.is_none() && !timed(part));
        if replans {
            self.replans = Some(written);
        }
        replans
    }

    /// How long every program that was replanned takes, s.
    #[must_use]
    pub fn durations_s(&self) -> &[f64] {
        &self.durations_s
    }

    /// How long the program replanned last takes, s.
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
            // The command tells where the run should have been, to the micrometre: better than a delay of the whole run.
            Pairing::Place => replanned.in_path_time(&actual)?,
            Pairing::Time => in_step(&actual, reference.len())?,
        };
        let Replanned { command, places, .. } = replanned;
        if let Some(runs) = &mut self.runs {
            runs.push(CommandedRun { command, places, actual });
        }
        Ok(seen)
    }
}

impl<M: Machine + ?Sized> Machine for ControlledMachine<'_, M> {
    fn run(&mut self, reference: &Trajectory) -> Result<Trajectory, MachineError> {
        match (self.part, self.replans) {
            (Some(part), Some(written)) => self.run_replanned(part, reference, &written),
            (Some(part), None) => self.machine.run(&part.commanded(reference)?),
            (None, _) => self.machine.run(reference),
        }
    }
}

/// The first `samples` of a run, the last one held where there are fewer: beside a path as if it had kept its time.
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

/// An error and what caused it, in one line.
fn with_causes(error: &Error) -> String {
    let causes = std::iter::successors(Some(error as &dyn std::error::Error), |error| error.source());
    causes.map(ToString::to_string).collect::<Vec<_>>().join(": ")
}
