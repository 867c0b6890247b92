//! Correspondence between the samples of two runs.

mod align;
mod follow;

pub use align::{AlignSettings, AlignedBy, Alignment, align};
pub use follow::{at_places, follow, follow_axes, poses_at_places};
