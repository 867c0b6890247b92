//! The fit: candidates from a pure delay to position harmonics, each kept only if it lowers the
//! error on held-out blocks.

use models::staged::{ServoBase, StagedPredictor};

use super::backlash::with_backlash;
use super::dataset::AxisDataset;
use super::friction_map::with_friction_map;
use super::gram::FoldErrors;
use super::harmonics::{Harmonic, HarmonicBasis, leading_filters};
use super::linear::{Candidate, LinearLaw, anchored, pure_delays, velocity_acceleration_jerk};
use super::operators::{Bank, FittedPass, best_ridge, fit_pass, operator_features, penalties};
use super::recipe::StagedRecipe;
use super::refine::refined_frequencies;
use super::report::{StageReport, StagedReport};
use super::search::Search;
use crate::{AxisRun, TrainingError};

/// Number of operator passes: the first on the position of the linear law, the last on that of the
/// operators.
const OPERATOR_PASSES: usize = 2;

/// Fits a staged predictor to runs of one axis.
///
/// # Errors
/// When the runs are unusable (lengths, periods, too few samples, no motion), or no linear law can be fitted.
pub fn fit(runs: &[AxisRun], recipe: &StagedRecipe) -> Result<(StagedPredictor, StagedReport), TrainingError> {
    fit_on(runs, None, recipe)
}

/// As [`fit`], to what a servo model leaves of the tracking error.
///
/// # Errors
/// As [`fit`].
pub fn fit_on(
    runs: &[AxisRun],
    servo: Option<&ServoBase>,
    recipe: &StagedRecipe,
) -> Result<(StagedPredictor, StagedReport), TrainingError> {
    recipe.map.check()?;
    let dataset = AxisDataset::new(runs, servo, recipe)?;
    let (candidates, ridge) = candidates(&dataset, recipe)?;
    let (predictor, report) = assemble(&dataset, candidates, ridge, recipe)?;
    Ok((predictor.on_servo(servo.copied())?, report))
}

/// All candidates, simplest first, and the ridge of the non-linear columns.
fn candidates(dataset: &AxisDataset<'_>, recipe: &StagedRecipe) -> Result<(Vec<Candidate>, Option<f64>), TrainingError> {
    let bases = dataset.bases();
    let simple = velocity_acceleration_jerk(dataset, &bases, recipe)?;
    if recipe.stop_half_widths.is_empty() {
        return Ok((linear_candidates(dataset, &bases, simple, recipe)?, None));
    }
    // The memory is chosen with the operators in place: without them friction hides the gain of a
    // longer one.
    let mut best: Option<(Candidate, LinearLaw, Candidate, f64)> = None;
    for &memory_s in &recipe.memory_s {
        let (linear, law) = anchored(dataset, &bases, recipe, &simple, memory_s)?;
        let (few, ridge) = with_operators(dataset, &bases, &linear, &law, Bank::Anchored, recipe)?;
        let better = best.as_ref().is_none_or(|(_, _, rival, _)| few.errors.beats(&rival.errors, recipe.least_gain, 1.0));
        if better {
            best = Some((linear, law, few, ridge));
        }
    }
    let (linear, law, few, ridge) = best.ok_or_else(|| TrainingError::Unusable("the recipe has no memory to try".into()))?;
    let mut candidates = Vec::from(pure_delays(dataset)?);
    candidates.extend([simple, linear.clone(), few.clone()]);
    let mut base = (few, ridge);
    for bank in [Bank::Full, Bank::Shaped] {
        let (candidate, ridge) = with_operators(dataset, &bases, &linear, &law, bank, recipe)?;
        candidates.push(candidate.clone());
        if pays(&candidate, &base.0, recipe) {
            base = (candidate, ridge);
        }
    }
    if let Some((candidate, ridge)) = with_backlash(dataset, &bases, &linear, &law, &base.0, recipe)? {
        candidates.push(candidate.clone());
        if pays(&candidate, &base.0, recipe) {
            base = (candidate, ridge);
        }
    }
    let (mut base, ridge) = base;
    if let Some(candidate) = with_harmonics(dataset, &law, &base, ridge, recipe)? {
        candidates.push(candidate.clone());
        if pays(&candidate, &base, recipe) {
            base = candidate;
        }
    }
    // If all motions are alike, a map can fit any effect: it must also gain at speeds outside the
    // fit.
    let gains_elsewhere = |candidate: &Candidate| match (&candidate.carried, &base.carried) {
        (Some(mine), Some(theirs)) => mine.beats(theirs, recipe.map.least_gain, 0.0),
        _ => false,
    };
    candidates.extend(with_friction_map(dataset, &law, &base, ridge, recipe)?.filter(gains_elsewhere));
    Ok((candidates, Some(ridge)))
}

