//! What is asked of a training.

use training::Recipe;

/// Settings of a training.
#[derive(Debug, Clone, PartialEq)]
pub struct TrainSettings {
    /// How axes are predicted.
    pub recipe: Recipe,
    /// Share of the samples that is held out, as whole runs.
    pub held_out: f64,
    /// Seed of everything random.
    pub seed: u64,
    /// Folder for the networks' checkpoints.
    pub checkpoints: Option<std::path::PathBuf>,
}

impl TrainSettings {
    /// The usual settings for a recipe.
    #[must_use]
    pub fn of(recipe: Recipe, seed: u64) -> Self {
        Self { recipe, held_out: 0.2, seed, checkpoints: None }
    }
}
