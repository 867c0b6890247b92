//! Views of a run's error beyond its figures: distribution, spectrum, curves at reversals, and what the motion does where the error is large.

mod distribution;
mod lag_mismatch;
mod motion_at;
mod reversal_curves;
mod spectrum;
mod worst;

pub use distribution::{Distribution, distribution};
pub use lag_mismatch::{LagMismatch, Lagged};
pub use motion_at::{MotionAt, motion_at};
pub use reversal_curves::{ReversalCurve, ReversalCurves, reversal_curves};
pub use spectrum::{Spectrum, spectrum};
pub use worst::worst_samples;
