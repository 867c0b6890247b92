//! A machine behind its control, which commands what it makes of a reference.

use machine::{Machine, MachineError};
use models::LearnedMachine;
use motion::{Limits, Trajectory};

use crate::pipeline::{Carrier, Part, RefitSettings, Replanned};

/// A learned machine behind a control that commands the reference itself; or what it did in a recorded run, shifted by as much; or what it
/// plans when it reads the program that the reference is written into.
pub struct Control<'a> {
    machine: &'a mut LearnedMachine,
    part: Option<&'a Part>,
    written: Option<(RefitSettings, &'a Limits)>,
    /// How long every program planned so far takes, s.
    pub durations_s: Vec<f64>,
}

impl<'a> Control<'a> {
    /// A control that keeps the reference, or leaves it as in the recorded run of `part`.
    pub fn new(machine: &'a mut LearnedMachine, part: Option<&'a Part>) -> Self {
        Self { machine, part, written: None, durations_s: Vec::new() }
    }

    /// From here on the control reads the program, written so, and plans it anew. `false` where there is none, where a recorded run
    /// says what the control commands, or where the program states the times of its lines.
    pub fn plans(&mut self, written: RefitSettings, limits: &'a Limits) -> bool {
        let timed = |part: &Part| written.carrier == Carrier::Keep && part.states_times();
        let plans = self.part.is_some_and(|part| part.command.is_none() && !timed(part));
        if plans {
            self.written = Some((written, limits));
        }
        plans
    }

    /// How long the program planned last takes, s.
    pub fn last_s(&self) -> f64 {
        self.durations_s.last().copied().unwrap_or_default()
    }
}

impl Machine for Control<'_> {
    fn run(&mut self, reference: &Trajectory) -> Result<Trajectory, MachineError> {
        match (self.part, self.written) {
            (Some(part), Some((written, limits))) => {
                let replanned = Replanned::new(part, reference, &written, limits)
                    .map_err(|error| MachineError::Misfit(format!("the compensated program cannot be planned: {error:#}")))?;
                self.machine.freeze_flags(&replanned.path()?);
                let actual = self.machine.run(&replanned.command)?;
                self.durations_s.push(replanned.command.duration_s());
                Ok(replanned.in_path_time(&actual)?)
            }
            (Some(part), None) => self.machine.run(&part.commanded(reference)?),
            (None, _) => self.machine.run(reference),
        }
    }
}
