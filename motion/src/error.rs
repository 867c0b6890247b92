//! What can go wrong with curves, trajectories and plans.

use thiserror::Error;

/// Errors of this crate.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MotionError {
    /// The sampling period is not a positive finite number of seconds.
    #[error("the sampling period is {0} s; it must be positive and finite")]
    BadPeriod(f64),
    /// The columns of a trajectory differ in length or in number from its axes.
    #[error("{axes} axes but columns of lengths {lengths:?}; every axis needs one column and all columns the same length")]
    Ragged {
        /// Number of axes named.
        axes: usize,
        /// Length of each column given.
        lengths: Vec<usize>,
    },
    /// Two axes carry the same name.
    #[error("axis `{0}` is named twice")]
    DuplicateAxis(String),
    /// A value is NaN or infinite.
    #[error("axis `{axis}` has a value that is not finite at sample {sample}")]
    NotFinite {
        /// Name of the axis.
        axis: String,
        /// Index of the first such sample.
        sample: usize,
    },
    /// Two trajectories that have to match do not.
    #[error("the trajectories do not match: {0}")]
    Mismatch(String),
    /// A limit, tolerance or other setting is out of range.
    #[error("{name} is {value}; {remedy}")]
    BadSetting {
        /// Name of the setting, with its unit.
        name: &'static str,
        /// The value given.
        value: f64,
        /// What it has to be.
        remedy: &'static str,
    },
    /// A curve was given points, weights or knots that do not define it.
    #[error("the curve is not defined: {0}")]
    BadCurve(String),
    /// Axes and joints that do not make a machine.
    #[error("the kinematics is not defined: {0}")]
    BadKinematics(String),
    /// A pose that the axes cannot reach.
    #[error("the pose cannot be reached: {0}")]
    Unreachable(String),
    /// A pose on a path that the axes cannot reach.
    #[error("at path position {position_mm:.3} mm the pose cannot be reached: {what}")]
    UnreachableOnPath {
        /// Index of the piece of the tool path.
        piece: usize,
        /// Way from the start of the path, mm.
        position_mm: f64,
        /// Why.
        what: String,
    },
    /// The planner could not hold every limit.
    #[error("no feed holds the limits at path position {position_mm:.3} mm: {what}")]
    Infeasible {
        /// Index of the piece of the tool path.
        piece: usize,
        /// Way from the start of the path, mm.
        position_mm: f64,
        /// Which limit.
        what: String,
    },
    /// A path that takes so long that its plan would fill the memory.
    #[error(
        "the path takes more than {hours:.0} h up to here; a plan holds {most} samples: check the feed and its unit, or cut the path"
    )]
    TooLong {
        /// Index of the piece of the tool path on which the last sample lies.
        piece: usize,
        /// Way from the start of the path, mm.
        position_mm: f64,
        /// Time that as many samples take, h.
        hours: f64,
        /// Samples of a plan at most.
        most: usize,
    },
}

impl MotionError {
    /// A pose that cannot be reached, with its place on the path.
    pub(crate) fn on_piece(self, piece: usize, position_mm: f64) -> Self {
        match self {
            Self::Unreachable(what) => Self::UnreachableOnPath { piece, position_mm, what },
            other => other,
        }
    }

    /// The same fault of a stretch that begins `offset_mm` after the start of the path.
    pub(crate) fn further(mut self, offset_mm: f64) -> Self {
        if let Self::UnreachableOnPath { position_mm, .. }
        | Self::Infeasible { position_mm, .. }
        | Self::TooLong { position_mm, .. } = &mut self
        {
            *position_mm += offset_mm;
        }
        self
    }

    /// The piece of the tool path that the fault lies on, where it is one of a path.
    #[must_use]
    pub fn piece(&self) -> Option<usize> {
        match self {
            Self::UnreachableOnPath { piece, .. } | Self::Infeasible { piece, .. } | Self::TooLong { piece, .. } => Some(*piece),
            _ => None,
        }
    }
}
