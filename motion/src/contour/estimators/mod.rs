//! Estimators of the foot points of samples on a path.

mod exact;
mod hermite;
mod local;
mod moving_window;
mod on_curve;
mod osculating;
mod search;
mod stream;
mod tangent;
mod window;

pub use exact::Exact;
pub use hermite::{HermiteFootPoint, Horizon};
pub use moving_window::MovingWindow;
pub use on_curve::ExactOnCurve;
pub use osculating::OsculatingCircle;
pub use search::SplineSearch;
pub use stream::ExactStream;
pub use tangent::Tangent;
pub use window::Window;
