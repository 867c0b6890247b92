//! Smooth paths of cubic pieces through samples and along curves.

mod cubic;
mod curve_pieces;
mod local;
mod pieces;
mod sampled;

pub(super) use curve_pieces::CurvePieces;
pub(super) use local::{Arcs, distinct_neighbours, error, foot_on_chord, hermite, slope};
pub(super) use pieces::{PathPoint, Pieces, first_where};
pub use sampled::SampledSpline;
