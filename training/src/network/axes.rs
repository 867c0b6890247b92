//! All axes of a machine at once.

use super::{Epoch, NetworkRecipe, Trained, train};
use crate::{TrainingError, staged::AxisRun};

/// The runs of one axis.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct AxisRuns {
    /// Runs to train on.
    pub training: Vec<AxisRun>,
    /// Runs to validate on.
    pub held_out: Vec<AxisRun>,
}

/// Trains one network per axis, each in its own thread. Axis `i` has the seed `seed + i`: the
/// result does not depend on the threads or the other axes. `on_epoch` receives the axis index with
/// each epoch.
///
/// # Errors
/// As [`train`], of the first axis that fails.
pub fn train_axes(
    axes: &[AxisRuns],
    recipe: &NetworkRecipe,
    seed: u64,
    on_epoch: &(dyn Fn(usize, Epoch) + Sync),
) -> Result<Vec<Trained>, TrainingError> {
    std::thread::scope(|scope| {
        let threads: Vec<_> = axes
            .iter()
            .enumerate()
            .map(|(axis, AxisRuns { training, held_out })| {
                let seed = seed.wrapping_add(axis as u64);
                scope.spawn(move || train(training, held_out, recipe, seed, &mut |epoch| on_epoch(axis, epoch)))
            })
            .collect();
        threads.into_iter().map(|thread| thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))).collect()
    })
}
