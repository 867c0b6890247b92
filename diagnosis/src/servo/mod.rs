//! The servo model of an axis and its fit.

mod command;
mod covariance;
mod disturbed;
mod fit;
mod parameters;
mod search;
mod simulate;

pub use covariance::clustered;
pub use disturbed::disturbed;
pub use fit::{Fit, Free, fit};
pub use parameters::{COUNT, Servo, index};
pub use search::identify;
pub use simulate::{Simulated, simulate, simulate_with_friction};
