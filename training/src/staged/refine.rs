//! Refines the frequencies of the harmonics together with the weights.

use models::staged::Pass;

use super::dataset::AxisDataset;
use super::gram::Penalty;
use super::harmonics::part_on_harmonic;
use super::recipe::StagedRecipe;

/// Half the step of the central difference over a frequency, 1/unit.
const HALF_STEP: f64 = 1e-5;
/// Ridge of the frequency columns: it acts only on a harmonic without effect.
const FREQUENCY_RIDGE: f64 = 1e-8;

/// One Gauss-Newton step on weights and frequencies together. Returns the new frequencies, each
/// moved by `largest_step` at most.
///
/// The derivatives of the prediction by the frequencies join the columns, so that a phase shift
/// that the weights absorb does not count as a shift of the frequency.
pub fn refined_frequencies(
    dataset: &AxisDataset<'_>,
    pass: &Pass,
    expected: &[Vec<f64>],
    penalties: &[Penalty],
    recipe: &StagedRecipe,
) -> Option<Vec<f64>> {
    let harmonics = &pass.features.scales.lines;
    let half_step = HALF_STEP / dataset.unit;
    let derivatives: Vec<Vec<Vec<f64>>> = (0..harmonics.len())
        .map(|harmonic| {
            let part = part_on_harmonic(pass, harmonic);
            let moved = |by: f64| {
                let mut part = part.clone();
                part.features.scales.lines[harmonic] += by;
                dataset.predictions(&part, expected)
            };
            let (up, down) = (moved(half_step), moved(-half_step));
            up.iter()
                .zip(&down)
                .map(|(up, down)| up.iter().zip(down).map(|(u, d)| (u - d) / (2.0 * half_step)).collect())
                .collect()
        })
        .collect();
    let signals = dataset.signals(&pass.features, expected);
    let grams = dataset.grams(&pass.features, &signals, &derivatives, dataset.errors());
    let penalties: Vec<Penalty> =
        penalties.iter().copied().chain(harmonics.iter().map(|_| Penalty::ridge(FREQUENCY_RIDGE))).collect();
    let solution = grams.total().solve(&penalties)?;
    let largest = recipe.harmonics.largest_step / dataset.unit;
    Some(
        harmonics
            .iter()
            .zip(&solution[pass.features.columns()..])
            .map(|(harmonic, step)| harmonic + step.clamp(-largest, largest))
            .collect(),
    )
}
