//! Runs as scaled rows and targets, and their training windows.

use std::ops::Range;

use burn::tensor::{Device, Tensor, TensorData};
use models::features::velocity;
use models::narx::PAST_ERRORS;
use models::staged::StagedPredictor;
use models::{AxisPredictor, AxisSignal, FeatureSet, FeatureSpec, Scaler};
use rand::RngExt;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::{NetworkRecipe, windows::FlagWindows};
use crate::{TrainingError, staged::AxisRun};

/// Inputs and target of a network.
#[derive(Debug, Clone)]
pub enum Task {
    /// The tracking error from the papers' features.
    Papers(FeatureSpec),
    /// The residual of a staged predictor, from that predictor's signals.
    Residual(StagedPredictor),
}

impl Task {
    /// The papers' features, with the flag windows identified from these runs.
    ///
    /// # Errors
    /// When the runs do not fit together, or the axis never moves.
    pub fn papers(runs: &[AxisRun], set: FeatureSet) -> Result<Self, TrainingError> {
        check_runs(runs)?;
        let flags = FlagWindows::identify(runs);
        let acceleration = |run: &AxisRun| {
            let v = velocity(&run.reference, run.period_s);
            v.windows(2).map(|pair| ((pair[1] - pair[0]) / run.period_s).abs()).fold(0.0, f64::max)
        };
        let acceleration_max = runs.iter().map(acceleration).fold(0.0, f64::max);
        if acceleration_max == 0.0 {
            return Err(TrainingError::Unusable("the axis never moves".into()));
        }
        let (backlash_window, start_window) = (flags.backlash, flags.start);
        Ok(Self::Papers(FeatureSpec { set, backlash_window, start_window, acceleration_max }))
    }

    /// Values per sample of [`Self::rows`].
    pub fn width(&self) -> usize {
        match self {
            Self::Papers(spec) => spec.width(),
            Self::Residual(base) => base.nonlinear_width(),
        }
    }

    /// Network inputs, row-major.
    fn rows(&self, signal: &AxisSignal<'_>) -> Vec<f32> {
        match self {
            Self::Papers(spec) => spec.rows(signal),
            Self::Residual(base) => base.nonlinear_rows(signal),
        }
    }

    /// Targets, mm or rad.
    fn targets(&self, run: &AxisRun) -> Vec<f32> {
        let errors = run.tracking_error();
        match self {
            Self::Papers(_) => errors.into_iter().map(|e| e as f32).collect(),
            Self::Residual(base) => {
                let known = base.predict(&AxisSignal::uncompensated(&run.reference, run.period_s));
                errors.into_iter().zip(known).map(|(e, known)| (e - known) as f32).collect()
            }
        }
    }
}

/// Maps signals to network inputs and network outputs to errors.
#[derive(Debug, Clone)]
pub struct Scaling {
    /// Inputs and target.
    pub task: Task,
    /// Scale of the features.
    pub inputs: Scaler,
    /// Scale of the tracking error.
    pub targets: Scaler,
    /// Largest scaled tracking error.
    pub largest: f32,
}

/// One run with standstill padding on both sides, so that every window is full.
#[derive(Debug)]
struct Sequence {
    rows: Vec<f32>,
    targets: Vec<f32>,
    counted: Vec<Range<usize>>,
}

/// The training runs of one axis.
#[derive(Debug)]
pub struct AxisDataset {
    /// Scaling of the rows and targets.
    pub scaling: Scaling,
    sequences: Vec<Sequence>,
    width: usize,
    window: usize,
    warmup: usize,
}

/// A batch of windows.
pub struct Batch {
    /// Scaled features, `[windows, steps, features]`.
    pub inputs: Tensor<3>,
    /// Scaled errors, `[windows, steps, 1]`.
    pub targets: Tensor<3>,
    /// 1 where an error counts, else 0, `[windows, steps, 1]`.
    pub mask: Tensor<3>,
    /// Number of samples that count.
    pub counted: usize,
}

/// Checks the runs: same period, equal lengths, finite numbers. Returns the period, s.
pub fn check_runs(runs: &[AxisRun]) -> Result<f64, TrainingError> {
    let period_s = runs.first().map_or(f64::NAN, |run| run.period_s);
    if !(period_s.is_finite() && period_s > 0.0) {
        return Err(TrainingError::Unusable("no run with a period".into()));
    }
    for (index, run) in runs.iter().enumerate() {
        let unusable = |why: &str| Err(TrainingError::Unusable(format!("run {index}: {why}")));
        if (run.period_s / period_s - 1.0).abs() > 1e-6 {
            return unusable("its sampling period is another");
        }
        if run.reference.len() != run.actual.len() || run.reference.len() < 2 {
            return unusable("reference and actual have different lengths, or less than two samples");
        }
        if run.reference.iter().chain(&run.actual).any(|position| !position.is_finite()) {
            return unusable("a position is not a number");
        }
    }
    Ok(period_s)
}

