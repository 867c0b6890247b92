//! What a caller or a file beside a log states about it.

/// How a file is to be understood, where it does not speak for itself.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ReadOptions {
    /// Column mapping, as `t=time_s,x_ref=x_cmd_mm,x_act=x_act:um` (see [`ColumnMap::parse`](crate::ColumnMap::parse)).
    pub columns: Option<String>,
    /// Sampling period, s; for files without time stamps. Stamps, where there are any, go first.
    pub period_s: Option<f64>,
}
