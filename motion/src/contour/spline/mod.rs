//! Smooth paths through samples and along curves, piece by piece.

mod cubic;
mod curve_pieces;
mod local;
mod pieces;
mod sampled;

pub(super) use curve_pieces::CurvePieces;
pub(super) use local::{Arcs, distinct_neighbours, error, foot_on_chord, hermite, slope};
pub(super) use pieces::{Pieces, Place, first_where};
pub use sampled::SampledSpline;
