//! The network stage: trained on the residual of the staged predictor, kept only if it lowers the
//! error on held-out blocks.

use std::ops::ControlFlow;

use models::AxisPredictor;
use models::staged::StagedPredictor;

use crate::network::{NetworkRecipe, held_out_error, part_errors, train_on_residual};
use crate::{AxisRun, TrainingError};

/// Number of parts into which a log is cut or its runs are distributed.
const PARTS: usize = 8;
/// Held-out parts. The irregular choice avoids that a log which repeats one cycle loses all of one
/// motion.
const HELD_OUT: [usize; 3] = [1, 4, 6];
/// Minimum RMS gain, as a share, for a network to be accepted.
const LEAST_GAIN: f64 = 0.05;

/// Result of the trial of the network stage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StackReport {
    /// RMS error of the staged predictor on the held-out parts, mm or rad.
    pub without: f64,
    /// RMS error with the network trained on the other parts, mm or rad.
    pub with: f64,
    /// Whether the network is accepted.
    pub accepted: bool,
}

/// Tests whether a network on the residual of `base` is accepted: it must lower the RMS error on
/// the held-out parts by 5 %, and the error of most parts.
///
/// # Errors
/// When the runs cannot be used.
pub fn try_out(
    base: &StagedPredictor,
    runs: &[AxisRun],
    recipe: &NetworkRecipe,
    seed: u64,
) -> Result<StackReport, TrainingError> {
    let (fitted, held_out) = split(runs);
    let without = held_out_error(base, &held_out);
    let mut report = StackReport { without, with: without, accepted: false };
    if fitted.is_empty() || held_out.is_empty() {
        return Ok(report);
    }
    // A network without a gain after half of the epochs is not continued.
    let hopeless = |rms: f64, epoch: usize| 2 * epoch >= recipe.epochs && rms >= without;
    let trial = train_on_residual(base, &fitted, &held_out, recipe, seed, &mut |epoch| match epoch.held_out_rms {
        Some(rms) if hopeless(rms, epoch.epoch) => ControlFlow::Break(()),
        _ => ControlFlow::Continue(()),
    })?;
    report.with = trial.held_out_rms;
    let (with, without_it) = (part_errors(trial.predictor.as_ref(), &held_out), part_errors(base, &held_out));
    let better = with.iter().zip(&without_it).filter(|(with, without)| with < without).count();
    report.accepted = report.with < (1.0 - LEAST_GAIN) * without && 2 * better > with.len();
    Ok(report)
}

/// `base` with a network trained on its residual on all `runs`.
///
/// # Errors
/// When the runs cannot be used.
pub fn fit(
    base: &StagedPredictor,
    runs: &[AxisRun],
    recipe: &NetworkRecipe,
    seed: u64,
) -> Result<Box<dyn AxisPredictor>, TrainingError> {
    let once = NetworkRecipe { validate_every: recipe.epochs, ..recipe.clone() };
    Ok(train_on_residual(base, runs, runs, &once, seed, &mut |_| ControlFlow::Continue(()))?.predictor)
}

/// Splits into training and held-out runs: whole runs if there are enough, else rows of each.
fn split(runs: &[AxisRun]) -> (Vec<AxisRun>, Vec<AxisRun>) {
    if runs.len() >= PARTS {
        let (held_out, fitted): (Vec<_>, Vec<_>) =
            runs.iter().enumerate().partition(|(index, _)| HELD_OUT.contains(&(index % PARTS)));
        let own = |part: Vec<(usize, &AxisRun)>| part.into_iter().map(|(_, run)| run.clone()).collect();
        return (own(fitted), own(held_out));
    }
    let held = |run: &AxisRun| HELD_OUT.map(|part| part * run.reference.len() / PARTS..(part + 1) * run.reference.len() / PARTS);
    let counts = |run: &AxisRun| run.scored_len() > 0;
    let fitted = runs.iter().map(|run| run.without(&held(run))).filter(counts).collect();
    (fitted, runs.iter().map(|run| run.only(&held(run))).filter(counts).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_held_out_are_not_learned_from() {
        let n = 8000;
        let run = AxisRun::new((0..n).map(f64::from).collect(), vec![0.0; 8000], 0.001);
        let (fitted, held_out) = split(std::slice::from_ref(&run));
        assert_eq!(held_out[0].rows, [1000..2000, 4000..5000, 6000..7000]);
        assert_eq!(fitted[0].rows, [0..1000, 2000..4000, 5000..6000, 7000..8000]);
        assert_eq!(fitted[0].scored_len() + held_out[0].scored_len(), 7700);
    }
}
