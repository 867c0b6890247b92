//! Moves that are not compensated, and the reasons.

use std::collections::BTreeMap;
use std::ops::Range;

use serde::Serialize;

use gcode::{Diagnostic, Fixed, Move, MoveKind, Severity, Shiftable};

use super::faults::render;
use super::{Part, turns_at_feed};
use crate::error::{Error, Result};

/// Moves that are left alone for one reason. As JSON it is their number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(into = "usize")]
pub struct FixedMoves {
    /// Number of moves.
    pub moves: usize,
    /// Line of the first one, from 1.
    pub first_line: usize,
}

impl FixedMoves {
    /// Those of two parts of a program.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        Self { moves: self.moves + other.moves, first_line: self.first_line.min(other.first_line) }
    }
}

impl From<FixedMoves> for usize {
    fn from(fixed: FixedMoves) -> Self {
        fixed.moves
    }
}

impl Part {
    /// Reasons why cutting moves cannot be compensated, each with its moves. Rapids and dwells are not
    /// counted.
    #[must_use]
    pub fn fixed_moves(&self) -> BTreeMap<&'static str, FixedMoves> {
        self.fixed_moves_of(&(0..self.toolpath.moves.len()))
    }

    /// The same among the moves with these indices.
    pub(crate) fn fixed_moves_of(&self, moves: &Range<usize>) -> BTreeMap<&'static str, FixedMoves> {
        let mut found: BTreeMap<&'static str, FixedMoves> = BTreeMap::new();
        let fixed = self.toolpath.moves[moves.clone()].iter().filter(|of| !self.is_shiftable(of));
        let reason = |of: &Move| match (of.shiftable, of.kind) {
            (Shiftable::Yes, MoveKind::Arc(_)) if self.stops_exactly(of) => {
                Some("arcs at whose points the control would stop (G9, G61, G64 P0)")
            }
            (Shiftable::Yes, _) if self.has_time_of_radius(of) => {
                Some("arcs under G93, whose F the control may count by their radius or by their length")
            }
            (Shiftable::Yes, _) if turns_at_feed(of) => {
                Some("whose feed is that of rotary axes alone (--format g93 states times instead)")
            }
            _ => why_fixed(of),
        };
        for (why, of) in fixed.filter_map(|of| Some((reason(of)?, of))) {
            let this = FixedMoves { moves: 1, first_line: of.block as usize + 1 };
            found.entry(why).and_modify(|known| *known = known.with(this)).or_insert(this);
        }
        found
    }

    /// Refuses a program with feed moves that are left alone because it does not say enough: codes that are not understood, values of run
    /// time, blocks that may be skipped, starts that are not stated. Names the first move of each reason.
    ///
    /// # Errors
    /// [`Error::Program`] with the lines.
    pub fn check_understood(&self) -> Result<()> {
        let mut diagnostics: Vec<Diagnostic> = Vec::new();
        for reason in [Fixed::NotUnderstood, Fixed::RunTime, Fixed::OptionalBlock, Fixed::UnknownStart] {
            let mut moves = self.toolpath.moves.iter().filter(|step| step.is_feed() && step.shiftable == Shiftable::No(reason));
            let Some(first) = moves.next() else { continue };
            let block = first.block as usize;
            let span = self.program.block_words(block).first().map_or(self.program.blocks()[block].span, |word| word.span);
            let (count, why) = (1 + moves.count(), why_fixed(first).unwrap_or_default());
            let what = format!("{count} moves {why} are left as they are, this one first");
            diagnostics.push(Diagnostic::new(&self.program, Severity::Error, span, what));
        }
        if let Some(last) = diagnostics.pop() {
            diagnostics.push(last.with_help("state what is missing, or leave --strict out: these moves will not be changed"));
            let text = render(&diagnostics, &self.program, &self.name);
            return Err(Error::Program { diagnostics, text });
        }
        Ok(())
    }

    /// Share of the length of all feed moves that cannot be compensated, 0…1. Pure rotations have no length.
    #[must_use]
    pub fn fixed_share(&self) -> f64 {
        self.share(self.feed_length_mm(|step| !self.is_shiftable(step)))
    }

    /// Share of a length in that of all feed moves, 0…1.
    #[must_use]
    pub fn share(&self, length_mm: f64) -> f64 {
        let all_mm = self.feed_length_mm(|_| true);
        if length_mm > 0.0 && all_mm > 0.0 { (length_mm / all_mm).min(1.0) } else { 0.0 }
    }

    fn feed_length_mm(&self, counts: impl Fn(&Move) -> bool) -> f64 {
        self.toolpath.moves.iter().filter(|of| of.is_feed() && counts(of)).filter_map(Move::length_mm).sum()
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
            Fixed::Adjoining => {
                "whose ends the control needs for what it computes itself (,R ,C RND CHF APPR DEP CIP CT CC, poles and polar coordinates)"
            }
            Fixed::Threading => "that follow the spindle or a probe",
            Fixed::NotUnderstood => "not understood, or after codes whose effect on path or frame is not known",
            Fixed::RunTime => "that depend on what only the running program knows",
            Fixed::Rapid | Fixed::Cycle | Fixed::Home | Fixed::Probing | Fixed::Dwell => "of another kind",
        },
    })
}
