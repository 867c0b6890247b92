#![doc = include_str!("../README.md")]
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr, clippy::exit, clippy::disallowed_methods))]

mod alarm;
mod baseline;
mod error;
mod estimate;
mod fault;
mod quality;
mod results;
mod reversals;
mod sensitivity;
mod simulation;
mod store;
mod table;
mod train;
mod watch;

pub use alarm::{Change, Limits, limit};
pub use baseline::{AxisBaseline, Baseline, baseline_path, model_path};
pub use error::{FleetError, Result};
pub use estimate::{AxisEstimate, Quantity, Reading, estimates};
pub use fault::{Fault, FaultKind, FaultSyntax};
pub use quality::{Quality, quality};
pub use results::{content, rolling};
pub use simulation::{SimulatedFleet, machine_name};
pub use store::{Day, MachineFolder, Store};
pub use table::{day_logs, read_table};
pub use train::{Finished, TrainSettings, finished, train};
pub use watch::{AxisDay, Phase, WatchSettings, watch};
