//! The arithmetic of a recurrent layer on plain `f32` slices.
//!
//! Sequences are time-major: `[steps][batch][features]`, with the last index fastest. Internally a
//! row of gates has the four gates' vectors side by side for every vector of units: `i f g o` for
//! an LSTM, `n r z q` for a GRU, so that the gates of the input, and those of the hidden state, are
//! contiguous. One panel of a product thus contains all that a vector of cells needs, and the cells
//! are computed while the sums are in registers.

mod activation;
mod backward;
mod buffer;
mod cells;
mod forward;
mod level;
mod product;

#[cfg(test)]
mod check;

pub use backward::{AtInput, Ends, Pass, Work, backward};
pub use forward::{PackedLayer, Tape, forward};
pub use level::Level;

use std::ops::Range;

use super::Kind;

/// Sizes of a layer and of its sequence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shape {
    /// Time steps.
    pub steps: usize,
    /// Parallel sequences.
    pub batch: usize,
    /// Features of an input.
    pub input: usize,
    /// Features of the state.
    pub hidden: usize,
}

impl Shape {
    /// Number of rows of all steps.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.steps * self.batch
    }

    /// Number of values in one step's state.
    #[must_use]
    pub fn state(&self) -> usize {
        self.batch * self.hidden
    }
}

/// A layer's weights, with PyTorch's shapes and order of gates (`i f g o`; `r z n`).
#[derive(Debug, Clone, Copy)]
pub struct Weights<'a> {
    /// LSTM or GRU.
    pub kind: Kind,
    /// Input weights, `[gates·hidden][input]`.
    pub input: &'a [f32],
    /// Hidden weights, `[gates·hidden][hidden]`.
    pub hidden: &'a [f32],
    /// Biases, `4·hidden`. LSTM: `b_ih + b_hh`. GRU: `b_ih + b_hh` of `r` and `z`, `b_in`, `b_hn`.
    pub bias: &'a [f32],
}

impl Kind {
    /// Gates of a row that the input feeds.
    fn input_gates(self) -> Range<usize> {
        match self {
            Kind::Lstm => 0..4,
            Kind::Gru => 0..3,
        }
    }

    /// Gates of a row that the hidden state feeds.
    fn hidden_gates(self) -> Range<usize> {
        match self {
            Kind::Lstm => 0..4,
            Kind::Gru => 1..4,
        }
    }

    /// Position of a row's gates in PyTorch's order, in a weight matrix of those `fed` and in its
    /// gradient.
    fn positions(self, fed: &Range<usize>) -> impl Iterator<Item = (usize, usize)> {
        let positions = match self {
            Kind::Lstm => [0, 1, 2, 3],
            Kind::Gru => [2, 0, 1, 2],
        };
        fed.clone().map(move |gate| (gate, positions[gate]))
    }

    /// The weights of the gates that are `fed`, in the order of a row of gates; empty for the
    /// others.
    fn gate_weights(self, weights: &[f32], fed: Range<usize>) -> [&[f32]; 4] {
        let each = weights.len() / fed.len();
        let mut gates: [&[f32]; 4] = [&[]; 4];
        for (gate, position) in self.positions(&fed) {
            gates[gate] = &weights[position * each..][..each];
        }
        gates
    }

    /// Positions of the biases of each gate's vector of units, in a row of gates and in PyTorch's
    /// bias vector.
    fn bias_blocks(self, level: Level, hidden: usize) -> impl Iterator<Item = (Range<usize>, Range<usize>)> {
        let positions = match self {
            Kind::Lstm => [0, 1, 2, 3],
            Kind::Gru => [2, 0, 1, 3],
        };
        let lanes = level.lanes();
        (0..hidden).step_by(lanes).flat_map(move |unit| {
            let length = lanes.min(hidden - unit);
            positions.into_iter().enumerate().map(move |(gate, position)| {
                let (row, vector) = (4 * unit + gate * lanes, position * hidden + unit);
                (row..row + length, vector..vector + length)
            })
        })
    }
}
