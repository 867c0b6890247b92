//! The methods that are compared.

/// A row of the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Method {
    /// The desired path as reference.
    Uncompensated,
    /// Model-based ILC on the linear law of the model alone: what inverting the servo's linear response gives.
    LinearInverse,
    /// Paper D's law on the model's prediction.
    OneShot,
    /// Model-based ILC on the noise-free machine itself, then one run: what a perfect model would give.
    PerfectModel,
    /// Model-based ILC, then one run.
    FirstRun,
    /// The same after one more run: half of what the first run's log shows is taken off (`precomp refine --run 2`).
    Refined,
    /// A law that learns on the machine, after its learning runs.
    Ilc(Ilc),
    /// The lowest RMS and the lowest MAX over all [`Ilc`] laws, figure by figure.
    BestIlc,
    /// Run-to-run repeatability: the expected error of a perfect compensation.
    Floor,
}

/// A law that learns on the machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Ilc {
    /// The contour error, at a constant gain (Papers A and B).
    Spatial,
    /// The contour error with gain 1/j in run j.
    SpatialDecreasing,
    /// Every axis's tracking error in time, at a constant gain.
    Tracking,
    /// The same with gain 1/j.
    TrackingDecreasing,
    /// Norm-optimal ILC of every axis (Paper E, `a = 0`).
    NormOptimal,
    /// Norm-optimal ILC of the contour error alone (Paper E, `a = 1`).
    CrossCoupled,
}

impl Method {
    /// Name in tables and JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Uncompensated => "uncompensated",
            Self::LinearInverse => "linear-inverse",
            Self::OneShot => "one-shot",
            Self::PerfectModel => "perfect-model",
            Self::FirstRun => "first-run",
            Self::Refined => "first-run-refined",
            Self::Ilc(law) => law.name(),
            Self::BestIlc => "best-ilc",
            Self::Floor => "floor",
        }
    }
}

impl Ilc {
    /// Every law, in the order of the table.
    pub const ALL: [Self; 6] =
        [Self::Spatial, Self::SpatialDecreasing, Self::Tracking, Self::TrackingDecreasing, Self::NormOptimal, Self::CrossCoupled];

    /// Name in tables and JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Spatial => "spatial-ilc",
            Self::SpatialDecreasing => "spatial-ilc-decreasing",
            Self::Tracking => "tracking-ilc",
            Self::TrackingDecreasing => "tracking-ilc-decreasing",
            Self::NormOptimal => "norm-optimal-ilc",
            Self::CrossCoupled => "cross-coupled-ilc",
        }
    }

    /// Whether it learns the contour error by foot points.
    #[must_use]
    pub fn is_spatial(self) -> bool {
        matches!(self, Self::Spatial | Self::SpatialDecreasing)
    }

    /// Whether its gain is 1/j in run j.
    #[must_use]
    pub fn is_decreasing(self) -> bool {
        matches!(self, Self::SpatialDecreasing | Self::TrackingDecreasing)
    }

    /// Whether it needs impulse responses of the machine.
    #[must_use]
    pub fn is_norm_optimal(self) -> bool {
        matches!(self, Self::NormOptimal | Self::CrossCoupled)
    }
}