/// The candidates without friction.
fn linear_candidates(
    dataset: &AxisDataset<'_>,
    bases: &[Vec<f64>],
    simple: Candidate,
    recipe: &StagedRecipe,
) -> Result<Vec<Candidate>, TrainingError> {
    let mut candidates = Vec::from(pure_delays(dataset)?);
    let anchored = recipe.memory_s.iter().map(|&memory_s| Ok(anchored(dataset, bases, recipe, &simple, memory_s)?.0));
    let anchored = anchored.collect::<Result<Vec<_>, TrainingError>>()?;
    candidates.push(simple);
    candidates.extend(anchored);
    Ok(candidates)
}

/// Whether a richer candidate replaces a simpler one: it is better on held-out runs and no worse at
/// speeds outside the fit, or as good on held-out runs and far better at those speeds. The freest
/// columns must also hold at those speeds on their own.
fn pays(richer: &Candidate, simpler: &Candidate, recipe: &StagedRecipe) -> bool {
    let (mine, theirs) = (richer.errors.mean_square(), simpler.errors.mean_square());
    let carry = match (&richer.carried, &simpler.carried) {
        (Some(richer), Some(simpler)) => richer.mean_square() / simpler.mean_square(),
        (None, Some(_)) => f64::INFINITY,
        (_, None) => 1.0,
    };
    let trusted =
        !richer.free || richer.carried.as_ref().is_some_and(|carried| carried.mean_square() <= recipe.carry_ratio * mine);
    let better = richer.errors.beats(&simpler.errors, recipe.least_gain, recipe.standard_errors);
    let as_good = mine <= theirs * (1.0 + recipe.least_gain);
    trusted && ((better && carry <= 1.0 + recipe.carry_loss) || (as_good && carry < recipe.carry_gain))
}

/// Adds one bank of operators to the linear law, with the ridge that held-out blocks prefer.
fn with_operators(
    dataset: &AxisDataset<'_>,
    bases: &[Vec<f64>],
    linear: &Candidate,
    law: &LinearLaw,
    bank: Bank,
    recipe: &StagedRecipe,
) -> Result<(Candidate, f64), TrainingError> {
    let features = operator_features(law, bank, dataset, recipe);
    let mut passes = linear.passes.clone();
    let mut expected = dataset.expected_after(&passes[0], bases);
    let guess = linear.errors.mean_square();
    let start = penalties(law, guess, dataset, &features, recipe.ridges[0], recipe);
    let trial = fit_pass(dataset, &features, &expected, start)?;
    let (ridge, noise) = best_ridge(&trial, law, guess, dataset, recipe).ok_or(TrainingError::Singular(bank.name()))?;
    let penalties = penalties(law, noise, dataset, &features, ridge, recipe);
    let mut fitted = fit_pass(dataset, &features, &expected, penalties.clone())?;
    for _ in 1..OPERATOR_PASSES {
        expected = dataset.expected_after(&fitted.pass, &expected);
        passes.push(fitted.pass);
        fitted = fit_pass(dataset, &features, &expected, penalties.clone())?;
    }
    Ok((fitted.candidate(bank.name(), bank == Bank::Shaped, &passes)?, ridge))
}

