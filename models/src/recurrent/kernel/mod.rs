//! The arithmetic of a recurrent layer on plain `f32` slices.
//!
//! Sequences are time-major: `[steps][batch][features]`, the last index running fastest. Inside, a row of gates is four blocks of
//! the hidden size: `i f g o` for an LSTM, `n r z q` for a GRU, so that the gates which the input feeds, and those which the
//! hidden state feeds, are each one run of columns.

mod activation;
mod backward;
mod buffer;
mod cells;
mod forward;
mod level;
mod product;

#[cfg(test)]
mod check;

pub use backward::{Pass, Work, backward};
pub use forward::{PackedLayer, Tape, forward};
pub use level::Level;

use super::Kind;

/// Sizes of a layer and of the sequence that it is given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shape {
    /// Time steps.
    pub steps: usize,
    /// Sequences side by side.
    pub batch: usize,
    /// Features of an input.
    pub input: usize,
    /// Features of the state.
    pub hidden: usize,
}

impl Shape {
    /// Rows of all steps together.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.steps * self.batch
    }

    /// Numbers in one step's state.
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
    /// First column of a row of gates that the hidden product feeds.
    fn hidden_column(self, hidden: usize) -> usize {
        match self {
            Kind::Lstm => 0,
            Kind::Gru => hidden,
        }
    }

    /// The input weights' rows in the order of a row of gates.
    fn input_parts(self, weights: &[f32]) -> [&[f32]; 2] {
        match self {
            Kind::Lstm => [weights, &[]],
            Kind::Gru => {
                let (rz, n) = weights.split_at(weights.len() / 3 * 2);
                [n, rz]
            }
        }
    }

    /// Reorders a row of gate biases, or of their gradients, from PyTorch's order to the kernel's; `back` the other way.
    fn reorder_bias(self, from: &[f32], to: &mut [f32], back: bool) {
        let n = from.len() / 4;
        match (self, back) {
            (Kind::Lstm, _) => to.copy_from_slice(from),
            (Kind::Gru, false) => {
                to[..n].copy_from_slice(&from[2 * n..3 * n]);
                to[n..3 * n].copy_from_slice(&from[..2 * n]);
                to[3 * n..].copy_from_slice(&from[3 * n..]);
            }
            (Kind::Gru, true) => {
                to[2 * n..3 * n].copy_from_slice(&from[..n]);
                to[..2 * n].copy_from_slice(&from[n..3 * n]);
                to[3 * n..].copy_from_slice(&from[3 * n..]);
            }
        }
    }
}
