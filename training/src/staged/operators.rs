//! The hysteresis stage: stop operators on the expected position of the linear law.

use models::staged::{FeatureSet, LagBasis, MotionFactor, Pass, Scales};

use nalgebra::{DMatrix, Dyn, SVD};

use super::dataset::AxisDataset;
use super::gram::{FoldErrors, FoldGrams, Penalty};
use super::linear::{Candidate, LinearLaw, group};
use super::recipe::StagedRecipe;
use crate::TrainingError;

/// Number of operators and the form of their columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bank {
    /// A few, less the direction of motion, so that only `v`, 1 and `sign v` act at steady speed.
    Anchored,
    /// All, on every knot.
    Full,
    /// All, with terms of slow motion and of direction.
    Shaped,
}

impl Bank {
    /// Name in the report.
    pub fn name(self) -> &'static str {
        match self {
            Self::Anchored => "operators-anchored",
            Self::Full => "operators",
            Self::Shaped => "operators-shaped",
        }
    }
}

/// Columns of the linear law followed by those of the operators.
pub fn operator_features(law: &LinearLaw, bank: Bank, dataset: &AxisDataset<'_>, recipe: &StagedRecipe) -> FeatureSet {
    let knots = &law.knots;
    let mut groups = law.features.groups.clone();
    match bank {
        Bank::Anchored => {
            let stops: Vec<MotionFactor> = recipe.few_stops.iter().map(|&i| MotionFactor::StopLessSign(i)).collect();
            groups.push(group(LagBasis::now(), &[MotionFactor::Sign]));
            groups.push(group(LagBasis::hats(knots), &stops));
        }
        Bank::Full | Bank::Shaped => {
            let stops: Vec<MotionFactor> = (0..recipe.stop_half_widths.len()).map(MotionFactor::Stop).collect();
            groups.push(group(LagBasis::hats(knots), &stops));
        }
    }
    if bank == Bank::Shaped {
        let slow = (0..recipe.slow_speeds.len()).map(|q| MotionFactor::SlowStop(recipe.slow_stop, q));
        let shaped: Vec<MotionFactor> = slow.chain(recipe.shape_stops.iter().map(|&i| MotionFactor::StopMagnitude(i))).collect();
        groups.push(group(LagBasis::hats(&every(knots, 2)), &shaped));
    }
    FeatureSet { scales: scales(dataset, recipe), groups }
}

/// Half-widths and speeds of the operators on this axis.
pub fn scales(dataset: &AxisDataset<'_>, recipe: &StagedRecipe) -> Scales {
    let scaled = |list: &[f64]| list.iter().map(|x| x * dataset.unit).collect();
    let (low, high) = dataset.travel();
    Scales {
        stop_half_widths: scaled(&recipe.stop_half_widths),
        slow_speeds: scaled(&recipe.slow_speeds),
        slow_by_expected: true,
        drag_speeds: Vec::new(),
        centre: f64::midpoint(low, high),
        half_travel: 0.5 * (high - low),
        lines: Vec::new(),
        friction_map: None,
    }
}

/// Every `step`-th knot, counted from the latest; the earliest is always included.
pub fn every(knots: &[isize], step: usize) -> Vec<isize> {
    let mut kept: Vec<isize> = knots.iter().rev().step_by(step).copied().collect();
    kept.extend(knots.first());
    kept.sort_unstable();
    kept.dedup();
    kept
}

/// Iterations after which a decomposition is given up: there is no other bound on them.
const SVD_ITERATIONS: usize = 10_000;

/// Singular values and right singular vectors; `None` where they are not found.
pub fn right_singular(table: DMatrix<f64>) -> Option<SVD<f64, Dyn, Dyn>> {
    table.try_svd(false, true, 5.0 * f64::EPSILON, SVD_ITERATIONS)
}

/// RMS below which a column counts as hardly excited: columns get the additional penalty of a
/// column of this RMS.
const HARDLY_EXCITED: f64 = 0.1;

