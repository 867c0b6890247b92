//! Adapting a predictor to another machine, or to the same one later, with a few seconds of its log.

use models::staged::{FeatureSet, MotionFactor, Pass, Scales, StagedPredictor};

use super::corpus::AxisDataset;
use super::gram::Penalty;
use super::recipe::StagedRecipe;
use crate::{AxisRun, TrainingError};

/// Columns of the linear law's response that are corrected one by one: sums over 1, 2, 3, 5 … samples.
const RESPONSE_COLUMNS: [usize; 8] = [0, 1, 2, 4, 7, 12, 20, 32];
/// Share by which a part of a pass is expected to be off on another machine.
const PART_SPREAD: f64 = 0.3;

/// What an adaptation did.
#[derive(Debug, Clone, PartialEq)]
pub struct AdaptReport {
    /// Weights of the correction.
    pub columns: usize,
    /// Scored samples of the log.
    pub samples: usize,
    /// Root mean square of the prediction's error on the log, before.
    pub before_rms: f64,
    /// The same, held out by folds of the log, after.
    pub held_out_rms: f64,
}

/// Fits a correction of some forty weights: a gain on what each operator, each slow term and each line contributes, and the low-order
/// terms of the linear law anew.
///
/// Every pass is corrected in turn, since each runs on the position that the one before expects. The predictor is returned as it was
/// where held-out parts of the log say that the correction does not pay.
///
/// # Errors
/// When the runs are unusable or sampled at another period.
pub fn adapt(
    predictor: &StagedPredictor,
    runs: &[AxisRun],
    recipe: &StagedRecipe,
) -> Result<(StagedPredictor, AdaptReport), TrainingError> {
    let corpus = AxisDataset::new(runs, recipe)?;
    if (corpus.period_s() / predictor.period_s() - 1.0).abs() > 1e-6 {
        return Err(TrainingError::Unusable(format!(
            "the log's period is {} s, the model's {} s",
            corpus.period_s(),
            predictor.period_s()
        )));
    }
    let mut expected = corpus.references();
    let mut old_expected = corpus.references();
    let mut passes = Vec::new();
    let mut report = None;
    for pass in predictor.passes() {
        let (adapted, mut pass_report) = adapt_pass(&corpus, pass, &expected, recipe)?;
        pass_report.before_rms = mean_square(&corpus, &corpus.left_by(pass, &old_expected)).sqrt();
        old_expected = corpus.expected_after(pass, &old_expected);
        expected = corpus.expected_after(&adapted, &expected);
        passes.push(adapted);
        report = Some(pass_report);
    }
    let report = report.ok_or_else(|| TrainingError::Unusable("the model has no pass".into()))?;
    if report.held_out_rms >= report.before_rms {
        return Ok((predictor.clone(), report));
    }
    Ok((StagedPredictor::new(predictor.period_s(), passes)?, report))
}

/// One pass with its parts scaled and its low-order terms corrected.
fn adapt_pass(
    corpus: &AxisDataset<'_>,
    pass: &Pass,
    expected: &[Vec<f64>],
    recipe: &StagedRecipe,
) -> Result<(Pass, AdaptReport), TrainingError> {
    let parts = parts(pass);
    let contributions: Vec<Vec<Vec<f64>>> = parts
        .iter()
        .map(|part| {
            let mut weights = vec![0.0; pass.weights.len()];
            for &(column, weight) in part {
                weights[column] = weight;
            }
            let features = pass.features.clone();
            corpus.predictions(&Pass { features, weights }, expected)
        })
        .collect();
    let nothing = FeatureSet { scales: Scales::linear(), groups: Vec::new() };
    let left = corpus.left_by(pass, expected);
    let signals = corpus.signals(&nothing, expected);
    let grams = corpus.grams(&nothing, &signals, &contributions, &left);
    let singular = || TrainingError::Singular("adaptation");
    let ridge = vec![Penalty::ridge(recipe.linear_ridge); parts.len()];
    let floor = grams.cross_validate(&ridge).ok_or_else(singular)?.mean_square();
    let penalties: Vec<Penalty> = parts
        .iter()
        .map(|part| Penalty {
            ridge: recipe.linear_ridge,
            // A part that is scaled is expected to be right; a column on its own is free.
            prior: if is_free(part) { 0.0 } else { floor * recipe.correlated / (PART_SPREAD * PART_SPREAD) },
        })
        .collect();
    let gains = grams.total().solve(&penalties).ok_or_else(singular)?;
    let held_out_rms = grams.cross_validate(&penalties).ok_or_else(singular)?.rms();
    let mut weights = pass.weights.clone();
    for (part, gain) in parts.iter().zip(gains) {
        for &(column, weight) in part {
            weights[column] += gain * weight;
        }
    }
    let adapted = Pass { features: pass.features.clone(), weights };
    let report = AdaptReport { columns: parts.len(), samples: corpus.samples(), before_rms: 0.0, held_out_rms };
    Ok((adapted, report))
}

/// Columns that are moved together, each with the weight by which it moves for a gain of one.
type Part = Vec<(usize, f64)>;

fn is_free(part: &Part) -> bool {
    part.len() == 1 && part.iter().all(|(_, weight)| *weight == 1.0)
}

/// Free columns of the linear law, and one part for each other channel (both waves of a line and carrier together).
fn parts(pass: &Pass) -> Vec<Part> {
    let mut parts: Vec<Part> = Vec::new();
    let mut keyed: Vec<((MotionFactor, Option<usize>), Part)> = Vec::new();
    let mut column = 0;
    for group in &pass.features.groups {
        let responses = group.basis.len();
        for channel in &group.channels {
            let columns = column..column + responses;
            column += responses;
            let line = channel.line();
            let linear = matches!(
                channel.motion,
                MotionFactor::One | MotionFactor::Velocity | MotionFactor::VelocityStep | MotionFactor::Sign
            );
            if linear && line.is_none() {
                let free = RESPONSE_COLUMNS.iter().filter(|&&i| i < responses);
                parts.extend(free.map(|i| vec![(columns.start + i, 1.0)]));
                continue;
            }
            // The terms of a line share one gain for each kind, so that the correction stays small.
            let key = match line {
                Some(_) if matches!(channel.motion, MotionFactor::Stop(_)) => (MotionFactor::Stop(0), line),
                Some(_) => (MotionFactor::One, line),
                None => (channel.motion, None),
            };
            let moved = columns.map(|i| (i, pass.weights[i]));
            match keyed.iter_mut().find(|(other, _)| *other == key) {
                Some((_, part)) => part.extend(moved),
                None => keyed.push((key, moved.collect())),
            }
        }
    }
    parts.extend(keyed.into_iter().map(|(_, part)| part));
    parts
}

fn mean_square(corpus: &AxisDataset<'_>, left: &[Vec<f64>]) -> f64 {
    let (sums, samples) = corpus.by_fold(|run, k| left[run][k].powi(2));
    sums.iter().sum::<f64>() / samples.iter().sum::<usize>().max(1) as f64
}
