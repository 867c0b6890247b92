//! What a column name means.

use super::unit::Unit;

/// Content of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    Time,
    Reference,
    Actual,
    /// A position whose name does not state whether it is commanded or actual.
    Position,
}

/// Meaning of a column name of which every word is known.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Meaning {
    pub role: Role,
    /// Lower-case axis name; empty for the time.
    pub axis: String,
    pub unit: Option<Unit>,
    /// Whether it is the second encoder of an axis, which is at the table.
    pub is_table: bool,
}
