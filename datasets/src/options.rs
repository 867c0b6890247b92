//! Properties of a log that the caller or a side file states.

/// Interpretation of a file, in addition to its own content.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ReadOptions {
    /// Column mapping, as `t=time_s,x_ref=x_cmd_mm,x_act=x_act:um` (see [`ColumnMap::parse`](crate::ColumnMap::parse)).
    pub columns: Option<String>,
    /// Sampling period, s, for files without time stamps. Time stamps take precedence, unless nearly all of them stand still.
    pub period_s: Option<f64>,
}
