//! Candidates for the written program.

use compensation::Iteration;

use crate::refit::RefitSettings;
use crate::statistics::Figures;

/// A run of the program with these points, and its cycle time.
pub(super) struct Candidate {
    pub(super) run: (Iteration, Figures),
    pub(super) cycle_s: f64,
    pub(super) written: RefitSettings,
}

/// What came of a search: the run of the least cost whose cycle is short enough, else the one with the shortest cycle.
pub(super) enum Tried {
    Short(Box<Candidate>),
    Long(Box<Candidate>),
}

impl Tried {
    /// Cost of the run, mm; infinite where its cycle is too long.
    pub(super) fn cost_mm(&self) -> f64 {
        match self {
            Self::Short(candidate) => candidate.run.0.measure,
            Self::Long(_) => f64::INFINITY,
        }
    }

    /// Cycle time, s.
    pub(super) fn cycle_s(&self) -> f64 {
        let (Self::Short(candidate) | Self::Long(candidate)) = self;
        candidate.cycle_s
    }

    /// Whether this one costs no more than `other`, or has a shorter cycle where both are too long.
    pub(super) fn is_better(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Long(own), Self::Long(other)) => own.cycle_s <= other.cycle_s,
            _ => self.cost_mm() <= other.cost_mm(),
        }
    }
}
