//! The stage of saturated viscous friction and backlash.
//!
//! Friction acts on the motor. Backlash lies between the motor and the measured table. Both run on
//! the expected motor position: the reference less the predicted error without the contribution of
//! the backlash. On the table position a stop operator would not move while the motor crosses the
//! backlash, and the standstill position of the table could not be identified.

use models::staged::{FeatureSet, LagBasis, MotionFactor, Pass};

use super::dataset::AxisDataset;
use super::linear::{Candidate, LinearLaw, group};
use super::operators::{FittedPass, best_ridge, fit_pass, penalties, scales};
use super::recipe::StagedRecipe;
use crate::TrainingError;

/// Fits on the linear law's position until the half-width is settled.
const ITERATIONS: usize = 3;
/// Stop criterion: ratio of the mean square of the first viscous pass to that of the operators.
const HOPELESS: f64 = 4.0;

/// Adds saturated viscous friction and backlash to the linear law, with the ridge that held-out
/// blocks prefer. `None` if the recipe excludes them, or if the first viscous pass is far worse
/// than `rival`.
///
/// The first pass models friction by the direction of motion only and identifies the half-width of
/// the backlash. The contribution of the backlash is its half-width times a stop operator of this
/// half-width, so that the fitted weight is the next half-width. Further passes add viscous
/// friction on the resulting motor position while the held-out error falls.
pub fn with_backlash(
    dataset: &AxisDataset<'_>,
    bases: &[Vec<f64>],
    linear: &Candidate,
    law: &LinearLaw,
    rival: &Candidate,
    recipe: &StagedRecipe,
) -> Result<Option<(Candidate, f64)>, TrainingError> {
    let (Some(first), Some(&weak)) = (linear.passes.first(), recipe.ridges.first()) else {
        return Ok(None);
    };
    let least = recipe.least_half_width(dataset.unit);
    let fit = |viscous: bool, half_width: Option<f64>, expected: &[Vec<f64>], noise: f64| {
        let features = features(law, viscous, half_width, dataset, recipe);
        let penalties = penalties(law, noise, dataset, &features, weak, recipe);
        fit_pass(dataset, &features, expected, penalties)
    };
    let mut noise = linear.errors.mean_square();
    let mut expected = dataset.expected_after(first, bases);
    let mut half_width = Some(recipe.backlash_half_width * dataset.unit);
    let mut passes = linear.passes.clone();
    let mut best: Option<FittedPass> = None;
    for index in 0..=recipe.backlash_passes {
        let iterations = if index == 0 { ITERATIONS } else { 1 };
        let mut fitted = fit(index > 0, half_width, &expected, noise)?;
        for _ in 1..iterations {
            half_width = backlash_in(&fitted.pass).filter(|width| *width > least);
            fitted = fit(index > 0, half_width, &expected, noise)?;
        }
        half_width = backlash_in(&fitted.pass).filter(|width| *width > least);
        let errors = fitted.cross_validate()?;
        if index > 1 && errors.mean_square() >= noise {
            break;
        }
        noise = errors.mean_square();
        if index == 1 && noise > HOPELESS * rival.errors.mean_square() {
            return Ok(None);
        }
        expected = dataset.expected_after(&fitted.pass, &expected);
        passes.extend(best.replace(fitted).map(|fitted| fitted.pass));
    }
    let Some(fitted) = best.filter(|_| recipe.backlash_passes > 0) else {
        return Ok(None);
    };
    let name = if backlash_in(&fitted.pass).is_some() { "drag-and-play" } else { "drag" };
    let (ridge, noise) = best_ridge(&fitted, law, noise, dataset, recipe).ok_or(TrainingError::Singular(name))?;
    let penalties = penalties(law, noise, dataset, &fitted.pass.features, ridge, recipe);
    Ok(Some((fitted.with_penalties(penalties)?.candidate(name, false, &passes)?, ridge)))
}

/// Columns of the linear law, then of Coulomb friction (direction of motion), of viscous friction,
/// and of backlash.
fn features(
    law: &LinearLaw,
    viscous: bool,
    half_width: Option<f64>,
    dataset: &AxisDataset<'_>,
    recipe: &StagedRecipe,
) -> FeatureSet {
    let mut scales = scales(dataset, recipe);
    let mut friction = vec![MotionFactor::Sign];
    if viscous {
        scales.drag_speeds = recipe.viscous_speeds.iter().map(|speed| speed * dataset.unit).collect();
        friction.extend((0..recipe.viscous_speeds.len()).map(MotionFactor::SaturatedViscous));
    }
    let mut groups = law.features.groups.clone();
    groups.push(group(LagBasis::hats(&law.knots), &friction));
    if let Some(half_width) = half_width {
        groups.push(group(LagBasis::now(), &[MotionFactor::Backlash(scales.stop_half_widths.len())]));
        scales.stop_half_widths.push(half_width);
    }
    FeatureSet { scales, groups }
}

/// Half-width of the backlash found by a pass: its weight.
fn backlash_in(pass: &Pass) -> Option<f64> {
    let backlash =
        pass.features.groups.last()?.channels.iter().any(|regressor| matches!(regressor.motion, MotionFactor::Backlash(_)));
    pass.weights.last().copied().filter(|_| backlash)
}
