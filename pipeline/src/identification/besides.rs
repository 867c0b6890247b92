//! What a control may do besides shaping acceleration and passing corners.

use machine::MachineSpec;

use super::fidelity::Fidelity;
use super::observed::Observed;
use super::structure::{Besides, Structure};

/// Lines ahead, and times of a line in ms, from which a fit may start.
const LOOK_AHEADS: [u32; 8] = [2, 4, 8, 16, 32, 64, 128, 256];
const LINE_TIMES_MS: [f64; 6] = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0];
/// A start that changes the score by less says that no run reaches it.
const SEEN: f64 = 1e-6;

/// Something that a control may do besides.
#[derive(Debug, Clone, Copy)]
pub(super) enum Addition {
    OwnFilters,
    LineTime,
    LookAhead,
    Arcs,
}

impl Addition {
    pub const ALL: [Self; 4] = [Self::OwnFilters, Self::LineTime, Self::LookAhead, Self::Arcs];

    /// The structure with the addition; `None` if it has it already or cannot have it.
    pub fn to(self, structure: Structure) -> Option<Structure> {
        self.set(structure, true).filter(|with| with.is_possible())
    }

    /// The structure without the addition; `None` if it does not have it.
    pub fn from(self, structure: Structure) -> Option<Structure> {
        self.set(structure, false)
    }

    /// `None` if nothing changes.
    fn set(self, structure: Structure, on: bool) -> Option<Structure> {
        let besides = match self {
            Self::OwnFilters => Besides { own_filters: on, ..structure.besides },
            Self::LineTime => Besides { line_time: on, ..structure.besides },
            Self::LookAhead => Besides { look_ahead: on, ..structure.besides },
            Self::Arcs => Besides { arcs: on, ..structure.besides },
        };
        Some(Structure { besides, ..structure }).filter(|other| *other != structure)
    }

    /// The machine from which a fit starts, where `machine` is the one without the addition and `score` its score on the runs; `None` where the
    /// runs cannot show the addition.
    pub fn first(self, structure: Structure, machine: &MachineSpec, score: f64, runs: &[&Observed]) -> Option<MachineSpec> {
        let machine = structure.applied(machine);
        let mut control = machine.control?;
        let mut starts = Vec::new();
        match self {
            Self::OwnFilters | Self::Arcs => return Some(machine),
            Self::LineTime => starts.extend(LINE_TIMES_MS.map(|line_time_ms| {
                control.line_time_ms = line_time_ms;
                control
            })),
            Self::LookAhead => starts.extend(LOOK_AHEADS.map(|lines| {
                control.look_ahead_lines = Some(lines);
                control
            })),
        }
        let starts = starts.into_iter().map(|control| MachineSpec { control: Some(control), ..machine.clone() });
        let scored = starts.map(|start| (Fidelity::of(&start, runs).score(), start));
        let seen = scored.filter(|(of_start, _)| (of_start - score).abs() > SEEN);
        seen.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, start)| start)
    }
}
