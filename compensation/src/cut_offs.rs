//! The spatial law on a model with decreasing cut-offs.

use machine::Machine;
use motion::contour::Exact;
use motion::{DesiredPath, Trajectory};

use crate::laws::{Gain, SpatialIlc};
use crate::learn::{learn, learn_from};
use crate::{CompensationError, CorrectionLimits, Iteration, LowPass, StopRule};

/// Minimum improvement of the cost, as a share, by an update, and of the uncompensated cost by a cut-off.
const WORTH: f64 = 0.01;

/// Settings of the cut-off candidates of the spatial law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CutOffCandidates {
    /// Duration around a turn in which the tracking error replaces the contour error, s; `None` if
    /// the control replans the time.
    pub turn_s: Option<f64>,
    /// Maximum number of updates with one cut-off.
    pub updates: usize,
    /// Maximum number of cut-offs.
    pub cut_offs: usize,
}

/// Gain of the spatial law: below 1, so that a model whose static gain is a little above 1 still
/// converges.
const SPATIAL_GAIN: f64 = 0.9;
/// First cut-off as a share of the Nyquist frequency, and ratio of successive cut-offs.
const FIRST_CUT_OFF: f64 = 0.4;
const NEXT_CUT_OFF: f64 = 0.4;

/// The spatial law on `machine` with decreasing cut-offs from near the Nyquist frequency. Returns
/// all runs in order, the uncompensated one first. Lower cut-offs are tried while the predicted
/// cost falls; if the highest gains nothing, down to the first that does. The uncompensated run is made where it is not given.
///
/// # Errors
/// When the machine refuses a reference, or a moved pose cannot be reached.
pub fn spatial_candidates(
    machine: &mut dyn Machine,
    desired: &DesiredPath,
    limits: &CorrectionLimits,
    settings: &CutOffCandidates,
    uncompensated: Option<Iteration>,
    measure: &mut (dyn FnMut(&DesiredPath, &Trajectory) -> f64 + Send),
) -> Result<Vec<Iteration>, CompensationError> {
    let period_s = desired.trajectory().period_s();
    let mut cut_off_hz = FIRST_CUT_OFF * 0.5 / period_s;
    let mut iterations: Vec<Iteration> = Vec::new();
    let mut best = f64::INFINITY;
    for _ in 0..settings.cut_offs {
        let law = SpatialIlc::new(Gain::Constant(SPATIAL_GAIN), LowPass::new(cut_off_hz, period_s)?)?;
        let law = law.with_estimator(Box::new(Exact::default()));
        let mut law = if let Some(turn_s) = settings.turn_s { law.with_tracking_in_turns(turn_s) } else { law };
        let stop = StopRule::while_better(settings.updates, WORTH);
        // The uncompensated run is the same for every cut-off.
        let first = iterations.first().or(uncompensated.as_ref()).cloned();
        let learned = match first {
            Some(first) => learn_from(machine, &mut law, desired, first, limits, &stop, measure),
            None => learn(machine, &mut law, desired, None, limits, &stop, measure),
        };
        let learned = learned?.iterations;
        let uncompensated = learned[0].measure;
        let reached = learned.iter().map(|iteration| iteration.measure).fold(f64::INFINITY, f64::min);
        let skip = usize::from(!iterations.is_empty());
        iterations.extend(learned.into_iter().skip(skip));
        if reached > best && best < (1.0 - WORTH) * uncompensated {
            break;
        }
        best = best.min(reached);
        cut_off_hz *= NEXT_CUT_OFF;
    }
    Ok(iterations)
}
