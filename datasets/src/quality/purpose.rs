//! Purpose of a log.

use crate::Severity;

/// Purpose of a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// Training of a model.
    Training,
    /// Measurement of the run's tracking and contour error.
    Measuring,
}

impl Purpose {
    /// `Refuse` for training, `Warn` for measuring.
    pub(super) fn grave(self) -> Severity {
        match self {
            Self::Training => Severity::Refuse,
            Self::Measuring => Severity::Warn,
        }
    }
}
