//! Excitation, reading and writing of logs, quality checks and splits.
//!
//! A file is read in three steps, so that a new controller's format is one file: a [`LogFormat`]
//! turns bytes into a [`Table`] of named columns, a [`ColumnMap`] assigns columns to axes and
//! units, and [`read_log`] builds a [`Log`] at a uniform rate. Every fault of a log becomes a
//! [`Finding`] in a [`Report`].

#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr, clippy::exit, clippy::disallowed_methods))]

mod atomic;
mod clocks;
pub mod columns;
mod cycles;
mod error;
mod even_rows;
pub mod excitation;
pub mod formats;
mod inspect;
mod join;
mod log;
mod long;
mod missing;
mod options;
mod parts;
pub mod quality;
mod read;
mod recorded;
mod reference;
mod report;
mod resample;
mod side_file;
mod spikes;
mod splits;
mod stretches;
mod table;
mod timing;
mod tracking_errors;
mod turns;
mod usable;
mod wraps;
mod write;

pub use atomic::{ignores_case, try_folder, write_all, write_all_and, write_atomically};
pub use columns::{ColumnMap, Source};
pub use error::DatasetError;
pub use excitation::{ExcitationPlan, RunPlan, Shape, excite};
pub use formats::LogFormat;
pub use inspect::{Column, Inspection, Role, inspect};
pub use join::joined;
pub use log::Log;
pub use long::{Extent, Lengths, LongFile, Piece, PieceFindings, Pieces, Recording};
pub use options::ReadOptions;
pub use quality::{Purpose, assess, assess_runs, moving_axes, without_offsets};
pub use read::{log_from_bytes, log_from_table, read_log, read_runs, runs_from_table};
pub use reference::{read_reference, reference_content, reference_from_table, write_reference};
pub use report::{Check, Finding, Place, Report, Severity};
pub use side_file::side_file;
pub use splits::{Fold, between_standstills, folds, scored};
pub use stretches::{Stretch, stretches};
pub use table::Table;
pub use write::{LogSpool, log_content, write_log};
