//! Training of the papers' networks: LSTM, GRU and NARX.
//!
//! [`train`] fits one axis, [`train_axes`] a machine. A [`NetworkRecipe`] holds the settings.

mod axes;
mod checkpoint;
mod clip;
mod dataset;
mod net;
mod recipe;
mod train;
pub mod windows;

pub use axes::{AxisRuns, train_axes};
pub use clip::{clip_global_norm, global_norm};
pub use recipe::{NetworkKind, NetworkRecipe};
pub use train::{Epoch, Trained, held_out_error, part_errors, train, train_on_residual, train_resumable};
