//! The laws, one file each.

mod contour_optimal;
mod norm_optimal;
mod one_shot;
mod spatial;
mod tracking;

pub use contour_optimal::ContourOptimal;
pub use norm_optimal::{NormOptimalIlc, NormOptimalSettings};
pub use one_shot::OneShot;
pub use spatial::{Gain, SpatialIlc};
pub use tracking::TrackingIlc;
