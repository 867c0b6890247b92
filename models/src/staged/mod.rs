//! The grey-box cascade: linear law, stop operators on the expected position, position harmonics
//! and a friction map along the axis; all least squares. They predict the whole tracking error, or
//! what a servo model of the axis leaves of it.
//!
//! A stage is present only if it lowers the error on held-out runs, so that a simple axis has a
//! simple predictor. A network on the residual can be stacked on it: see
//! [`crate::StackedPredictor`].

mod features;
mod fir;
mod friction_map;
mod phase;
mod predictor;
mod regressor;
mod servo_base;
mod signals;
mod stop;
mod taps;
mod weighted;

pub use features::{FeatureGroup, FeatureSet};
pub use fir::{Fir, LagBasis};
pub use friction_map::{FrictionMap, Levels};
pub use predictor::{KIND, Pass, StagedPredictor};
pub use regressor::{Harmonics, MotionFactor, PositionFactor, Regressor};
pub use servo_base::ServoBase;
pub use signals::{Scales, Signals};
pub use stop::run_stops;
