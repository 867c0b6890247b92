//! The tool path to plan: a sequence of curve pieces.

use rayon::prelude::*;

use super::corner::{self, Rounding};
use super::piece::Piece;

/// A tool path: every piece starts at the end of the one before it.
#[derive(Debug, Clone, Default)]
pub struct ToolPath {
    pieces: Vec<Piece>,
}

/// Pieces between two stops.
pub(super) struct Run {
    /// Index in the path of every entry of `pieces`. Each half of a blend counts to its own piece.
    pub piece_indices: Vec<usize>,
    pub pieces: Vec<Piece>,
    pub dwell_s: f64,
}

impl From<Vec<Piece>> for ToolPath {
    fn from(pieces: Vec<Piece>) -> Self {
        Self { pieces }
    }
}

impl ToolPath {
    /// Appends a piece.
    pub fn push(&mut self, piece: Piece) {
        self.pieces.push(piece);
    }

    /// The pieces, in order.
    #[must_use]
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// The segments between stops, with rounded corners.
    pub(super) fn segments(&self, rounding: &Rounding) -> Vec<Run> {
        let stops = |pair: &[Piece]| pair[0].stops() || !corner::can_pass(&pair[0], &pair[1], rounding.tolerance_mm(&pair[0]));
        let stops: Vec<bool> = self.pieces.par_windows(2).with_min_len(corner::SHARE).map(stops).collect();
        let mut runs = Vec::new();
        let mut first = 0;
        for index in 0..self.pieces.len() {
            if stops.get(index).copied().unwrap_or(true) {
                // A control waits at the end of a program as at a dwell.
                let ends = index > 0 && index + 1 == self.pieces.len();
                let (pieces, piece_indices) = corner::round(&self.pieces[first..=index], first, ends, rounding);
                runs.push(Run { piece_indices, pieces, dwell_s: self.pieces[index].dwell_s });
                first = index + 1;
            }
        }
        runs
    }
}
