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
    /// A pose that the axes cannot reach.
    #[error("the pose cannot be reached: {0}")]
    Unreachable(String),
    /// The planner could not hold every limit.
    #[error("no feed holds the limits at path position {position_mm:.3} mm: {what}")]
    Infeasible {
        /// Arc length from the start of the path, mm.
        position_mm: f64,
        /// Which limit.
        what: String,
    },
}
