//! Refining the lines' frequencies, jointly with the weights.

use models::staged::Pass;

use super::corpus::AxisDataset;
use super::gram::Penalty;
use super::recipe::StagedRecipe;
use super::waves::part_on_line;

/// Half the step of the central difference over a frequency, 1/unit.
const HALF_STEP: f64 = 1e-5;
/// Ridge of the columns that stand for the frequencies: only against a line that does nothing.
const FREQUENCY_RIDGE: f64 = 1e-8;

/// One Gauss-Newton step on weights and frequencies together; returns the frequencies moved, each by `largest_step` at most.
///
/// The prediction's derivatives with respect to the frequencies join the columns, so that the phase which the weights would absorb is
/// not taken for a shift of the frequency.
pub fn refined_lines(
    corpus: &AxisDataset<'_>,
    pass: &Pass,
    expected: &[Vec<f64>],
    penalties: &[Penalty],
    recipe: &StagedRecipe,
) -> Option<Vec<f64>> {
    let lines = &pass.features.scales.lines;
    let half_step = HALF_STEP / corpus.unit;
    let derivatives: Vec<Vec<Vec<f64>>> = (0..lines.len())
        .map(|line| {
            let part = part_on_line(pass, line);
            let moved = |by: f64| {
                let mut part = part.clone();
                part.features.scales.lines[line] += by;
                corpus.predictions(&part, expected)
            };
            let (up, down) = (moved(half_step), moved(-half_step));
            up.iter()
                .zip(&down)
                .map(|(up, down)| up.iter().zip(down).map(|(u, d)| (u - d) / (2.0 * half_step)).collect())
                .collect()
        })
        .collect();
    let signals = corpus.signals(&pass.features, expected);
    let grams = corpus.grams(&pass.features, &signals, &derivatives, corpus.errors());
    let penalties: Vec<Penalty> =
        penalties.iter().copied().chain(lines.iter().map(|_| Penalty::ridge(FREQUENCY_RIDGE))).collect();
    let solution = grams.total().solve(&penalties)?;
    let largest = recipe.lines.largest_step / corpus.unit;
    Some(
        lines.iter().zip(&solution[pass.features.columns()..]).map(|(line, step)| line + step.clamp(-largest, largest)).collect(),
    )
}