/// Adds position harmonics to the operators: search, refit, search again, then refine the
/// frequencies. `None` if no harmonic is found.
fn with_harmonics(
    dataset: &AxisDataset<'_>,
    law: &LinearLaw,
    base: &Candidate,
    ridge: f64,
    recipe: &StagedRecipe,
) -> Result<Option<Candidate>, TrainingError> {
    let Some(operators) = base.passes.last() else {
        return Ok(None);
    };
    let bare = operators.features.clone();
    let Some(filters) = leading_filters(operators, recipe.harmonics.filters) else {
        return Ok(None);
    };
    let basis = HarmonicBasis {
        filters,
        knots: law.knots.clone(),
        stops: recipe.shape_stops.clone(),
        fine_above: recipe.harmonics.fine_above / dataset.unit,
    };
    let noise = base.errors.mean_square();
    let expected = dataset.expected_through(&base.passes);
    let search = Search { dataset, base: &bare, basis: &basis, expected: &expected, ridge, recipe };
    let fit = |harmonics: &[Harmonic]| {
        let features = basis.features(&bare, harmonics);
        let penalties = penalties(law, noise, dataset, &features, ridge, recipe);
        fit_pass(dataset, &features, &expected, penalties)
    };
    let mut known: Vec<Harmonic> = Vec::new();
    let mut fitted: Option<FittedPass> = None;
    for _ in 0..recipe.harmonics.rounds {
        let pass = fitted.as_ref().map_or(operators, |fitted| &fitted.pass);
        let left = dataset.left_by(pass, &expected);
        let room = recipe.harmonics.at_most.saturating_sub(known.len());
        let found = search.run(left, &known, recipe.harmonics.per_round.min(room));
        if found.is_empty() {
            break;
        }
        known.extend(found);
        let mut current = fit(&known)?;
        for _ in 0..recipe.harmonics.refinements {
            let Some(moved) = refined_frequencies(dataset, &current.pass, &expected, &current.penalties, recipe) else {
                break;
            };
            for (harmonic, frequency) in known.iter_mut().zip(moved) {
                harmonic.frequency = frequency;
            }
            current = fit(&known)?;
        }
        fitted = Some(current);
    }
    fitted.map(|fitted| fitted.candidate("lines", true, &base.passes)).transpose()
}

/// Takes the simplest candidate that no richer one beats.
fn assemble(
    dataset: &AxisDataset<'_>,
    candidates: Vec<Candidate>,
    ridge: Option<f64>,
    recipe: &StagedRecipe,
) -> Result<(StagedPredictor, StagedReport), TrainingError> {
    let mut chosen: Option<&Candidate> = None;
    let mut stages = Vec::new();
    for candidate in &candidates {
        let accepted = chosen.is_none_or(|simpler| pays(candidate, simpler, recipe));
        if accepted {
            chosen = Some(candidate);
        }
        stages.push(StageReport {
            name: candidate.name.into(),
            columns: candidate.passes.last().map_or(0, |pass| pass.weights.len()),
            held_out_rms: candidate.errors.rms(),
            other_speeds_rms: candidate.carried.as_ref().map(FoldErrors::rms),
            accepted,
        });
    }
    let chosen = chosen.ok_or_else(|| TrainingError::Unusable("no candidate".into()))?;
    let last = chosen.passes.last();
    let window = candidates
        .iter()
        .find(|candidate| candidate.name == "linear")
        .and_then(|linear| linear.passes.first())
        .and_then(|pass| pass.features.groups.last())
        .map_or((0, 0), |group| group.basis.span());
    let report = StagedReport {
        stages,
        chosen: chosen.name.into(),
        window_s: (-window.0 as f64 * dataset.period_s(), window.1 as f64 * dataset.period_s()),
        ridge: ridge.filter(|_| chosen.passes.len() > 1),
        lines: last.map_or_else(Vec::new, |pass| pass.features.scales.lines.clone()),
        columns: last.map_or(0, |pass| pass.weights.len()),
        samples: dataset.samples(),
    };
    let predictor = StagedPredictor::new(dataset.period_s(), chosen.passes.clone())?;
    Ok((predictor, report))
}
