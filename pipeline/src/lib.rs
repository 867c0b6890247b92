#![doc = include_str!("../README.md")]
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr, clippy::exit, clippy::disallowed_methods))]

pub mod analysis;
pub mod compare;
pub mod control;
mod error;
pub mod excitation;
mod expectation;
pub mod feed_adjustment;
mod forecast;
pub mod identification;
mod input;
pub mod measure;
pub mod model_based_ilc;
mod other_plans;
mod output;
pub mod part;
pub mod path_time;
mod pieces;
mod position_terms;
pub mod progress;
mod recorded;
pub mod refine;
pub mod refit;
pub mod setpoints;
mod setup;
pub mod statistics;
mod tally;
pub mod training;
pub mod travel;
pub mod units;
pub mod windows;

pub use error::{Error, ProgramFault, Result, VerifyError};
pub use expectation::{Expectation, Expected, ExpectedFigures};
pub use forecast::{Columns, Forecast, forecast};
pub use input::{Input, TimedPath};
pub use model_based_ilc::model_based_ilc;
pub use other_plans::{is_control_unknown, is_plan_guessed};
pub use output::{Output, OutputFormat, OutputSettings};
pub use part::{Part, ReadSettings};
pub use position_terms::{PositionTerms, machine_for};
pub use progress::{Event, Progress, SILENT};
pub use recorded::{Recorded, as_recorded};
pub use setup::{Setup, machine_of};

pub use ::training::Recipe;
pub use datasets::Log;
pub use machine::{Machine, MachineSpec, SimulatedMachine};
pub use models::Bundle;
pub use motion::contour::Exact;
