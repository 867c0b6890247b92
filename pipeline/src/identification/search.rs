//! Search of parameters: all at once by Gauss–Newton steps, then one at a time, until none gains.

use machine::MachineSpec;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::fidelity::{Fidelity, PATH_MM, TIME_SHARE};
use super::observed::{CELL_S, Observed};
use super::parameters::Parameter;

/// First factor of a step, the least one, and the one below which a round without gain is the last.
const FIRST_FACTOR: f64 = 1.5;
const LAST_FACTOR: f64 = 1.01;
const SMALL_FACTOR: f64 = 1.05;
/// A fit whose score after the Gauss–Newton steps is so many times the best one does not go on.
pub(super) const HOPELESS: f64 = 2.0;

/// How far a fit goes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Effort {
    /// Rounds over all parameters one by one.
    rounds: usize,
    /// Share of the hopeless score up to which limits that others hide are looked for.
    near: f64,
    /// A fit whose score after the Gauss–Newton steps is so many times the best one does not go on.
    pub hopeless: f64,
}

impl Effort {
    /// To sort shapes before the corners are known.
    pub const FIRST: Self = Self { rounds: 1, near: 0.0, hopeless: HOPELESS };
    /// To compare rules of corners, when the values are still those of the wrong one.
    pub const CORNERS: Self = Self { rounds: 2, near: 0.0, hopeless: 2.0 * HOPELESS };
    /// To compare structures.
    pub const COMPARING: Self = Self { rounds: 2, near: 0.0, hopeless: HOPELESS };
    /// To compare them where the best one is not good yet.
    pub const THOROUGH: Self = Self { rounds: 3, near: 1.0, hopeless: HOPELESS };
    /// Of the last fit, and of its repetition with fewer parameters: they begin where a thorough one ended.
    pub const LAST: Self = Self { rounds: 4, near: 0.0, hopeless: HOPELESS };
}

/// Gauss–Newton steps, their first damping as a share of the diagonal, dampings that are tried for a step, and the relative change by which
/// slopes are found.
const STEPS: usize = 8;
/// Steps after which a descent from elsewhere has to come as near to the best score as this factor.
const FIRST_STEPS: usize = 3;
const FAR: f64 = 1.5;
const FIRST_DAMPING: f64 = 0.02;
const DAMPINGS: usize = 4;
const SLOPE: f64 = 0.02;
/// Periods that go from one average to another at first.
const FIRST_EXCHANGE: f64 = 4.0;
/// A gain below this share of the score ends the rounds.
const LEAST_GAIN: f64 = 0.01;

/// A pattern search on runs.
pub(super) struct Search<'a> {
    runs: &'a [&'a Observed],
    parameters: &'a [Parameter],
}

