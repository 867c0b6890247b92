//! The learning loop: run, measure, update the reference.

use machine::Machine;
use motion::{DesiredPath, Trajectory};

use crate::{CompensationError, CompensationLaw, CorrectionLimits};

/// What a run has to save to count.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Worth {
    /// Share of the expected error, the root of the sum of squares of the cost and of `unavoidable`.
    pub share: f64,
    /// Part of the expected error that no law lowers, in the unit of the cost: the model's own error, independent of what the model predicts.
    pub unavoidable: f64,
    /// Least cost that can be hoped for, or 0.
    pub attainable: f64,
}

impl Worth {
    /// A share of the cost itself.
    #[must_use]
    pub fn of_cost(share: f64) -> Self {
        Self { share, ..Self::default() }
    }

    /// The expected error of a run of this cost.
    #[must_use]
    pub fn expected(self, cost: f64) -> f64 {
        cost.hypot(self.unavoidable)
    }

    /// Whether a run of the cost `after` counts beside one of the cost `before`.
    #[must_use]
    pub fn counts(self, before: f64, after: f64) -> bool {
        self.expected(after) < (1.0 - self.share) * self.expected(before)
    }

    /// Share of the expected error of a run of this cost that can still be saved.
    #[must_use]
    pub fn left(self, cost: f64) -> f64 {
        (1.0 - self.expected(self.attainable) / self.expected(cost)).max(0.0)
    }

    /// Number of successive runs that need not count, at most `most`: as many as could count with what is [left](Self::left).
    #[must_use]
    pub fn patience(self, cost: f64, most: usize) -> usize {
        let left = self.left(cost);
        if left < self.share * most as f64 { (left / self.share) as usize } else { most }
    }
}

/// Stop criterion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StopRule {
    /// Largest number of updates.
    pub updates: usize,
    /// Stop after this many successive runs that do not count, or fewer where little is left to save.
    pub patience: usize,
    /// What a run has to save to count.
    pub worth: Worth,
    /// Cost to reach: stop where it is further away than the last update came. Infinite where there is none.
    pub to_reach: f64,
}

impl StopRule {
    /// Exactly this many updates.
    #[must_use]
    pub fn after(updates: usize) -> Self {
        Self { updates, patience: usize::MAX, worth: Worth::default(), to_reach: f64::INFINITY }
    }

    /// At most this many updates, up to the first that does not lower the cost by this share.
    #[must_use]
    pub fn while_better(updates: usize, worth: f64) -> Self {
        Self { updates, patience: 1, worth: Worth::of_cost(worth), to_reach: f64::INFINITY }
    }

    /// Whether `cost` ends the learning: `least` is the cost of the best run before, `before` that of the last one, and `since` the number of
    /// runs after the best one.
    fn ends(&self, least: f64, before: f64, cost: f64, since: usize) -> bool {
        let (best, since) = if self.worth.counts(least, cost) { (cost, 0) } else { (least, since) };
        since >= self.worth.patience(best, self.patience) || before.is_finite() && before - cost < cost - self.to_reach
    }
}

/// One run of the loop.
#[derive(Debug, Clone)]
pub struct Iteration {
    /// Commanded path.
    pub reference: Trajectory,
    /// Actual path.
    pub actual: Trajectory,
    /// Cost of this run, from the caller's `measure`.
    pub measure: f64,
}

/// All runs of a loop.
#[derive(Debug, Clone)]
pub struct Learned {
    /// The runs in order; the first one is uncompensated unless the loop started from a given reference.
    pub iterations: Vec<Iteration>,
}

impl Learned {
    /// The last run.
    #[must_use]
    pub fn last(&self) -> Option<&Iteration> {
        self.iterations.last()
    }
}

/// Runs `law` on `machine`, starting from `start` (or from the desired path), and keeps all runs.
///
/// `measure` returns the cost of a run: smaller is better.
///
/// # Errors
/// When the machine refuses a reference, or a moved pose cannot be reached.
pub fn learn(
    machine: &mut dyn Machine,
    law: &mut dyn CompensationLaw,
    desired: &DesiredPath,
    start: Option<Trajectory>,
    limits: &CorrectionLimits,
    stop: &StopRule,
    measure: &mut (dyn FnMut(&DesiredPath, &Trajectory) -> f64 + Send),
) -> Result<Learned, CompensationError> {
    iterate(machine, law, desired, None, start, limits, stop, measure)
}

/// As [`learn`], from a known run, which is the first of the returned ones.
///
/// # Errors
/// As [`learn`].
pub fn learn_from(
    machine: &mut dyn Machine,
    law: &mut dyn CompensationLaw,
    desired: &DesiredPath,
    first: Iteration,
    limits: &CorrectionLimits,
    stop: &StopRule,
    measure: &mut (dyn FnMut(&DesiredPath, &Trajectory) -> f64 + Send),
) -> Result<Learned, CompensationError> {
    iterate(machine, law, desired, Some(first), None, limits, stop, measure)
}

