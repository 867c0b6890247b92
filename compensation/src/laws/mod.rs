//! The laws, a file each.

mod one_shot;
mod spatial;
mod tracking;

pub use one_shot::OneShot;
pub use spatial::{Gain, SpatialIlc};
pub use tracking::TrackingIlc;
