//! The training loop.

use std::ops::ControlFlow;
use std::path::Path;

use burn::optim::GradientsParams;
use burn::tensor::Device;
use models::recurrent::Adam;
use models::staged::StagedPredictor;
use models::{AxisPredictor, AxisSignal};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::checkpoint::{Progress, State, identity};
use super::dataset::{AxisDataset, Task, check_runs};
use super::{NetworkRecipe, clip_global_norm, net::Net};
use crate::{TrainingError, staged::AxisRun};

/// Adam's `ε`.
const EPSILON: f32 = 1e-8;

/// Result of an epoch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Epoch {
    /// Number of the epoch, from 1.
    pub epoch: usize,
    /// Maximum number of epochs.
    pub of: usize,
    /// Mean squared error of the training steps, on the scaled tracking error.
    pub loss: f64,
    /// Learning rate.
    pub learning_rate: f64,
    /// RMS prediction error on the held-out runs, mm or rad; `None` if the epoch was not validated.
    pub held_out_rms: Option<f64>,
}

/// A trained network.
#[derive(Debug)]
pub struct Trained {
    /// The network with the least held-out error, as a predictor.
    pub predictor: Box<dyn AxisPredictor>,
    /// Epoch of that network.
    pub best_epoch: usize,
    /// Number of epochs run.
    pub epochs: usize,
    /// RMS prediction error of that network on the held-out runs, mm or rad.
    pub held_out_rms: f64,
}

/// Trains a network on `runs` of one axis and keeps the weights that predict `held_out` best.
///
/// Windows of the runs are shuffled into mini-batches. Each Adam step minimises the mean squared
/// error of the scaled tracking error over the counted parts of the windows. The same runs, recipe
/// and seed give the same weights, bit by bit.
///
/// # Errors
/// When the runs or the recipe cannot be used, or the training diverges.
pub fn train(
    runs: &[AxisRun],
    held_out: &[AxisRun],
    recipe: &NetworkRecipe,
    seed: u64,
    on_epoch: &mut dyn FnMut(Epoch),
) -> Result<Trained, TrainingError> {
    run(Task::papers(runs, recipe.features)?, runs, held_out, recipe, seed, None, &mut |epoch| {
        on_epoch(epoch);
        ControlFlow::Continue(())
    })
}

/// As [`train`], on the residual of `base`. The result is the sum of both. The caller can stop
/// after any epoch.
///
/// # Errors
/// As [`train`]; when the recipe is that of a NARX network.
pub fn train_on_residual(
    base: &StagedPredictor,
    runs: &[AxisRun],
    held_out: &[AxisRun],
    recipe: &NetworkRecipe,
    seed: u64,
    on_epoch: &mut dyn FnMut(Epoch) -> ControlFlow<()>,
) -> Result<Trained, TrainingError> {
    run(Task::Residual(base.clone()), runs, held_out, recipe, seed, None, on_epoch)
}

/// As [`train`], with a checkpoint in `folder` at each validation and at the end. Resumes from an
/// existing checkpoint. The caller can stop after any epoch; the result is then the best network so
/// far.
///
/// # Errors
/// As [`train`], and when a checkpoint cannot be written, read, or belongs to another training.
pub fn train_resumable(
    runs: &[AxisRun],
    held_out: &[AxisRun],
    recipe: &NetworkRecipe,
    seed: u64,
    folder: &Path,
    on_epoch: &mut dyn FnMut(Epoch) -> ControlFlow<()>,
) -> Result<Trained, TrainingError> {
    run(Task::papers(runs, recipe.features)?, runs, held_out, recipe, seed, Some(folder), on_epoch)
}

