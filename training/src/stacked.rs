//! The network stage: trained on what the staged predictor leaves, kept only if blocks that it never saw say that it pays.

use std::ops::ControlFlow;

use models::AxisPredictor;
use models::staged::StagedPredictor;

use crate::TrainingError;
use crate::network::{NetworkRecipe, held_out_error, train_on_residual};
use crate::staged::AxisRun;

/// Parts that a log is cut into, or that its runs are dealt out to.
const PARTS: usize = 8;
/// Parts that are held out: an uneven choice, so that a log that repeats one cycle does not lose all of a motion.
const HELD_OUT: [usize; 3] = [1, 4, 6];
/// Start of a part that begins in motion, which is not counted, s: parts overlap by it.
const OVERLAP_S: f64 = 0.3;
/// Least gain in RMS, as a share, for which a network is taken.
const LEAST_GAIN: f64 = 0.05;

/// What became of the network stage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StackReport {
    /// Root mean square error of the staged predictor on the parts held out, mm or rad.
    pub without: f64,
    /// The same with the network that was trained on the other parts.
    pub with: f64,
    /// Whether the network pays.
    pub accepted: bool,
}

/// Whether a network on what `base` leaves of `runs` pays: it has to lower the RMS error on held-out parts by a twentieth, and on most
/// of them.
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
    // A network that is no better half way through will not be at the end.
    let hopeless = |rms: f64, epoch: usize| 2 * epoch >= recipe.epochs && rms >= without;
    let trial = train_on_residual(base, &fitted, &held_out, recipe, seed, &mut |epoch| match epoch.held_out_rms {
        Some(rms) if hopeless(rms, epoch.epoch) => ControlFlow::Break(()),
        _ => ControlFlow::Continue(()),
    })?;
    report.with = trial.held_out_rms;
    let run_error = |predictor: &dyn AxisPredictor, run: &AxisRun| held_out_error(predictor, std::slice::from_ref(run));
    let better = held_out.iter().filter(|run| run_error(trial.predictor.as_ref(), run) < run_error(base, run)).count();
    report.accepted = report.with < (1.0 - LEAST_GAIN) * without && 2 * better > held_out.len();
    Ok(report)
}

/// `base` with a network on what it leaves of all `runs`.
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

/// Runs to learn from and runs to judge by: whole ones where there are enough, else parts of each.
fn split(runs: &[AxisRun]) -> (Vec<AxisRun>, Vec<AxisRun>) {
    let (mut fitted, mut held_out) = (Vec::new(), Vec::new());
    if runs.len() >= PARTS {
        for (index, run) in runs.iter().enumerate() {
            if HELD_OUT.contains(&(index % PARTS)) { held_out.push(run.clone()) } else { fitted.push(run.clone()) }
        }
        return (fitted, held_out);
    }
    for run in runs {
        let n = run.reference.len();
        let overlap = (OVERLAP_S / run.period_s).ceil() as usize;
        let cut = |from: usize, to: usize| {
            let rows = (from * n / PARTS).saturating_sub(if from > 0 { overlap } else { 0 })..to * n / PARTS;
            AxisRun { reference: run.reference[rows.clone()].to_vec(), actual: run.actual[rows].to_vec(), period_s: run.period_s }
        };
        let mut from = 0;
        for part in HELD_OUT {
            fitted.extend((from < part).then(|| cut(from, part)));
            held_out.push(cut(part, part + 1));
            from = part + 1;
        }
        fitted.extend((from < PARTS).then(|| cut(from, PARTS)));
    }
    let long = |run: &AxisRun| run.reference.len() as f64 * run.period_s > 2.0 * OVERLAP_S;
    fitted.retain(long);
    held_out.retain(long);
    (fitted, held_out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_held_out_are_not_learned_from() {
        let n = 8000;
        let run = AxisRun { reference: (0..n).map(f64::from).collect(), actual: vec![0.0; 8000], period_s: 0.001 };
        let (fitted, held_out) = split(std::slice::from_ref(&run));
        assert_eq!((fitted.len(), held_out.len()), (4, 3));
        // Of each part the overlap with the one before is not counted.
        let counted =
            |run: &AxisRun| (run.reference[if run.reference[0] > 0.0 { 300 } else { 0 }], run.reference[run.reference.len() - 1]);
        let mut stretches: Vec<(f64, f64)> = fitted.iter().chain(&held_out).map(counted).collect();
        stretches.sort_by(|a, b| a.0.total_cmp(&b.0));
        assert_eq!(stretches[0].0, 0.0);
        assert!(stretches.windows(2).all(|pair| pair[1].0 == pair[0].1 + 1.0));
        assert_eq!(stretches[6].1, 7999.0);
    }
}
