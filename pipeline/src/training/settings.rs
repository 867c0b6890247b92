//! Settings of a training.

use training::Recipe;

/// Settings of a training.
#[derive(Debug, Clone, PartialEq)]
pub struct TrainSettings {
    /// Recipe of the predictors.
    pub recipe: Recipe,
    /// Share of the samples that is held out, as whole runs, 0…1.
    pub held_out: f64,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Folder for checkpoints of networks; `None` writes none.
    pub checkpoints: Option<std::path::PathBuf>,
}

impl TrainSettings {
    /// Default settings for a recipe: one fifth of the samples is held out.
    #[must_use]
    pub fn of(recipe: Recipe, seed: u64) -> Self {
        Self { recipe, held_out: 0.2, seed, checkpoints: None }
    }
}
