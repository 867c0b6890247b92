//! Learning on a model with a trust region: only what the forecast says is better is kept.

use machine::Machine;
use motion::contour::Exact;
use motion::{DesiredPath, Trajectory};

use crate::laws::{ContourOptimal, Gain, SpatialIlc};
use crate::learn::learn_from;
use crate::{CompensationError, CompensationLaw, Guard, LowPass, Round, StopRule};

/// Why a descent ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// The forecast came within the floor that was asked for.
    AtFloor,
    /// No step improves the forecast any more.
    AtOptimum,
    /// All runs were used.
    AtRuns,
}

/// Settings of a descent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Descent {
    /// Most runs of the model, the first one included.
    pub runs: usize,
    /// Measure at which nothing is gained by going on: what the model itself is uncertain by.
    pub floor: f64,
    /// Damping of the first step, and the least.
    pub damping: [f64; 2],
}

impl Default for Descent {
    /// Twelve runs; the first step leaves alone what the machine answers to by less than a sixth, the last ones by less than a thirtieth.
    fn default() -> Self {
        Self { runs: 12, floor: 0.0, damping: [0.03, 3e-3] }
    }
}

/// Factor on the damping after a step that improved, and after one that did not.
const EASE: f64 = 0.3;
const TIGHTEN: f64 = 6.0;
/// Improvement of the measure, as a share, that makes a step one.
const WORTH: f64 = 0.01;
/// Steps in a row that may bring nothing: the second is damped more.
const PATIENCE: usize = 2;

/// Runs the law's steps on `machine` from the run `start`: every run, that one included, rejected ones too, in order. A step starts from the best run so
/// far; where it is no better, the next one is damped more.
///
/// # Errors
/// When the machine refuses a reference, or the law does not fit it.
pub fn descend(
    machine: &mut dyn Machine,
    law: &mut ContourOptimal,
    desired: &DesiredPath,
    start: Round,
    guard: &Guard,
    settings: &Descent,
    measure: &mut dyn FnMut(&DesiredPath, &Trajectory) -> f64,
) -> Result<(Vec<Round>, Ended), CompensationError> {
    let mut run = |reference: Trajectory| -> Result<Round, CompensationError> {
        let actual = machine.run(&reference)?;
        let measure = measure(desired, &actual);
        Ok(Round { reference, actual, measure })
    };
    let mut rounds = vec![start];
    let (mut best, mut damping, mut failures) = (0, settings.damping[0], 0);
    while rounds.len() < settings.runs {
        if rounds[best].measure <= settings.floor {
            return Ok((rounds, Ended::AtFloor));
        }
        law.damp(damping)?;
        let next = law.update(desired, &rounds[best].reference, &rounds[best].actual)?;
        let next = run(guard.apply(desired, &next)?)?;
        let before = rounds[best].measure;
        let better = next.measure < before;
        let worth = next.measure < (1.0 - WORTH) * before;
        rounds.push(next);
        if better {
            best = rounds.len() - 1;
        }
        damping = if worth { (damping * EASE).max(settings.damping[1]) } else { damping * TIGHTEN };
        failures = if worth { 0 } else { failures + 1 };
        if failures >= PATIENCE {
            return Ok((rounds, Ended::AtOptimum));
        }
    }
    Ok((rounds, Ended::AtRuns))
}

/// Updates of the spatial law with one cut-off at most: at a gain near 1 an update leaves a tenth of what the law can reach.
const SPATIAL_UPDATES: usize = 4;
/// Gain of the spatial law: below 1, so that a model whose static gain is a little above it still converges.
const SPATIAL_GAIN: f64 = 0.9;
/// First cut-off of the ladder as a share of the Nyquist frequency, the factor from one to the next, and how many there are at most.
const FIRST_CUT_OFF: f64 = 0.4;
const NEXT_CUT_OFF: f64 = 0.4;
const CUT_OFFS: usize = 5;

/// The spatial law on `machine`, with a ladder of cut-offs from near the Nyquist frequency downwards: every run, in order, the uncompensated one first. A lower
/// cut-off is tried while it makes a better forecast than the one above it; where the highest gains nothing, on to the first that does.
///
/// `turn_s` is the time in which a turn hands over to the tracking error, s; `None` where a control plans the time anew.
///
/// # Errors
/// When the machine refuses a reference, or a moved pose cannot be reached.
pub fn spatial_ladder(
    machine: &mut dyn Machine,
    desired: &DesiredPath,
    guard: &Guard,
    turn_s: Option<f64>,
    measure: &mut (dyn FnMut(&DesiredPath, &Trajectory) -> f64 + Send),
) -> Result<Vec<Round>, CompensationError> {
    let period_s = desired.trajectory().period_s();
    let mut cut_off_hz = FIRST_CUT_OFF * 0.5 / period_s;
    let mut rounds: Vec<Round> = Vec::new();
    let mut best = f64::INFINITY;
    for _ in 0..CUT_OFFS {
        let law = SpatialIlc::new(Gain::Constant(SPATIAL_GAIN), LowPass::new(cut_off_hz, period_s)?)?;
        let law = law.with_estimator(Box::new(Exact::default()));
        let mut law = if let Some(turn_s) = turn_s { law.with_tracking_in_turns(turn_s) } else { law };
        let stop = StopRule::while_better(SPATIAL_UPDATES, WORTH);
        // The uncompensated run is the same for every cut-off.
        let first = rounds.first().cloned();
        let learned = learn_from(machine, &mut law, desired, first, None, guard, &stop, measure)?.rounds;
        let uncompensated = learned[0].measure;
        let reached = learned.iter().map(|round| round.measure).fold(f64::INFINITY, f64::min);
        let skip = usize::from(!rounds.is_empty());
        rounds.extend(learned.into_iter().skip(skip));
        if reached > best && best < (1.0 - WORTH) * uncompensated {
            break;
        }
        best = best.min(reached);
        cut_off_hz *= NEXT_CUT_OFF;
    }
    Ok(rounds)
}