impl<'a> Search<'a> {
    pub fn new(runs: &'a [&'a Observed], parameters: &'a [Parameter]) -> Self {
        Self { runs, parameters }
    }

    /// The best score and machine near `first` after Gauss–Newton steps, restarts and rounds over the parameters one by one; less of it where
    /// the score stays above `hopeless`.
    pub fn best(&self, first: MachineSpec, effort: Effort, hopeless: f64) -> (f64, MachineSpec) {
        let mut best = (Fidelity::of(&first, self.runs).score(), first);
        self.descend(&mut best, hopeless / FAR);
        if effort.near > 0.0 && best.0 <= effort.near * hopeless {
            self.restart(&mut best);
        }
        let mut factors = vec![FIRST_FACTOR; self.parameters.len()];
        for _ in 0..effort.rounds {
            if best.0 > hopeless {
                break;
            }
            let before = best.0;
            for (parameter, factor) in self.parameters.iter().zip(&mut factors) {
                self.along(parameter, factor, &mut best);
            }
            self.exchange(&mut best);
            let small = factors.iter().all(|factor| *factor < SMALL_FACTOR);
            if small && best.0 > (1.0 - LEAST_GAIN) * before {
                break;
            }
        }
        best
    }

    /// Gauss–Newton steps on all parameters at once, for they are related: acceleration and averages make the same time, for instance.
    /// Ends where the score is still far above `other` after the first steps.
    fn descend(&self, best: &mut (f64, MachineSpec), other: f64) {
        let mut damping = FIRST_DAMPING;
        for step in 0..STEPS {
            if step >= FIRST_STEPS && best.0 > FAR * other {
                return;
            }
            let Some(residuals) = self.residuals(&best.1) else { return };
            let weights: Vec<f64> = residuals.iter().map(|residual| 1.0 / residual.abs().max(1.0)).collect();
            let columns: Vec<Option<Vec<f64>>> =
                self.parameters.par_iter().map(|parameter| self.slope(parameter, &best.1, &residuals)).collect();
            let n = columns.len();
            let product =
                |a: &[f64], b: &[f64]| a.iter().zip(b).zip(&weights).map(|((a, b), weight)| a * b * weight).sum::<f64>();
            let normal =
                DMatrix::from_fn(n, n, |i, j| columns[i].as_ref().zip(columns[j].as_ref()).map_or(0.0, |(a, b)| product(a, b)));
            let right = DVector::from_fn(n, |i, _| columns[i].as_ref().map_or(0.0, |column| -product(column, &residuals)));
            let before = best.0;
            for _ in 0..DAMPINGS {
                let damped =
                    DMatrix::from_fn(n, n, |i, j| normal[(i, j)] + if i == j { damping * normal[(i, i)] + 1e-9 } else { 0.0 });
                let Some(step) = damped.lu().solve(&right) else { break };
                let mut next = best.1.clone();
                for (parameter, step) in self.parameters.iter().zip(step.iter()) {
                    parameter.set(&mut next, parameter.moved(parameter.of(&best.1), *step));
                }
                let score = Fidelity::of(&next, self.runs).score();
                if score < best.0 {
                    *best = (score, next);
                    damping = (damping / 5.0).max(1e-4);
                    break;
                }
                damping *= 5.0;
            }
            if best.0 > (1.0 - LEAST_GAIN) * before {
                return;
            }
        }
    }

    /// Descends from other values of the limits that hide one another: where one of them is never reached, no slope says so.
    fn restart(&self, best: &mut (f64, MachineSpec)) {
        for parameter in self.parameters {
            for value in parameter.other_starts(&best.1) {
                let mut other = best.1.clone();
                parameter.set(&mut other, value);
                let mut other = (Fidelity::of(&other, self.runs).score(), other);
                self.descend(&mut other, best.0);
                if other.0 < best.0 {
                    *best = other;
                }
            }
        }
    }

    /// Differences of all runs in units of what a forecast stands; `None` where a plan is impossible.
    fn residuals(&self, machine: &MachineSpec) -> Option<Vec<f64>> {
        let mut residuals = Vec::new();
        for run in self.runs {
            let found = run.difference(machine)?;
            residuals.extend(found.late_s.iter().map(|late_s| late_s / (TIME_SHARE * CELL_S)));
            residuals.extend(found.off_mm.iter().map(|off_mm| off_mm / PATH_MM));
        }
        Some(residuals)
    }

    /// Change of the residuals with a parameter, by a difference: per step of what is stepped, else per relative change.
    fn slope(&self, parameter: &Parameter, machine: &MachineSpec, residuals: &[f64]) -> Option<Vec<f64>> {
        [1.0, -1.0].into_iter().find_map(|direction: f64| {
            let step = direction * if parameter.is_stepped() { 1.0 } else { SLOPE };
            let mut next = machine.clone();
            parameter.set(&mut next, parameter.moved(parameter.of(machine), step));
            let changed = parameter.of(&next) != parameter.of(machine);
            let moved = self.residuals(&next).filter(|_| changed)?;
            Some(moved.iter().zip(residuals).map(|(moved, residual)| (moved - residual) / step).collect())
        })
    }

    /// Moves time from one average to another while that gains: their sum is known long before their shares.
    fn exchange(&self, best: &mut (f64, MachineSpec)) {
        let pairs = self.parameters.iter().flat_map(|from| self.parameters.iter().map(move |to| (from, to)));
        for (from, to) in pairs.filter(|(from, to)| from.adds_to(to)) {
            let mut periods = FIRST_EXCHANGE;
            while periods >= 1.0 {
                let step_ms = periods * from.range[0];
                let mut next = best.1.clone();
                from.set(&mut next, from.of(&best.1) - step_ms);
                to.set(&mut next, to.of(&best.1) + step_ms);
                let score = Fidelity::of(&next, self.runs).score();
                if score < best.0 {
                    *best = (score, next);
                } else {
                    periods /= 2.0;
                }
            }
        }
    }

    /// Moves one parameter while that gains, then halves the step.
    fn along(&self, parameter: &Parameter, factor: &mut f64, best: &mut (f64, MachineSpec)) {
        let mut moved = false;
        for direction in [1.0, -1.0] {
            loop {
                let mut next = best.1.clone();
                parameter.set(&mut next, parameter.step(parameter.of(&best.1), *factor, direction));
                if parameter.of(&next) == parameter.of(&best.1) {
                    break;
                }
                let score = Fidelity::of(&next, self.runs).score();
                if score >= best.0 {
                    break;
                }
                *best = (score, next);
                moved = true;
            }
            if moved {
                break;
            }
        }
        *factor = factor.powf(if moved { 0.7 } else { 0.4 }).max(LAST_FACTOR);
    }
}

/// The score may grow by this share within the interval of a parameter.
const INTERVAL: f64 = 1.1;
/// Factors that are tried for the ends of an interval.
const ENDS: [f64; 6] = [1.01, 1.02, 1.05, 1.1, 1.3, 2.0];

/// The range of a parameter around `machine` within which the agreement stays as it is within a tenth.
pub(super) fn interval(runs: &[&Observed], machine: &MachineSpec, parameter: &Parameter) -> [f64; 2] {
    let (value, most) = (parameter.of(machine), INTERVAL * Fidelity::of(machine, runs).score());
    [-1.0, 1.0].map(|direction: f64| {
        let end = |factor: &f64| {
            let mut other = machine.clone();
            parameter.set(&mut other, value * factor.powf(direction));
            (Fidelity::of(&other, runs).score() <= most).then(|| parameter.of(&other))
        };
        ENDS.iter().map_while(end).last().unwrap_or(value)
    })
}
