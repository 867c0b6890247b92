//! Which columns of a table make a log.

use motion::Axis;

/// A column of a table, and what its values are multiplied by to become s, mm or rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Source {
    /// Index of the column.
    pub column: usize,
    /// Factor to s, mm or rad.
    pub scale: f64,
}

/// The two columns of an axis.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisColumns {
    /// The axis.
    pub axis: Axis,
    /// Commanded positions.
    pub reference: Source,
    /// Reported positions.
    pub actual: Source,
}

/// Which columns of a table make a log.
#[derive(Debug, Clone, PartialEq)]
pub struct ColumnMap {
    /// Time stamps, where there are any.
    pub time: Option<Source>,
    /// The axes, in the order of their first column.
    pub axes: Vec<AxisColumns>,
    /// Names of the columns that are not used.
    pub unused: Vec<String>,
}
