//! Curves in space: what a tool tip follows.

mod basic;
mod jet;
pub mod library;
mod nurbs;
mod polygon;
mod saddle;

pub use basic::{Arc, Bezier, Line};
pub use jet::Jet;
pub use nurbs::Nurbs;
pub use polygon::RoundedPolygon;
pub use saddle::OnSaddle;

use crate::Vec3;

/// A curve `C(u)`, three times differentiable except where it says otherwise; lengths in mm.
pub trait Curve: std::fmt::Debug + Send + Sync {
    /// The parameter's range `(first, last)`, `first < last`.
    fn domain(&self) -> (f64, f64);

    /// Position and derivatives `[C, C′, C″, C‴]` at `u`, with respect to `u`; `u` outside the domain is clamped.
    fn derivatives(&self, u: f64) -> [Vec3; 4];

    /// Position at `u`, mm.
    fn point(&self, u: f64) -> Vec3 {
        self.derivatives(u)[0]
    }

    /// First derivative at `u`, mm.
    fn velocity(&self, u: f64) -> Vec3 {
        self.derivatives(u)[1]
    }

    /// Degree of a curve that is a polynomial in `u`; `None` of any other.
    fn degree(&self) -> Option<usize> {
        None
    }

    /// Unit vector along the tool at `u`, from the tip towards the spindle; upright unless the curve says otherwise.
    fn tool(&self, _u: f64) -> Vec3 {
        Vec3::z()
    }
}
