//! Correspondence between the samples of two runs.

mod align;
mod follow;

pub use align::{AlignSettings, AlignedBy, Alignment, align};
pub use follow::{at_places, at_places_and_corners, follow, follow_axes, poses_at_places};
