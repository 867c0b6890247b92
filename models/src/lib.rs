//! Predictors of an axis's tracking error, and the model bundle that stores them.

#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr, clippy::exit, clippy::disallowed_methods))]

mod bundle;
mod error;
pub mod features;
mod hex;
mod learned;
mod load;
mod memory;
pub mod narx;
pub mod network;
mod operating_range;
mod prediction_interval;
mod predictor;
mod quantile;
mod ranges;
pub mod recurrent;
mod scaler;
mod spread;
pub mod stacked;
pub mod staged;

pub use bundle::{AxisManifest, Bundle, ControlFidelity, FORMAT, HeldOut, LARGEST_BYTES, Manifest};
pub use error::ModelError;
pub use features::{FeatureSet, FeatureSpec};
pub use hex::hex;
pub use learned::LearnedMachine;
pub use load::load_predictor;
pub use memory::keep_memory;
pub use narx::NarxPredictor;
pub use network::NetworkPredictor;
pub use operating_range::{OperatingRange, Outside, fade};
pub use prediction_interval::PredictionInterval;
pub use predictor::{Array, ArrayData, AxisPredictor, AxisSignal, SavedPredictor};
pub use scaler::Scaler;
pub use spread::{PEAK_S, REGIME_NAMES, REGIMES, Spread};
pub use stacked::StackedPredictor;
