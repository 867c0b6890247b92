//! The settings of a network's training.

use models::FeatureSet;
use models::recurrent::Kind;
use serde::{Deserialize, Serialize};

use crate::TrainingError;

/// Kind of network.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum NetworkKind {
    /// Long short-term memory: Paper D's.
    Lstm,
    /// Gated recurrent units: Paper D's baseline.
    Gru,
    /// Feed-forward on features and past errors: Paper D's baseline.
    Narx,
}

impl NetworkKind {
    /// The recurrent cell, if it has any.
    #[must_use]
    pub fn cell(self) -> Option<Kind> {
        match self {
            Self::Lstm => Some(Kind::Lstm),
            Self::Gru => Some(Kind::Gru),
            Self::Narx => None,
        }
    }
}

/// How a network is trained. All times are seconds, so that a recipe holds at any sampling period.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NetworkRecipe {
    /// Kind of network.
    pub kind: NetworkKind,
    /// Feature set of the inputs.
    pub features: FeatureSet,
    /// Units of each hidden layer.
    pub hidden: usize,
    /// Hidden layers.
    pub layers: usize,
    /// Dropout: share of the features between layers.
    pub dropout: f64,
    /// Initial learning rate of Adam.
    pub learning_rate: f64,
    /// Factor on the learning rate …
    pub drop_factor: f64,
    /// … every so many epochs.
    pub drop_every: usize,
    /// Largest global norm of the gradients; larger ones are scaled down to it.
    pub clip_norm: f64,
    /// Windows per training step.
    pub batch: usize,
    /// Counted part of a window, s.
    pub window_s: f64,
    /// Warm-up before it, s: the state settles and errors do not count.
    pub warmup_s: f64,
    /// Maximum number of epochs.
    pub epochs: usize,
    /// Epochs between two validations on the held-out runs.
    pub validate_every: usize,
    /// Validations without a new least error after which training stops.
    pub patience: usize,
}

impl NetworkRecipe {
    /// Paper D, section V: 3 × 128 units, dropout 0.2, learning rate 0.01 dropped by 0.1 every 125 epochs, gradients to norm 1,
    /// mini-batch 128, at most 1000 epochs, validated every 10, patience 6. The paper does not print its windows.
    #[must_use]
    pub fn paper(kind: NetworkKind) -> Self {
        Self {
            kind,
            features: FeatureSet::Iii,
            hidden: 128,
            layers: 3,
            dropout: 0.2,
            learning_rate: 0.01,
            drop_factor: 0.1,
            drop_every: 125,
            clip_norm: 1.0,
            batch: 128,
            window_s: 0.2,
            warmup_s: 0.1,
            epochs: 1000,
            validate_every: 10,
            patience: 6,
        }
    }

    /// One layer of 64 units: three axes train in about a minute on two cores from 40 000 samples each, and predict unseen curves of
    /// the built-in machine within about 0.2-0.5 µm.
    #[must_use]
    pub fn quick(kind: NetworkKind) -> Self {
        Self {
            hidden: 64,
            layers: 1,
            dropout: 0.0,
            drop_factor: 0.3,
            drop_every: 40,
            batch: 16,
            epochs: 150,
            validate_every: 5,
            patience: 10,
            ..Self::paper(kind)
        }
    }

    /// A small LSTM for the residual of the staged predictor. No early stopping: the held-out blocks decide
    /// whether the network is kept.
    #[must_use]
    pub fn residual() -> Self {
        Self { hidden: 32, learning_rate: 0.003, epochs: 100, validate_every: 25, ..Self::quick(NetworkKind::Lstm) }
    }

    /// Learning rate of an epoch, the first one being 0.
    #[must_use]
    pub fn rate(&self, epoch: usize) -> f64 {
        let drops = epoch.checked_div(self.drop_every).unwrap_or(0);
        self.learning_rate * self.drop_factor.powi(i32::try_from(drops).unwrap_or(i32::MAX))
    }

    /// Whether the settings can be used.
    ///
    /// # Errors
    /// Says which one cannot.
    pub fn check(&self) -> Result<(), TrainingError> {
        let counts = [
            ("hidden", self.hidden),
            ("layers", self.layers),
            ("batch", self.batch),
            ("epochs", self.epochs),
            ("validate_every", self.validate_every),
            ("patience", self.patience),
        ];
        if let Some((name, _)) = counts.into_iter().find(|(_, count)| *count == 0) {
            return Err(TrainingError::Unusable(format!("the recipe's `{name}` is zero")));
        }
        let positive = |value: f64| value > 0.0 && value.is_finite();
        let numbers = [
            ("learning_rate", self.learning_rate, positive(self.learning_rate)),
            ("drop_factor", self.drop_factor, positive(self.drop_factor)),
            ("clip_norm", self.clip_norm, positive(self.clip_norm)),
            ("window_s", self.window_s, positive(self.window_s) && self.window_s <= 100.0),
            ("warmup_s", self.warmup_s, (0.0..=100.0).contains(&self.warmup_s)),
            ("dropout", self.dropout, (0.0..1.0).contains(&self.dropout)),
        ];
        match numbers.into_iter().find(|(_, _, usable)| !usable) {
            Some((name, value, _)) => Err(TrainingError::Unusable(format!("the recipe's `{name}` is {value}"))),
            None => Ok(()),
        }
    }
}
