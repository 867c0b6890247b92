//! Compared methods.

/// A compared method: a row of the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Method {
    /// The desired path as the reference.
    Uncompensated,
    /// Model-based ILC with only the linear stage of the model: inversion of the servo's linear response.
    LinearInverse,
    /// Paper D's law with the model's prediction.
    OneShot,
    /// Model-based ILC on the noise-free machine itself, then one run: the result with a perfect model.
    PerfectModel,
    /// Model-based ILC, then one run.
    FirstRun,
    /// The first run's reference after one refinement with half of the error in its log (`precomp refine --run 2`).
    Refined,
    /// An ILC law after its runs on the machine.
    Ilc(Ilc),
    /// Lowest RMS and lowest MAX over all [`Ilc`] laws, figure by figure.
    BestIlc,
    /// Run-to-run repeatability: the expected error of a perfect compensation.
    Floor,
}

/// An ILC law that learns on the machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Ilc {
    /// Contour error at a constant gain (Papers A and B).
    Spatial,
    /// Contour error with gain 1/j in run j.
    SpatialDecreasing,
    /// Tracking error of every axis at a constant gain.
    Tracking,
    /// Tracking error of every axis with gain 1/j in run j.
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

    /// Whether the law uses the contour error at foot points.
    #[must_use]
    pub fn is_spatial(self) -> bool {
        matches!(self, Self::Spatial | Self::SpatialDecreasing)
    }

    /// Whether the gain is 1/j in run j.
    #[must_use]
    pub fn is_decreasing(self) -> bool {
        matches!(self, Self::SpatialDecreasing | Self::TrackingDecreasing)
    }

    /// Whether the law needs impulse responses of the machine.
    #[must_use]
    pub fn is_norm_optimal(self) -> bool {
        matches!(self, Self::NormOptimal | Self::CrossCoupled)
    }
}
