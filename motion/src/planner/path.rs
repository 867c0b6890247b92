//! The tool path that is planned: pieces of curves, one after the other.

use super::{Piece, corner};

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
    pub(super) fn stretches(&self, corner_tolerance_mm: f64) -> Vec<Run> {
        let mut runs = Vec::new();
        let mut first = 0;
        for index in 0..self.pieces.len() {
            let last = index + 1 == self.pieces.len();
            let stop = last
                || self.pieces[index].stops()
                || !corner::can_pass(&self.pieces[index], &self.pieces[index + 1], corner_tolerance_mm);
            if stop {
                let (pieces, first_index) = corner::round(&self.pieces[first..=index], first, corner_tolerance_mm);
                runs.push(Run { first_index, pieces, dwell_s: self.pieces[index].dwell_s });
                first = index + 1;
            }
        }
        runs
    }
}
