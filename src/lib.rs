//! The command line of `precomp`: arguments, files, printing, progress and the report around the library [`pipeline`].
//!
//! It is a library so that the Python package runs the same command and reads options, machines, paths and models as it does. What only
//! the package uses is hidden from the documentation and may change.

#[doc(hidden)]
pub mod args;
mod cli;
mod commands;
#[doc(hidden)]
pub mod date;
mod files;
#[doc(hidden)]
mod kind;
pub mod numbers;
#[doc(hidden)]
pub mod output;
mod output_format;
mod plot;
#[doc(hidden)]
pub mod print;
mod progress;
#[doc(hidden)]
pub mod read;
mod report;
mod same_file;

pub use cli::{main, status};
#[doc(hidden)]
pub use commands::{
    compare::unseen,
    compensate::{AT_BOUND, Chosen, Effort, FeedArgs},
    excite::RegionArgs,
    measure::EstimatorName,
    simulate::SensorName,
    train::FeatureName,
};
pub use output::text;
#[doc(hidden)]
pub use progress::title;