#[allow(clippy::too_many_arguments)] // those of `learn`, and one
fn iterate(
    machine: &mut dyn Machine,
    law: &mut dyn CompensationLaw,
    desired: &DesiredPath,
    mut first: Option<Iteration>,
    start: Option<Trajectory>,
    limits: &CorrectionLimits,
    stop: &StopRule,
    measure: &mut (dyn FnMut(&DesiredPath, &Trajectory) -> f64 + Send),
) -> Result<Learned, CompensationError> {
    let mut reference = start.unwrap_or_else(|| desired.trajectory().clone());
    let mut rounds: Vec<Iteration> = Vec::with_capacity(stop.updates + 1);
    let mut best = 0;
    for update in 0..=stop.updates {
        let known = first.take();
        let (actual, mut figure) = match known {
            Some(round) => {
                reference = round.reference;
                (round.actual, Some(round.measure))
            }
            None => (machine.run(&reference)?, None),
        };
        let before = rounds.last().map_or(f64::INFINITY, |round| round.measure);
        let is_last = |figure: f64| stop.ends(least(&rounds, best), before, figure, update - best);
        // The law does not wait for the cost, which only decides whether its update counts; where all cores have other work, it does.
        let is_alone = rayon::current_thread_index().is_none();
        if !is_alone && figure.is_none() {
            figure = Some(measure(desired, &actual));
        }
        let updates = update < stop.updates && (is_alone || !figure.is_some_and(is_last));
        let next = rayon::in_place_scope(|scope| {
            if figure.is_none() {
                scope.spawn(|_| figure = Some(measure(desired, &actual)));
            }
            updates.then(|| law.update(desired, &reference, &actual))
        });
        let figure = figure.unwrap_or(f64::INFINITY);
        let ends = is_last(figure);
        let counts = stop.worth.counts(least(&rounds, best), figure);
        let next = match next {
            Some(next) if !ends => Some(limits.apply_step(desired, &reference, &next?)?),
            _ => None,
        };
        rounds.push(Iteration { reference, actual, measure: figure });
        if counts {
            best = update;
        }
        let Some(next) = next else { break };
        reference = next;
    }
    Ok(Learned { iterations: rounds })
}

/// Cost of the best of the runs.
fn least(rounds: &[Iteration], best: usize) -> f64 {
    rounds.get(best).map_or(f64::INFINITY, |round| round.measure)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use machine::MachineError;
    use motion::{Axis, Cartesian};

    use super::*;
    use crate::laws::{Gain, TrackingIlc};

    /// Follows its reference exactly.
    struct Ideal;

    impl Machine for Ideal {
        fn run(&mut self, reference: &Trajectory) -> Result<Trajectory, MachineError> {
            Ok(reference.clone())
        }
    }

    #[test]
    fn patience_counts_runs_without_a_new_best_one() {
        let path = Trajectory::new(0.002, Axis::xyz(), vec![vec![0.0; 4]; 3]).unwrap();
        let desired = DesiredPath::new(path, Arc::new(Cartesian::new(Axis::xyz()))).unwrap();
        let runs = |stop: &StopRule| {
            let mut figures = [5.0, 4.0, 6.0, 3.0, 7.0, 7.0, 2.0].into_iter();
            let mut law = TrackingIlc::new(Gain::Constant(0.5), None);
            let mut measure = |_: &DesiredPath, _: &Trajectory| figures.next().unwrap();
            let learned = learn(&mut Ideal, &mut law, &desired, None, &CorrectionLimits::default(), stop, &mut measure).unwrap();
            learned.iterations.len()
        };
        assert_eq!(runs(&StopRule::while_better(6, 0.0)), 3);
        assert_eq!(runs(&StopRule::while_better(6, 0.25)), 2);
        assert_eq!(runs(&StopRule { patience: 2, ..StopRule::after(6) }), 6);
        // Beside an error of 100 that no run lowers nothing is left to save. Beside one of 40 a run that counts is, but not two.
        let worth = Worth { share: 0.005, unavoidable: 100.0, attainable: 0.0 };
        let rule = |worth: Worth| StopRule { patience: 2, worth, ..StopRule::after(6) };
        assert_eq!(runs(&rule(worth)), 1);
        assert_eq!(runs(&rule(Worth { unavoidable: 40.0, ..worth })), 2);
        assert_eq!(runs(&rule(Worth { unavoidable: 1.0, ..worth })), 6);
        // A floor of 3.9 is nearly reached by the second run, so that no further one counts.
        assert_eq!(runs(&rule(Worth { unavoidable: 0.0, share: 0.05, attainable: 3.9 })), 2);
        // The first update comes by 1 toward 2, of which 2 are left; toward 3.5 it comes near enough.
        assert_eq!(runs(&StopRule { to_reach: 2.0, ..rule(Worth::default()) }), 2);
        assert_eq!(runs(&StopRule { to_reach: 3.5, ..rule(Worth::default()) }), 3);
        assert_eq!(runs(&StopRule::after(6)), 7);
    }
}
