//! Search of parameters: one at a time, by factors, until none gains.

use machine::MachineSpec;

use super::fidelity::Fidelity;
use super::observed::Observed;
use super::parameters::Parameter;

/// First factor of a step, the least one, and the one below which a round without gain is the last.
const FIRST_FACTOR: f64 = 1.5;
const LAST_FACTOR: f64 = 1.01;
const SMALL_FACTOR: f64 = 1.05;
/// Rounds over all parameters while structures are compared, and of the last fit.
pub(super) const ROUNDS: usize = 6;
pub(super) const LAST_ROUNDS: usize = 8;
/// Rounds after which a fit may be hopeless.
const TRIAL_ROUNDS: usize = 2;
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

    /// The best score and machine near `first` after at most so many rounds; fewer where the score stays above `hopeless`.
    pub fn best(&self, first: MachineSpec, rounds: usize, hopeless: f64) -> (f64, MachineSpec) {
        let mut best = (Fidelity::of(&first, self.runs).score(), first);
        let mut factors = vec![FIRST_FACTOR; self.parameters.len()];
        for round in 0..rounds {
            if round >= TRIAL_ROUNDS && best.0 > hopeless {
                break;
            }
            let before = best.0;
            for (parameter, factor) in self.parameters.iter().zip(&mut factors) {
                self.along(parameter, factor, &mut best);
            }
            let small = factors.iter().all(|factor| *factor < SMALL_FACTOR);
            if small && best.0 > (1.0 - LEAST_GAIN) * before {
                break;
            }
        }
        best
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
        let holds = |factor: &&f64| {
            let mut other = machine.clone();
            parameter.set(&mut other, value * factor.powf(direction));
            Fidelity::of(&other, runs).score() <= most
        };
        let end = ENDS.iter().take_while(holds).last().copied().unwrap_or(1.0);
        (value * end.powf(direction)).clamp(parameter.range[0], parameter.range[1])
    })
}
