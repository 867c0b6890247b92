//! The search for position lines: the strongest peak that held-out blocks confirm, then the next, on what is left.

use models::staged::{FeatureGroup, FeatureSet, Pass, Signals};

use super::corpus::AxisDataset;
use super::gram::{FoldErrors, FoldGrams, Penalty};
use super::lines::{Residuals, peaks};
use super::recipe::StagedRecipe;
use super::waves::{Line, WaveBasis};

/// What a search works on.
#[derive(Debug)]
pub struct Search<'a> {
    /// The runs.
    pub corpus: &'a AxisDataset<'a>,
    /// The columns to which lines are added.
    pub base: &'a FeatureSet,
    /// How lines become columns.
    pub basis: &'a WaveBasis,
    /// Expected positions of the runs.
    pub expected: &'a [Vec<f64>],
    /// Ridge on the lines' columns.
    pub ridge: f64,
    /// The settings.
    pub recipe: &'a StagedRecipe,
}

impl Search<'_> {
    /// Looks for up to `count` lines in `left` (what the model so far leaves of each run), besides those `known`.
    ///
    /// A peak becomes a line if its columns, fitted to what is left of all other folds, lower the error of a held-out one; of the ways
    /// in which a line may act the simplest that is not beaten is taken.
    pub fn run(&self, mut left: Vec<Vec<f64>>, known: &[Line], count: usize) -> Vec<Line> {
        let Self { corpus, recipe, .. } = self;
        let (low, high) = corpus.travel();
        let signals = corpus.signals(self.base, self.expected);
        let mut found: Vec<Line> = Vec::new();
        while found.len() < count {
            let taken: Vec<f64> = known.iter().chain(&found).map(|line| line.frequency).collect();
            let along = along_axis(corpus, &signals, &left, recipe);
            let candidates = peaks(&along, high - low, corpus.unit, &taken, &recipe.lines);
            let confirmed = candidates.iter().take(recipe.lines.tried).find_map(|&frequency| self.confirm(&left, frequency));
            let Some((line, pass)) = confirmed else {
                break;
            };
            for (left, part) in left.iter_mut().zip(corpus.predictions(&pass, self.expected)) {
                for (left, part) in left.iter_mut().zip(part) {
                    *left -= part;
                }
            }
            found.push(line);
        }
        found
    }

    /// The line at `frequency`, as it acts, with its weights; `None` where held-out folds do not confirm it.
    fn confirm(&self, left: &[Vec<f64>], frequency: f64) -> Option<(Line, Pass)> {
        let line = |friction, force, gain| Line { frequency, friction, force, gain };
        let full = line(true, true, frequency > self.basis.fine_above);
        let bare = FeatureSet { scales: self.base.scales.clone(), groups: Vec::new() };
        let features = self.basis.features(&bare, &[full]);
        let signals = self.corpus.signals(&features, self.expected);
        let grams = self.corpus.grams(&features, &signals, &[], left);
        let sizes: Vec<usize> = features.groups.iter().map(FeatureGroup::columns).collect();
        let mut best: Option<(FoldErrors, Line, FoldGrams)> = None;
        let without = grams.select(&[]).cross_validate(&[])?;
        for part in [line(false, true, false), line(true, false, false), line(true, true, false), full] {
            let selected = grams.select(&columns_of(&part, &sizes));
            let Some(errors) = selected.cross_validate(&self.penalties(&selected)) else {
                continue;
            };
            let rival = best.as_ref().map_or(&without, |(errors, ..)| errors);
            let lines = &self.recipe.lines;
            if errors.beats(rival, lines.least_gain, lines.standard_errors) {
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

/// The columns of a line that acts in some of its ways, where the groups of all of them have the given sizes.
fn columns_of(line: &Line, sizes: &[usize]) -> Vec<usize> {
    let mut start = 0;
    let mut columns = Vec::new();
    for (size, wanted) in sizes.iter().zip([line.friction, line.force, line.gain]) {
        if wanted {
            columns.extend(start..start + size);
        }
        start += size;
    }
    columns
}

/// What is left over, where the axis moves fast enough for waves along it to show.
fn along_axis(corpus: &AxisDataset<'_>, signals: &[Signals], left: &[Vec<f64>], recipe: &StagedRecipe) -> Residuals {
    let slowest = recipe.lines.slowest * corpus.unit;
    let mut out = Residuals::default();
    for (run, k) in corpus.rows() {
        let padded = k + signals[run].pad();
        if signals[run].velocity()[padded].abs() > slowest {
            out.position.push(signals[run].position()[padded]);
            out.residual.push(left[run][k]);
            out.sign.push(signals[run].sign()[padded]);
        }
    }
    out
}
