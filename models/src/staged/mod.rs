//! The staged predictor: linear law, stop operators on the expected position, waves and worn places along the axis; all
//! least squares.
//!
//! Each stage is there because held-out runs asked for it, so that a simple axis keeps a simple predictor. A network on what is left
//! over can be stacked on it: see [`crate::StackedPredictor`].

mod features;
mod fir;
mod friction_map;
mod phase;
mod predictor;
mod regressor;
mod signals;
mod stop;
mod taps;
mod weighted;

pub use features::{FeatureGroup, FeatureSet};
pub use fir::{Fir, LagBasis};
pub use friction_map::{FrictionMap, Levels};
pub use predictor::{KIND, Pass, StagedPredictor};
pub use regressor::{MotionFactor, PositionFactor, Regressor, Waves};
pub use signals::{Scales, Signals};
pub use stop::run_stops;
