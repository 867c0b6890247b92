//! Findings of a long log, of which every piece is checked on its own.

use std::collections::BTreeMap;

use super::Piece;
use crate::quality::{Purpose, assess};
use crate::{Check, Finding, Report};

/// Length of a piece from which on it is checked, s: a shorter one at the end of a log says nothing of its own.
const CHECKED_S: f64 = 5.0;

/// What the pieces of a log show.
#[derive(Debug, Default)]
pub struct PieceFindings {
    pieces: usize,
    /// First finding of every kind, by check, column and severity, with the number of pieces that show it.
    found: BTreeMap<(usize, String), (Finding, usize)>,
    kinds: Vec<(Check, Option<String>, String)>,
}

impl PieceFindings {
    /// Checks a piece of a log.
    pub fn add(&mut self, piece: &Piece, purpose: Purpose) {
        let period_s = piece.reference.period_s();
        let (first, own) = (piece.first, piece.own.clone());
        let Some(log) = piece.clone().into_log("").and_then(|log| log.part("", own.start, own.end).ok()) else { return };
        if self.pieces > 0 && log.reference.duration_s() < CHECKED_S {
            return;
        }
        self.pieces += 1;
        for mut finding in assess(&log, purpose).findings {
            if let Some(row) = &mut finding.place.row {
                *row += first + own.start;
                finding.place.time_s = Some((*row - 1) as f64 * period_s);
            }
            // Messages of one kind differ in their numbers.
            let words = finding.message.chars().filter(|c| c.is_alphabetic()).collect();
            let kind = (finding.check, finding.place.column.clone(), words);
            let index = self.kinds.iter().position(|known| *known == kind).unwrap_or_else(|| {
                self.kinds.push(kind);
                self.kinds.len() - 1
            });
            let column = finding.place.column.clone().unwrap_or_default();
            self.found.entry((index, column)).or_insert((finding, 0)).1 += 1;
        }
    }

    /// The findings. What speaks of single samples counts wherever it is found, what speaks of the run as a whole where half of the pieces
    /// show it.
    #[must_use]
    pub fn into_report(self) -> Report {
        let pieces = self.pieces;
        let counts = |(finding, times): &(Finding, usize)| match finding.check {
            Check::Motion => *times == pieces,
            Check::Rate | Check::Digits | Check::Pairing | Check::Units | Check::Runs => 2 * times >= pieces,
            Check::Timing | Check::Mended | Check::Copied | Check::Jumps | Check::Dropout | Check::Command => true,
        };
        let counted = |(mut finding, times): (Finding, usize)| {
            if times < pieces {
                finding.message += &format!(" (in {times} of {pieces} pieces of the log)");
            }
            finding
        };
        Report { findings: self.found.into_values().filter(counts).map(counted).collect() }
    }
}