impl AxisDataset {
    /// Rows and targets of the runs, scaled to unit size.
    pub fn new(runs: &[AxisRun], task: Task, recipe: &NetworkRecipe) -> Result<Self, TrainingError> {
        let period_s = check_runs(runs)?;
        let steps = |seconds: f64| (seconds / period_s).round().max(1.0) as usize;
        let (window, warmup) = (steps(recipe.window_s), steps(recipe.warmup_s));
        let width = task.width();
        let (lead, tail) = (warmup + window, window);
        let padded = |run: &AxisRun| {
            let reference = pad(&run.reference, lead, tail);
            task.rows(&AxisSignal::uncompensated(&reference, period_s))
        };
        let mut rows: Vec<Vec<f32>> = runs.iter().map(padded).collect();
        let errors: Vec<Vec<f32>> = runs.iter().map(|run| task.targets(run)).collect();
        let own = rows.iter().zip(runs).map(|(rows, run)| &rows[lead * width..(lead + run.reference.len()) * width]);
        let inputs = Scaler::fit(own, width);
        let known = errors.iter().zip(runs).flat_map(|(errors, run)| run.rows.iter().map(|rows| &errors[rows.clone()]));
        let targets = Scaler::fit(known, 1);
        rows.iter_mut().for_each(|rows| inputs.scale(rows));
        let past = if recipe.kind.cell().is_none() { PAST_ERRORS } else { 0 };
        let sequences: Vec<Sequence> = rows
            .into_iter()
            .zip(runs.iter().zip(errors))
            .map(|(rows, (run, errors))| {
                let mut scaled = vec![0.0; lead];
                scaled.extend(errors);
                scaled.resize(rows.len() / width, 0.0);
                targets.scale(&mut scaled);
                Sequence { rows: with_past(&rows, width, &scaled, past), targets: scaled, counted: run.scored() }
            })
            .collect();
        let largest = sequences.iter().flat_map(|s| &s.targets).fold(0.0_f32, |top, e| top.max(e.abs()));
        Ok(Self { scaling: Scaling { task, inputs, targets, largest }, sequences, width: width + past, window, warmup })
    }

    /// The windows of an epoch in random order. Each run is cut from a random offset, so that no
    /// sample is always at a cut.
    pub fn shuffled(&self, rng: &mut ChaCha8Rng) -> Vec<Window> {
        let mut windows = Vec::new();
        for (sequence, run) in self.sequences.iter().enumerate() {
            // A window that starts at `first` counts from `first + warmup` on; the run itself
            // starts at `warmup + window`.
            let first = self.window - rng.random_range(0..self.window);
            let end = self.window + run.counted.last().map_or(0, |rows| rows.end);
            let starts = (first..end).step_by(self.window);
            windows.extend(starts.map(|start| Window { sequence, start }).filter(|window| self.counted(window).next().is_some()));
        }
        windows.shuffle(rng);
        windows
    }

    /// Steps of a window whose errors count.
    fn counted(&self, window: &Window) -> impl Iterator<Item = Range<usize>> {
        let counted = &self.sequences[window.sequence].counted;
        let (lead, warmup, start) = (self.warmup + self.window, self.warmup, window.start);
        let within = move |k: usize| (k + lead).saturating_sub(start).clamp(warmup, lead);
        counted.iter().map(move |rows| within(rows.start)..within(rows.end)).filter(|steps| !steps.is_empty())
    }

    /// The windows as tensors.
    pub fn batch(&self, windows: &[Window], device: &Device) -> Batch {
        let steps = self.warmup + self.window;
        let mut inputs = Vec::with_capacity(windows.len() * steps * self.width);
        let mut targets = Vec::with_capacity(windows.len() * steps);
        let mut mask = vec![0.0_f32; windows.len() * steps];
        for (window, mask) in windows.iter().zip(mask.chunks_exact_mut(steps)) {
            let run = &self.sequences[window.sequence];
            let (from, to) = (window.start, window.start + steps);
            inputs.extend_from_slice(&run.rows[from * self.width..to * self.width]);
            targets.extend_from_slice(&run.targets[from..to]);
            self.counted(window).for_each(|steps| mask[steps].fill(1.0));
        }
        let counted = mask.iter().filter(|weight| **weight > 0.0).count();
        let tensor = |values: Vec<f32>, width: usize| {
            Tensor::<3>::from_data(TensorData::new(values, [windows.len(), steps, width]), device)
        };
        Batch { inputs: tensor(inputs, self.width), targets: tensor(targets, 1), mask: tensor(mask, 1), counted }
    }
}

/// Position of a window in the dataset.
#[derive(Debug, Clone, Copy)]
pub struct Window {
    sequence: usize,
    start: usize,
}

/// Pads positions with a standstill before and after.
fn pad(positions: &[f64], before: usize, after: usize) -> Vec<f64> {
    let (first, last) = (positions.first().copied().unwrap_or_default(), positions.last().copied().unwrap_or_default());
    std::iter::repeat_n(first, before).chain(positions.iter().copied()).chain(std::iter::repeat_n(last, after)).collect()
}

/// The rows, each followed by the `past` errors before it, newest first.
fn with_past(rows: &[f32], width: usize, errors: &[f32], past: usize) -> Vec<f32> {
    let mut all = Vec::with_capacity(rows.len() / width.max(1) * (width + past));
    for (k, row) in rows.chunks_exact(width).enumerate() {
        all.extend_from_slice(row);
        // Before the run the axis is at the same standstill as at the first sample of the padding.
        all.extend((1..=past).map(|lag| errors[k.saturating_sub(lag)]));
    }
    all
}
