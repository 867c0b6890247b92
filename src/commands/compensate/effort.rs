//! How much time the search may take.

use clap::ValueEnum;

/// How much time the search may take.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Effort {
    /// The fewest steps on the model and on the replanned program, as long as they save 3 % of the error expected on the machine
    Fast,
    /// Four times as many, as long as they save 1 %
    Normal,
    /// Eight times as many, as long as they save 0.2 %; a program whose corners need time is learned twice
    Best,
}

impl Effort {
    /// Whether a program is also learned within a larger limit of the cycle time.
    #[must_use]
    pub fn tries_larger_limit(self) -> bool {
        self == Self::Best
    }

    /// Updates on the model.
    #[must_use]
    pub fn updates(self) -> usize {
        match self {
            Self::Fast => 1,
            Self::Normal => 4,
            Self::Best => 8,
        }
    }

    /// Share of the expected error that a run of a program has to save to count.
    #[must_use]
    pub fn worth(self) -> f64 {
        match self {
            Self::Fast => 0.03,
            Self::Normal => 0.01,
            Self::Best => 0.002,
        }
    }
}
