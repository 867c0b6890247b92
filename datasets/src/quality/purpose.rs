//! What a log is wanted for.

use crate::Severity;

/// What a log is wanted for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// To learn a machine from.
    Training,
    /// To measure tracking and contour error of the run.
    Measuring,
}

impl Purpose {
    /// `Refuse` for training, for measuring only `Warn`.
    pub(super) fn grave(self) -> Severity {
        match self {
            Self::Training => Severity::Refuse,
            Self::Measuring => Severity::Warn,
        }
    }
}
