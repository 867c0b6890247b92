//! Curves in space: paths of the tool tip.

mod basic;
mod jet;
pub mod library;
mod nurbs;
mod polygon;
mod ruled;
mod saddle;

pub use basic::{Arc, Bezier, Line};
pub use jet::Jet;
pub use nurbs::Nurbs;
pub use polygon::RoundedPolygon;
pub use ruled::RuledSurface;
pub use saddle::OnSaddle;

use crate::Vec3;

/// A curve `C(u)`, three times differentiable unless stated otherwise. Lengths in mm.
pub trait Curve: std::fmt::Debug + Send + Sync {
    /// Parameter range `(first, last)`, `first < last`.
    fn domain(&self) -> (f64, f64);

    /// Position and derivatives `[C, C′, C″, C‴]` at `u`, with respect to `u`. `u` outside the
    /// domain is clamped.
    fn derivatives(&self, u: f64) -> [Vec3; 4];

    /// Position at `u`, mm.
    fn point(&self, u: f64) -> Vec3 {
        self.derivatives(u)[0]
    }

    /// First derivative at `u`, mm.
    fn velocity(&self, u: f64) -> Vec3 {
        self.derivatives(u)[1]
    }

    /// Degree of a curve that is a polynomial in `u`, otherwise `None`.
    fn degree(&self) -> Option<usize> {
        None
    }

    /// Unit vector along the tool at `u`, from the tip towards the spindle. Default: upright.
    fn tool(&self, _u: f64) -> Vec3 {
        Vec3::z()
    }
}
