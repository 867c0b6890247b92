//! Settings of a training.

use training::Recipe;

/// Settings of a training.
#[derive(Debug, Clone, PartialEq)]
pub struct TrainSettings {
    /// Recipe of the predictors.
    pub recipe: Recipe,
    /// Share of the samples that is held out, as whole runs, 0…1.
    pub held_out: f64,
    /// Largest number of samples to train on. Of longer logs, the stretches that show most of their motion are taken
    /// ([`datasets::stretches`]).
    pub most_samples: usize,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Folder for checkpoints of networks; `None` writes none.
    pub checkpoints: Option<std::path::PathBuf>,
}

/// Default of [`TrainSettings::most_samples`]. On 20 minutes of excitation of `ballscrew` at 500 Hz (606,186 samples), RMS of the x axis on
/// unseen lines | butterfly: 59,000 samples 0.339 | 0.361 µm, 119,000 0.252 | 0.206, 239,000 0.211 | 0.187 in half the time of all: 0.202 | 0.161.
pub const MOST_SAMPLES: usize = 240_000;

/// Default share of the samples that is held out.
pub const HELD_OUT: f64 = 0.2;

impl TrainSettings {
    /// Default settings for a recipe: one fifth of the samples is held out.
    #[must_use]
    pub fn of(recipe: Recipe, seed: u64) -> Self {
        Self { recipe, held_out: HELD_OUT, most_samples: MOST_SAMPLES, seed, checkpoints: None }
    }
}
