//! Moves that are not compensated, and the reasons.

use std::collections::BTreeMap;

use gcode::{Fixed, Move, MoveKind, Shiftable};

use super::Part;

impl Part {
    /// Reasons why cutting moves cannot be compensated, each with its number of moves. Rapids and dwells are not
    /// counted.
    #[must_use]
    pub fn fixed_moves(&self) -> BTreeMap<&'static str, usize> {
        let mut counts = BTreeMap::new();
        let fixed = self.toolpath.moves.iter().filter(|of| !self.is_shiftable(of));
        let reason = |of: &Move| match (of.shiftable, of.kind) {
            (Shiftable::Yes, MoveKind::Arc(_)) if self.stops_exactly(of) => {
                Some("arcs at whose points the control would stop (G9, G61, G64 P0)")
            }
            _ => why_fixed(of),
        };
        for why in fixed.filter_map(reason) {
            *counts.entry(why).or_default() += 1;
        }
        counts
    }

    /// Share of the length of all feed moves that cannot be compensated, 0…1. Pure rotations have no length.
    #[must_use]
    pub fn fixed_share(&self) -> f64 {
        let length = |of: &Move| of.length_mm().unwrap_or(0.0);
        let feeds = || self.toolpath.moves.iter().filter(|of| of.is_feed());
        let (all, fixed) =
            (feeds().map(length).sum::<f64>(), feeds().filter(|of| !self.is_shiftable(of)).map(length).sum::<f64>());
        if all > 0.0 { (fixed / all).max(0.0) } else { 0.0 }
    }
}

/// Reason why a move is not compensated; `None` for a move that does not cut.
fn why_fixed(of: &Move) -> Option<&'static str> {
    Some(match (of.shiftable, of.kind) {
        (_, MoveKind::Rapid | MoveKind::Dwell { .. } | MoveKind::Home) => return None,
        (_, MoveKind::Cycle(_)) | (Shiftable::No(Fixed::Cycle), _) => "in canned cycles",
        (_, MoveKind::Thread | MoveKind::Probe) => "that follow the spindle or a probe",
        (Shiftable::Yes, _) => {
            "that turn axes, or are under tip control, whose effect on the tool the machine description does not state"
        }
        (Shiftable::No(fixed), _) => match fixed {
            Fixed::CutterCompensation => "under cutter compensation (G41, G42, RL, RR)",
            Fixed::MachineCoordinates => "in machine coordinates (G53, M91)",
            Fixed::ToolChange => "in blocks that change the tool or its offset",
            Fixed::UnknownStart => "that start where the program does not say",
            Fixed::OptionalBlock => "in blocks that a switch may skip (/)",
            Fixed::Unsplittable => {
                "in blocks that several lines cannot replace: words that act before and after the motion, calls, jumps"
            }
            Fixed::Adjoining => "whose ends the control needs for what it computes itself (RND, CHF, APPR, DEP, CT, CC)",
            Fixed::Threading => "that follow the spindle or a probe",
            Fixed::NotUnderstood => "after codes whose effect on path or frame is not known",
            Fixed::RunTime => "that depend on what only the running program knows",
            Fixed::Rapid | Fixed::Cycle | Fixed::Home | Fixed::Probing | Fixed::Dwell => "of another kind",
        },
    })
}
