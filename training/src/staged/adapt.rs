//! Adapts a predictor to another machine, or to a later state of the same machine, with a few
//! seconds of its log.

use models::staged::{FeatureSet, MotionFactor, Pass, Scales, ServoBase, StagedPredictor};

use super::dataset::AxisDataset;
use super::gram::Penalty;
use super::recipe::StagedRecipe;
use super::servo_fit::refitted;
use crate::{AxisRun, TrainingError};

/// Columns of the linear law's response that are corrected individually: sums over 1, 2, 3, 5 …
/// samples.
const RESPONSE_COLUMNS: [usize; 8] = [0, 1, 2, 4, 7, 12, 20, 32];
/// Expected relative deviation of a part of a pass on another machine.
const PART_SPREAD: f64 = 0.3;

/// Result of an adaptation.
#[derive(Debug, Clone, PartialEq)]
pub struct AdaptReport {
    /// Number of weights of the correction.
    pub columns: usize,
    /// Scored samples of the log.
    pub samples: usize,
    /// RMS prediction error on the log before the adaptation.
    pub before_rms: f64,
    /// RMS prediction error after it, cross-validated over folds of the log.
    pub held_out_rms: f64,
}

/// Fits a correction of about forty weights: a gain on the contribution of each operator, slow term
/// and harmonic, and new low-order terms of the linear law.
///
/// A servo model below the passes stays as it is, or gets new gains and a new friction where that is better. The passes are corrected in order, since each runs on the expected position of the previous one.
/// The predictor is returned unchanged if the correction does not lower the error on held-out parts
/// of the log.
///
/// # Errors
/// When the runs are unusable or sampled at another period.
pub fn adapt(
    predictor: &StagedPredictor,
    runs: &[AxisRun],
    recipe: &StagedRecipe,
) -> Result<(StagedPredictor, AdaptReport), TrainingError> {
    let (adapted, report) = adapt_on(predictor, predictor.servo().copied(), runs, recipe)?;
    let refitted = predictor.servo().and_then(|servo| refitted(servo, runs));
    let (adapted, report) = match refitted.map(|servo| adapt_on(predictor, Some(servo), runs, recipe)) {
        Some(Ok((other, other_report))) if other_report.held_out_rms < report.held_out_rms => {
            (other, AdaptReport { before_rms: report.before_rms, ..other_report })
        }
        _ => (adapted, report),
    };
    if report.held_out_rms >= report.before_rms {
        return Ok((predictor.clone(), report));
    }
    Ok((adapted, report))
}

/// The passes corrected on a servo model, or on the reference.
fn adapt_on(
    predictor: &StagedPredictor,
    servo: Option<ServoBase>,
    runs: &[AxisRun],
    recipe: &StagedRecipe,
) -> Result<(StagedPredictor, AdaptReport), TrainingError> {
    let dataset = AxisDataset::new(runs, servo.as_ref(), recipe)?;
    if (dataset.period_s() / predictor.period_s() - 1.0).abs() > 1e-6 {
        return Err(TrainingError::Unusable(format!(
            "the log's period is {} s, the model's {} s",
            dataset.period_s(),
            predictor.period_s()
        )));
    }
    let mut expected = dataset.bases();
    let mut old_expected = dataset.bases();
    let mut passes = Vec::new();
    let mut report = None;
    for pass in predictor.passes() {
        let (adapted, mut pass_report) = adapt_pass(&dataset, pass, &expected, recipe)?;
        pass_report.before_rms = mean_square(&dataset, &dataset.left_by(pass, &old_expected)).sqrt();
        old_expected = dataset.expected_after(pass, &old_expected);
        expected = dataset.expected_after(&adapted, &expected);
        passes.push(adapted);
        report = Some(pass_report);
    }
    let report = report.ok_or_else(|| TrainingError::Unusable("the model has no pass".into()))?;
    Ok((StagedPredictor::new(predictor.period_s(), passes)?.on_servo(servo)?, report))
}

/// One pass with scaled parts and corrected low-order terms.
fn adapt_pass(
    dataset: &AxisDataset<'_>,
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
            dataset.predictions(&Pass { features, weights }, expected)
        })
        .collect();
    let nothing = FeatureSet { scales: Scales::linear(), groups: Vec::new() };
    let left = dataset.left_by(pass, expected);
    let signals = dataset.signals(&nothing, expected);
    let grams = dataset.grams(&nothing, &signals, &contributions, &left);
    let singular = || TrainingError::Singular("adaptation");
    let ridge = vec![Penalty::ridge(recipe.linear_ridge); parts.len()];
    let floor = grams.cross_validate(&ridge).ok_or_else(singular)?.mean_square();
    let penalties: Vec<Penalty> = parts
        .iter()
        .map(|part| Penalty {
            ridge: recipe.linear_ridge,
            // A scaled part has a prior at its present value. A single column has none.
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
    let report = AdaptReport { columns: parts.len(), samples: dataset.samples(), before_rms: 0.0, held_out_rms };
    Ok((adapted, report))
}

/// Columns that share one gain, each with its weight at a gain of one.
type Part = Vec<(usize, f64)>;

fn is_free(part: &Part) -> bool {
    part.len() == 1 && part.iter().all(|(_, weight)| *weight == 1.0)
}

/// Free columns of the linear law, and one part for each other regressor (cosine and sine of a
/// harmonic together).
fn parts(pass: &Pass) -> Vec<Part> {
    let mut parts: Vec<Part> = Vec::new();
    let mut keyed: Vec<((MotionFactor, Option<usize>), Part)> = Vec::new();
    let mut column = 0;
    for group in &pass.features.groups {
        let responses = group.basis.len();
        for regressor in &group.channels {
            let columns = column..column + responses;
            column += responses;
            let harmonic = regressor.harmonic();
            let linear = matches!(
                regressor.motion,
                MotionFactor::One | MotionFactor::Velocity | MotionFactor::VelocityStep | MotionFactor::Sign
            );
            if linear && harmonic.is_none() {
                let free = RESPONSE_COLUMNS.iter().filter(|&&i| i < responses);
                parts.extend(free.map(|i| vec![(columns.start + i, 1.0)]));
                continue;
            }
            // The terms of a harmonic share one gain for each kind, so that the correction has few
            // weights.
            let key = match harmonic {
                Some(_) if matches!(regressor.motion, MotionFactor::Stop(_)) => (MotionFactor::Stop(0), harmonic),
                Some(_) => (MotionFactor::One, harmonic),
                None => (regressor.motion, None),
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

fn mean_square(dataset: &AxisDataset<'_>, left: &[Vec<f64>]) -> f64 {
    let (sums, samples) = dataset.by_fold(|run, k| left[run][k].powi(2));
    sums.iter().sum::<f64>() / samples.iter().sum::<usize>().max(1) as f64
}
