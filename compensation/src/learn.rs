//! The loop: run, measure, move, again.

use machine::Machine;
use motion::{DesiredPath, Trajectory};

use crate::{CompensationError, CompensationLaw, Guard};

/// When to stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StopRule {
    /// Largest number of updates.
    pub updates: usize,
    /// Stop after so many runs in a row without a new smallest measure.
    pub patience: usize,
}

impl StopRule {
    /// So many updates, whatever they bring.
    #[must_use]
    pub fn after(updates: usize) -> Self {
        Self { updates, patience: usize::MAX }
    }

    /// At most so many updates, up to the first that does not lower the measure.
    #[must_use]
    pub fn while_better(updates: usize) -> Self {
        Self { updates, patience: 1 }
    }
}

/// One run of the loop.
#[derive(Debug, Clone)]
pub struct Round {
    /// What was commanded.
    pub reference: Trajectory,
    /// What the machine did.
    pub actual: Trajectory,
    /// The measure that the caller asked for, of this run.
    pub measure: f64,
}

/// Every run of a loop.
#[derive(Debug, Clone)]
pub struct Learned {
    /// The runs in order; the first one is uncompensated unless the loop started from a given reference.
    pub rounds: Vec<Round>,
}

impl Learned {
    /// Index of the run with the smallest measure.
    #[must_use]
    pub fn best(&self) -> Option<usize> {
        (0..self.rounds.len()).min_by(|a, b| self.rounds[*a].measure.total_cmp(&self.rounds[*b].measure))
    }

    /// The last run.
    #[must_use]
    pub fn last(&self) -> Option<&Round> {
        self.rounds.last()
    }
}

/// Runs `law` on `machine`, starting from `start` (or from the desired path), and keeps every run.
///
/// `measure` gives the figure by which the loop judges a run: smaller is better.
///
/// # Errors
/// When the machine refuses a reference, or a moved pose cannot be reached.
pub fn learn(
    machine: &mut dyn Machine,
    law: &mut dyn CompensationLaw,
    desired: &DesiredPath,
    start: Option<Trajectory>,
    guard: &Guard,
    stop: &StopRule,
    measure: &mut (dyn FnMut(&DesiredPath, &Trajectory) -> f64 + Send),
) -> Result<Learned, CompensationError> {
    let mut reference = start.unwrap_or_else(|| desired.trajectory().clone());
    let mut rounds: Vec<Round> = Vec::with_capacity(stop.updates + 1);
    let mut best = 0;
    for update in 0..=stop.updates {
        let actual = machine.run(&reference)?;
        // The law does not wait for the figure, which only says whether its update counts.
        let (figure, next) = std::thread::scope(|scope| {
            let figure = scope.spawn(|| measure(desired, &actual));
            let next = (update < stop.updates)
                .then(|| law.update(desired, &reference, &actual).and_then(|next| guard.apply(desired, &next)));
            (figure.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)), next)
        });
        rounds.push(Round { reference, actual, measure: figure });
        if figure < rounds[best].measure {
            best = update;
        }
        match next {
            Some(next) if update - best < stop.patience => reference = next?,
            _ => break,
        }
    }
    Ok(Learned { rounds })
}
