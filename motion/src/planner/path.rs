//! The tool path that is planned: pieces of curves, one after the other.

use rayon::prelude::*;

use super::corner::{self, Rounding};
use super::piece::Piece;

/// A tool path: every piece starts where the one before it ends.
#[derive(Debug, Clone, Default)]
pub struct ToolPath {
    pieces: Vec<Piece>,
}

/// Pieces between two rests.
pub(super) struct Run {
    /// Index of the path's piece that `pieces` begins with; blends count to the piece before and after the corner by half.
    pub first_index: Vec<usize>,
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

    /// The stretches between rests, corners within them rounded.
    pub(super) fn stretches(&self, rounding: &Rounding) -> Vec<Run> {
        let stops = |pair: &[Piece]| pair[0].stops() || !corner::can_pass(&pair[0], &pair[1], rounding.tolerance_mm(&pair[0]));
        let stops: Vec<bool> = self.pieces.par_windows(2).with_min_len(corner::SHARE).map(stops).collect();
        let mut runs = Vec::new();
        let mut first = 0;
        for index in 0..self.pieces.len() {
            if stops.get(index).copied().unwrap_or(true) {
                let (pieces, first_index) = corner::round(&self.pieces[first..=index], first, rounding);
                runs.push(Run { first_index, pieces, dwell_s: self.pieces[index].dwell_s });
                first = index + 1;
            }
        }
        runs
    }
}
