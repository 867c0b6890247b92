#![doc = include_str!("../README.md")]
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr, clippy::exit, clippy::disallowed_methods))]

mod axis;
mod command;
mod contacts;
mod covariance;
mod disturbed;
mod fit;
mod lanes;
mod parameters;
mod record;
mod scales;
mod search;
mod simulate;
mod starts;
mod table;

pub use axis::Start;
pub use covariance::clustered;
pub use disturbed::disturbed;
pub use fit::{Fit, Free, fit};
pub use parameters::Servo;
pub use record::{Record, Run, Scope};
pub use scales::{COUNT, PLACES, index};
pub use search::{identify, identify_all, identify_any_control, refit};
pub use simulate::{MOVING_MM_S, Simulated, simulate, simulate_with_friction, speed_at_start};
