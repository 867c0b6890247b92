//! Canned cycles. They are recognised and their end position is tracked. They are not expanded.

use crate::dialect::Dialect;
use crate::modal::ReturnLevel;

/// One execution of a canned cycle: G73, G74, G76, G81 to G89.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cycle {
    /// The code, 81 for G81.
    pub code: u16,
    /// Bottom along the tool axis, mm, if known.
    pub bottom_mm: Option<f64>,
    /// R level along the tool axis, mm, if known.
    pub retract_mm: Option<f64>,
    /// Number of repeats (L in LinuxCNC, K in Fanuc).
    pub repeats: u32,
}

/// Modal state of a series of cycles. Later blocks repeat the cycle at other positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CycleState {
    pub code: u16,
    pub initial_mm: Option<f64>,
    pub retract_mm: Option<f64>,
    pub bottom_mm: Option<f64>,
}

impl CycleState {
    /// Tool-axis position after one execution.
    pub fn end_level(&self, level: ReturnLevel, dialect: Dialect) -> Option<f64> {
        match (level, dialect) {
            (ReturnLevel::Retract, _) => self.retract_mm,
            (ReturnLevel::Initial, Dialect::Fanuc | Dialect::Sinumerik) => self.initial_mm,
            (ReturnLevel::Initial, Dialect::LinuxCnc) => Some(self.initial_mm?.max(self.retract_mm?)),
        }
    }
}
