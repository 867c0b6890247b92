//! The stage of drag and play: friction as a function of the motor's velocity, and a table that follows the motor across backlash.
//!
//! Friction acts on the motor, and play lies between the motor and the table that is measured. Both therefore run on the motor's expected
//! position: the reference less the predicted error, without what play contributes to it. On the table's position a stop operator would
//! stand still while the motor crosses the play, and never learn where the table comes to rest.

use models::staged::{FeatureSet, LagBasis, MotionFactor, Pass};

use super::corpus::AxisDataset;
use super::linear::{Candidate, LinearLaw, group};
use super::operators::{FittedPass, best_ridge, fit_pass, penalties, scales};
use super::recipe::StagedRecipe;
use crate::TrainingError;

/// Fits on the linear law's position until the half-width is taken for settled.
const ROUNDS: usize = 3;
/// Mean square of the first pass of drag over that of the operators above which no further one is tried.
const HOPELESS: f64 = 4.0;

/// Adds drag and play to the linear law, and the ridge that held-out blocks prefer for them; `None` where the recipe wants none, or
/// the first pass of drag is so far behind `rival` that more would not make up for it.
///
/// First the direction of motion stands for friction, which alone tells the half-width of the play: the contribution of the play is
/// its half-width times a stop operator of just this half-width, so that the weight found is the next half-width to try. Then drag,
/// on the motor's position that comes out of it, as long as held-out blocks gain.
pub fn with_drag_and_play(
    corpus: &AxisDataset<'_>,
    references: &[Vec<f64>],
    linear: &Candidate,
    law: &LinearLaw,
    rival: &Candidate,
    recipe: &StagedRecipe,
) -> Result<Option<(Candidate, f64)>, TrainingError> {
    let (Some(first), Some(&weak)) = (linear.passes.first(), recipe.ridges.first()) else {
        return Ok(None);
    };
    let least = recipe.least_half_width(corpus.unit);
    let fit = |drag: bool, half_width: Option<f64>, expected: &[Vec<f64>], noise: f64| {
        let features = features(law, drag, half_width, corpus, recipe);
        let penalties = penalties(law, noise, corpus, &features, weak, recipe);
        fit_pass(corpus, &features, expected, penalties)
    };
    let mut noise = linear.errors.mean_square();
    let mut expected = corpus.expected_after(first, references);
    let mut half_width = Some(recipe.play_half_width * corpus.unit);
    let mut passes = linear.passes.clone();
    let mut best: Option<FittedPass> = None;
    for index in 0..=recipe.play_passes {
        let rounds = if index == 0 { ROUNDS } else { 1 };
        let mut fitted = fit(index > 0, half_width, &expected, noise)?;
        for _ in 1..rounds {
            half_width = play_in(&fitted.pass).filter(|width| *width > least);
            fitted = fit(index > 0, half_width, &expected, noise)?;
        }
        half_width = play_in(&fitted.pass).filter(|width| *width > least);
        let errors = fitted.cross_validate()?;
        if index > 1 && errors.mean_square() >= noise {
            break;
        }
        noise = errors.mean_square();
        if index == 1 && noise > HOPELESS * rival.errors.mean_square() {
            return Ok(None);
        }
        expected = corpus.expected_after(&fitted.pass, &expected);
        passes.extend(best.replace(fitted).map(|fitted| fitted.pass));
    }
    let Some(fitted) = best.filter(|_| recipe.play_passes > 0) else {
        return Ok(None);
    };
    let name = if play_in(&fitted.pass).is_some() { "drag-and-play" } else { "drag" };
    let (ridge, noise) = best_ridge(&fitted, law, noise, corpus, recipe).ok_or(TrainingError::Singular(name))?;
    let penalties = penalties(law, noise, corpus, &fitted.pass.features, ridge, recipe);
    Ok(Some((fitted.with_penalties(penalties)?.candidate(name, false, &passes)?, ridge)))
}

/// Columns of the linear law, then of friction by direction of motion, of drag, and of play.
fn features(law: &LinearLaw, drag: bool, half_width: Option<f64>, corpus: &AxisDataset<'_>, recipe: &StagedRecipe) -> FeatureSet {
    let mut scales = scales(corpus, recipe);
    let mut friction = vec![MotionFactor::Sign];
    if drag {
        scales.drag_speeds = recipe.drag_speeds.iter().map(|speed| speed * corpus.unit).collect();
        friction.extend((0..recipe.drag_speeds.len()).map(MotionFactor::SaturatedViscous));
    }
    let mut groups = law.features.groups.clone();
    groups.push(group(LagBasis::hats(&law.knots), &friction));
    if let Some(half_width) = half_width {
        groups.push(group(LagBasis::now(), &[MotionFactor::Backlash(scales.stop_half_widths.len())]));
        scales.stop_half_widths.push(half_width);
    }
    FeatureSet { scales, groups }
}

/// The half-width of the play that a pass found: its weight.
fn play_in(pass: &Pass) -> Option<f64> {
    let play = pass.features.groups.last()?.channels.iter().any(|channel| matches!(channel.motion, MotionFactor::Backlash(_)));
    pass.weights.last().copied().filter(|_| play)
}
