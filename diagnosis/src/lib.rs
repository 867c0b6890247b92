#![doc = include_str!("../README.md")]
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr, clippy::exit, clippy::disallowed_methods))]

mod bootstrap;
pub mod circle;
mod context;
mod diagnosis;
mod disturbance;
mod error;
mod finding;
mod findings;
pub mod linuxcnc;
pub mod record;
pub mod reversals;
pub mod threshold;

pub use context::{Sensor, TestCircle};
pub use diagnosis::{AxisModel, Diagnosis, Settings, diagnose};
pub use error::DiagnosisError;
pub use finding::{Estimate, Finding, Label, Mark, Picture, Quantity, Series, Verdict};
