//! Recurrent layers, LSTM and GRU, whose whole sequence is one operation.
//!
//! Three ways in, all on the same kernels and the same weights:
//! - [`lstm`] and [`gru`]: one burn operation with a backward pass of its own;
//! - [`FusedRecurrent`]: a burn module, a stack of such layers, to train, with [`Adam`] for instance;
//! - [`Recurrent`]: plain weights, to predict with, sample by sample or a long sequence at once.
//!
//! Conventions are PyTorch's: gates in the order `i f g o` (LSTM) and `r z n` (GRU, whose reset gate multiplies the hidden
//! product *with* its bias `b_hn`). A layer has one bias vector of `4·hidden`: for an LSTM the sum `b_ih + b_hh`; for a GRU the
//! sums of `r` and `z`, then `b_in`, then `b_hn`, which are all that can be identified.

mod adam;
mod init;
mod kernel;
mod layer;
mod module;
mod operation;
mod predict;

pub use adam::Adam;
pub use kernel::Level;
pub use layer::{Head, LayerWeights, NamedTensor};
pub use module::{FusedLayer, FusedRecurrent, RecurrentConfig};
pub use operation::{RecurrentOps, gru, lstm};
pub use predict::{Recurrent, State};

/// Which recurrent cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Long short-term memory.
    Lstm,
    /// Gated recurrent unit.
    Gru,
}

impl Kind {
    /// Gates, each as many rows of the weights as the layer has units.
    #[must_use]
    pub fn gates(self) -> usize {
        match self {
            Self::Lstm => 4,
            Self::Gru => 3,
        }
    }
}
