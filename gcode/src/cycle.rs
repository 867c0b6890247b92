//! Canned cycles: recognised and followed, not expanded.

use crate::dialect::Dialect;
use crate::modal::ReturnLevel;

/// One execution of a canned cycle: G73, G74, G76, G81 to G89.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cycle {
    /// The code, 81 for G81.
    pub code: u16,
    /// Bottom along the tool axis, mm, where known.
    pub bottom_mm: Option<f64>,
    /// R level along the tool axis, mm, where known.
    pub retract_mm: Option<f64>,
    /// How often it runs (L in LinuxCNC, K in Fanuc).
    pub repeats: u32,
}

/// The modal part of a run of cycles: later blocks repeat it at other places.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CycleState {
    pub code: u16,
    pub initial_mm: Option<f64>,
    pub retract_mm: Option<f64>,
    pub bottom_mm: Option<f64>,
}

impl CycleState {
    /// Where the tool axis stands after an execution.
    pub fn end_level(&self, level: ReturnLevel, dialect: Dialect) -> Option<f64> {
        match (level, dialect) {
            (ReturnLevel::Retract, _) => self.retract_mm,
            (ReturnLevel::Initial, Dialect::Fanuc) => self.initial_mm,
            (ReturnLevel::Initial, Dialect::LinuxCnc) => Some(self.initial_mm?.max(self.retract_mm?)),
        }
    }
}