fn run(
    task: Task,
    runs: &[AxisRun],
    held_out: &[AxisRun],
    recipe: &NetworkRecipe,
    seed: u64,
    folder: Option<&Path>,
    on_epoch: &mut dyn FnMut(Epoch) -> ControlFlow<()>,
) -> Result<Trained, TrainingError> {
    recipe.check()?;
    check_runs(held_out)?;
    let dataset = AxisDataset::new(runs, task, recipe)?;
    let device = Device::flex().autodiff();
    let net = Net::draw(recipe, dataset.scaling.task.width(), &mut rng(seed, 0), &device)?;
    let progress =
        Progress { of: identity(runs, held_out, recipe, seed)?, epochs: 0, best_epoch: 0, best_rms: None, failures: 0 };
    let optimizer = Adam::new(EPSILON).into();
    let mut state = State { best: net.clone(), net, optimizer, progress };
    if let Some(folder) = folder {
        state = state.resumed(folder)?;
    }
    while state.progress.epochs < recipe.epochs && state.progress.failures < recipe.patience {
        let learning_rate = recipe.rate(state.progress.epochs);
        let loss = epoch(&mut state, &dataset, recipe, learning_rate, seed, &device);
        state.progress.epochs += 1;
        let number = state.progress.epochs;
        let look = number.is_multiple_of(recipe.validate_every) || number == recipe.epochs;
        let held_out_rms = if look { Some(validate(&mut state, &dataset, held_out)?) } else { None };
        let flow = on_epoch(Epoch { epoch: number, of: recipe.epochs, loss, learning_rate, held_out_rms });
        if let Some(folder) = folder.filter(|_| look || flow.is_break()) {
            state.save(folder)?;
        }
        if flow.is_break() {
            break;
        }
    }
    let predictor = state.best.predictor(&dataset.scaling)?;
    let held_out_rms = state.progress.best_rms.unwrap_or_else(|| held_out_error(predictor.as_ref(), held_out));
    Ok(Trained { predictor, best_epoch: state.progress.best_epoch, epochs: state.progress.epochs, held_out_rms })
}

/// One pass over all windows; returns the mean loss.
fn epoch(state: &mut State, dataset: &AxisDataset, recipe: &NetworkRecipe, rate: f64, seed: u64, device: &Device) -> f64 {
    let mut rng = rng(seed, state.progress.epochs as u64 + 1);
    let windows = dataset.shuffled(&mut rng);
    let (mut sum, mut count) = (0.0, 0);
    for windows in windows.chunks(recipe.batch) {
        let batch = dataset.batch(windows, device);
        let errors = (state.net.forward(batch.inputs, &mut rng) - batch.targets) * batch.mask;
        let loss = (errors.clone() * errors).sum() / batch.counted as f64;
        sum += loss.clone().into_scalar::<f64>() * batch.counted as f64;
        count += batch.counted;
        let mut gradients = GradientsParams::from_grads(loss.backward(), &state.net);
        // A step along a non-finite gradient would make all weights non-finite.
        if clip_global_norm(&mut gradients, &state.net, recipe.clip_norm).is_finite() {
            state.net = state.optimizer.step(rate, state.net.clone(), gradients);
        }
    }
    sum / count.max(1) as f64
}

/// Validates on the held-out runs and keeps the network if its error is the least so far.
fn validate(state: &mut State, dataset: &AxisDataset, held_out: &[AxisRun]) -> Result<f64, TrainingError> {
    let rms = match state.net.predictor(&dataset.scaling) {
        Ok(predictor) => held_out_error(predictor.as_ref(), held_out),
        // Non-finite weights give no predictor.
        Err(_) if state.progress.best_rms.is_some() => f64::INFINITY,
        Err(error) => return Err(error.into()),
    };
    let Progress { epochs, best_epoch, best_rms, failures, .. } = &mut state.progress;
    if rms.is_finite() && best_rms.is_none_or(|best| rms < best) {
        (*best_rms, *best_epoch, *failures) = (Some(rms), *epochs, 0);
        state.best = state.net.clone();
    } else {
        *failures += 1;
    }
    Ok(rms)
}

/// RMS prediction error on `runs`, mm or rad, over the samples that count.
#[must_use]
pub fn held_out_error(predictor: &dyn AxisPredictor, runs: &[AxisRun]) -> f64 {
    let (squares, count) = runs.iter().flat_map(|run| squares(predictor, run)).fold((0.0, 0), |(a, b), (c, d)| (a + c, b + d));
    (squares / count.max(1) as f64).sqrt()
}

/// As [`held_out_error`], for each range of rows, run by run.
#[must_use]
pub fn part_errors(predictor: &dyn AxisPredictor, runs: &[AxisRun]) -> Vec<f64> {
    runs.iter().flat_map(|run| squares(predictor, run)).map(|(squares, count)| (squares / count.max(1) as f64).sqrt()).collect()
}

/// Sum of the squared prediction errors and number of samples, for each range of rows of a run.
fn squares(predictor: &dyn AxisPredictor, run: &AxisRun) -> Vec<(f64, usize)> {
    let predicted = predictor.predict(&AxisSignal::uncompensated(&run.reference, run.period_s));
    let errors = run.tracking_error();
    let square = |k: usize| (errors[k] - predicted.get(k).copied().unwrap_or(f64::NAN)).powi(2);
    run.scored().into_iter().map(|rows| (rows.clone().map(square).sum(), rows.len())).collect()
}

/// Random generator of an epoch: one stream of the seed per epoch.
fn rng(seed: u64, epoch: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(epoch);
    rng
}
