//! What a column name means.

use super::unit::Unit;

/// Content of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    Time,
    /// Time stamps of the commanded positions, of one axis or of all.
    ReferenceTime,
    /// Time stamps of the actual positions, of one axis or of all.
    ActualTime,
    Reference,
    Actual,
    /// A tracking error: command minus actual position.
    Error,
    /// A position whose name does not state whether it is commanded or actual.
    Position,
}

impl Role {
    pub fn is_time(self) -> bool {
        matches!(self, Self::Time | Self::ReferenceTime | Self::ActualTime)
    }
}

/// Meaning of a column name of which every word is known.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Meaning {
    pub role: Role,
    /// Lower-case axis name; empty for time stamps that are of no one axis.
    pub axis: String,
    pub unit: Option<Unit>,
    /// Whether it is the second encoder of an axis, which is at the table.
    pub is_table: bool,
}