/// Penalties of the linear law's columns, and `ridge` on all columns after them.
///
/// With a ridge on columns of unit RMS only, a column that the log hardly excites (slow motion in a
/// log of fast motions) would get a large weight and spoil the prediction where the motion does
/// excite it.
pub fn penalties(
    law: &LinearLaw,
    noise: f64,
    dataset: &AxisDataset<'_>,
    features: &FeatureSet,
    ridge: f64,
    recipe: &StagedRecipe,
) -> Vec<Penalty> {
    let mut penalties = law.penalties(noise, recipe);
    let prior = ridge * dataset.fitted() as f64 * HARDLY_EXCITED * HARDLY_EXCITED;
    let mut column = 0;
    for group in &features.groups {
        for regressor in &group.channels {
            for _ in 0..group.basis.len() {
                if column >= penalties.len() {
                    let prior = if regressor.motion == MotionFactor::VelocityStep { 0.0 } else { prior };
                    penalties.push(Penalty { ridge, prior });
                }
                column += 1;
            }
        }
    }
    penalties
}

/// A fitted pass with its normal equations.
#[derive(Debug, Clone)]
pub struct FittedPass {
    /// The pass.
    pub pass: Pass,
    /// Its normal equations.
    pub grams: FoldGrams,
    /// Penalty of each column.
    pub penalties: Vec<Penalty>,
}

impl FittedPass {
    /// The same equations solved with other penalties.
    pub fn with_penalties(mut self, penalties: Vec<Penalty>) -> Result<Self, TrainingError> {
        self.pass.weights = self.grams.total().solve(&penalties).ok_or(TrainingError::Singular("operators"))?;
        self.penalties = penalties;
        Ok(self)
    }

    /// Cross-validated squared errors on each fold.
    pub fn cross_validate(&self) -> Result<FoldErrors, TrainingError> {
        self.grams.cross_validate(&self.penalties).ok_or(TrainingError::Singular("operators"))
    }

    /// The candidate that consists of `before` and this pass.
    pub fn candidate(self, name: &'static str, free: bool, before: &[Pass]) -> Result<Candidate, TrainingError> {
        let singular = TrainingError::Singular(name);
        let errors = self.grams.cross_validate(&self.penalties);
        let carried = self.grams.carry_over(&self.penalties);
        let (Some(errors), Some(carried)) = (errors, carried) else {
            return Err(singular);
        };
        Ok(Candidate { name, passes: before.iter().cloned().chain([self.pass]).collect(), errors, carried: Some(carried), free })
    }
}

/// One fit on the given expected positions.
pub fn fit_pass(
    dataset: &AxisDataset<'_>,
    features: &FeatureSet,
    expected: &[Vec<f64>],
    penalties: Vec<Penalty>,
) -> Result<FittedPass, TrainingError> {
    let signals = dataset.signals(features, expected);
    let grams = dataset.grams(features, &signals, &[], dataset.errors());
    let weights = grams.total().solve(&penalties).ok_or(TrainingError::Singular("operators"))?;
    let pass = Pass { features: features.clone(), weights };
    Ok(FittedPass { pass, grams, penalties })
}

/// The ridge of the non-linear columns that held-out blocks prefer, and its mean square error.
pub fn best_ridge(
    fitted: &FittedPass,
    law: &LinearLaw,
    noise: f64,
    dataset: &AxisDataset<'_>,
    recipe: &StagedRecipe,
) -> Option<(f64, f64)> {
    let tried: Vec<(f64, f64)> = recipe
        .ridges
        .iter()
        .filter_map(|&ridge| {
            let penalties = penalties(law, noise, dataset, &fitted.pass.features, ridge, recipe);
            let errors = fitted.grams.cross_validate(&penalties)?;
            Some((ridge, errors.mean_square()))
        })
        .collect();
    let least = tried.iter().map(|(_, error)| *error).fold(f64::INFINITY, f64::min);
    // Among ridges with about the same error the strongest extrapolates best.
    tried.into_iter().filter(|(_, error)| *error <= least * (1.0 + recipe.ridge_slack)).max_by(|a, b| a.0.total_cmp(&b.0))
}
