//! Errors of curves, trajectories and plans.

use thiserror::Error;

/// Errors of this crate.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MotionError {
    /// The sampling period is not a positive finite number of seconds.
    #[error("the sampling period is {0} s; it must be positive and finite")]
    BadPeriod(f64),
    /// The columns of a trajectory differ in length, or their number differs from the number of
    /// axes.
    #[error("{axes} axes but columns of lengths {lengths:?}; every axis needs one column and all columns the same length")]
    Ragged {
        /// Number of axes.
        axes: usize,
        /// Length of each column.
        lengths: Vec<usize>,
    },
    /// Two axes have the same name.
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
    /// Two trajectories that have to match differ.
    #[error("the trajectories do not match: {0}")]
    Mismatch(String),
    /// A limit, tolerance or other setting is out of range.
    #[error("{name} is {value}; {remedy}")]
    BadSetting {
        /// Name of the setting, with its unit.
        name: &'static str,
        /// The value given.
        value: f64,
        /// The requirement.
        remedy: &'static str,
    },
    /// Points, weights or knots that do not define a curve.
    #[error("the curve is not defined: {0}")]
    BadCurve(String),
    /// Axes and joints that do not form a machine.
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
        /// Path length from the start of the path, mm.
        position_mm: f64,
        /// Reason.
        what: String,
    },
    /// The planner could not satisfy every limit.
    #[error("no feed holds the limits at path position {position_mm:.3} mm: {what}")]
    Infeasible {
        /// Index of the piece of the tool path.
        piece: usize,
        /// Path length from the start of the path, mm.
        position_mm: f64,
        /// The limit.
        what: String,
    },
    /// A path with too long a duration for the memory.
    #[error(
        "the path takes more than {hours:.0} h up to here; a plan holds {most} samples: check the feed and its unit, or cut the path"
    )]
    TooLong {
        /// Index of the piece of the tool path that holds the last sample.
        piece: usize,
        /// Path length from the start of the path, mm.
        position_mm: f64,
        /// Duration of that many samples, h.
        hours: f64,
        /// Maximum samples of a plan.
        most: usize,
    },
}

impl MotionError {
    /// A pose that cannot be reached, with its position on the path.
    pub(crate) fn on_piece(self, piece: usize, position_mm: f64) -> Self {
        match self {
            Self::Unreachable(what) => Self::UnreachableOnPath { piece, position_mm, what },
            other => other,
        }
    }

    /// The same error for a segment that begins `offset_mm` after the start of the path.
    pub(crate) fn further(mut self, offset_mm: f64) -> Self {
        if let Self::UnreachableOnPath { position_mm, .. }
        | Self::Infeasible { position_mm, .. }
        | Self::TooLong { position_mm, .. } = &mut self
        {
            *position_mm += offset_mm;
        }
        self
    }

    /// Index of the piece of the tool path, if the error has one.
    #[must_use]
    pub fn piece(&self) -> Option<usize> {
        match self {
            Self::UnreachableOnPath { piece, .. } | Self::Infeasible { piece, .. } | Self::TooLong { piece, .. } => Some(*piece),
            _ => None,
        }
    }
}
