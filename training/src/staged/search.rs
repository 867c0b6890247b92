//! The search for position harmonics: the strongest peak that held-out blocks confirm, then the
//! next one on the new residual.

use models::staged::{FeatureGroup, FeatureSet, Pass, Signals};

use super::dataset::AxisDataset;
use super::gram::{FoldErrors, FoldGrams, Penalty};
use super::harmonics::{Harmonic, HarmonicBasis};
use super::recipe::StagedRecipe;
use super::spectrum::{Residuals, peaks};

/// Inputs of a search.
#[derive(Debug)]
pub struct Search<'a> {
    /// The runs.
    pub dataset: &'a AxisDataset<'a>,
    /// The columns to which harmonics are added.
    pub base: &'a FeatureSet,
    /// Columns of a harmonic.
    pub basis: &'a HarmonicBasis,
    /// Expected positions of the runs.
    pub expected: &'a [Vec<f64>],
    /// Ridge on the columns of the harmonics.
    pub ridge: f64,
    /// The settings.
    pub recipe: &'a StagedRecipe,
}

impl Search<'_> {
    /// Searches for up to `count` harmonics in `left` (residual of each run), in addition to those
    /// `known`.
    ///
    /// A peak becomes a harmonic if its columns, fitted to the residual of all other folds, lower
    /// the error of the held-out fold. Of the possible effects the simplest that no richer one
    /// beats is taken.
    pub fn run(&self, mut left: Vec<Vec<f64>>, known: &[Harmonic], count: usize) -> Vec<Harmonic> {
        let Self { dataset, recipe, .. } = self;
        let (low, high) = dataset.travel();
        let signals = dataset.signals(self.base, self.expected);
        let mut found: Vec<Harmonic> = Vec::new();
        while found.len() < count {
            let taken: Vec<f64> = known.iter().chain(&found).map(|harmonic| harmonic.frequency).collect();
            let along = along_axis(dataset, &signals, &left, recipe);
            let candidates = peaks(&along, high - low, dataset.unit, &taken, &recipe.harmonics);
            let confirmed = candidates.iter().take(recipe.harmonics.tried).find_map(|&frequency| self.confirm(&left, frequency));
            let Some((harmonic, pass)) = confirmed else {
                break;
            };
            for (left, part) in left.iter_mut().zip(dataset.predictions(&pass, self.expected)) {
                for (left, part) in left.iter_mut().zip(part) {
                    *left -= part;
                }
            }
            found.push(harmonic);
        }
        found
    }

    /// The harmonic at `frequency` with its effects and weights; `None` if held-out folds do not
    /// confirm it.
    fn confirm(&self, left: &[Vec<f64>], frequency: f64) -> Option<(Harmonic, Pass)> {
        let harmonic = |friction, force, gain| Harmonic { frequency, friction, force, gain };
        let full = harmonic(true, true, frequency > self.basis.fine_above);
        let bare = FeatureSet { scales: self.base.scales.clone(), groups: Vec::new() };
        let features = self.basis.features(&bare, &[full]);
        let signals = self.dataset.signals(&features, self.expected);
        let grams = self.dataset.grams(&features, &signals, &[], left);
        let sizes: Vec<usize> = features.groups.iter().map(FeatureGroup::columns).collect();
        let mut best: Option<(FoldErrors, Harmonic, FoldGrams)> = None;
        let without = grams.select(&[]).cross_validate(&[])?;
        for part in [harmonic(false, true, false), harmonic(true, false, false), harmonic(true, true, false), full] {
            let selected = grams.select(&columns_of(&part, &sizes));
            let Some(errors) = selected.cross_validate(&self.penalties(&selected)) else {
                continue;
            };
            let rival = best.as_ref().map_or(&without, |(errors, ..)| errors);
            let harmonics = &self.recipe.harmonics;
            if errors.beats(rival, harmonics.least_gain, harmonics.standard_errors) {
                best = Some((errors, part, selected));
            }
        }
        let (_, part, selected) = best?;
        let weights = selected.total().solve(&self.penalties(&selected))?;
        let features = self.basis.features(&bare, &[part]);
        Some((part, Pass { features, weights }))
    }

    fn penalties(&self, grams: &FoldGrams) -> Vec<Penalty> {
        vec![Penalty::ridge(self.ridge); grams.total().columns()]
    }
}

/// The columns of a harmonic for some of its effects, given the group sizes of all of them.
fn columns_of(harmonic: &Harmonic, sizes: &[usize]) -> Vec<usize> {
    let mut start = 0;
    let mut columns = Vec::new();
    for (size, wanted) in sizes.iter().zip([harmonic.friction, harmonic.force, harmonic.gain]) {
        if wanted {
            columns.extend(start..start + size);
        }
        start += size;
    }
    columns
}

/// The residual where the axis moves fast enough for position harmonics to be visible.
fn along_axis(dataset: &AxisDataset<'_>, signals: &[Signals], left: &[Vec<f64>], recipe: &StagedRecipe) -> Residuals {
    let slowest = recipe.harmonics.slowest * dataset.unit;
    let mut out = Residuals::default();
    for (run, k) in dataset.rows() {
        let padded = k + signals[run].pad();
        if signals[run].velocity()[padded].abs() > slowest {
            out.position.push(signals[run].position()[padded]);
            out.residual.push(left[run][k]);
            out.sign.push(signals[run].sign()[padded]);
        }
    }
    out
}
