//! Errors of logs, references and excitation.

use std::path::{Path, PathBuf};

use motion::MotionError;
use thiserror::Error;

/// Errors of this crate. File errors name the file and, if known, line and column.
#[derive(Debug, Error)]
pub enum DatasetError {
    /// The file cannot be opened, read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The file's bytes violate its format.
    #[error("{}: {message}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// Description of the fault.
        message: String,
    },
    /// A row has more fields, or before the last row fewer, than there are columns.
    #[error("{}: line {line}: {found} fields where the header has {expected}; mend the line or log the run again", path.display())]
    Ragged {
        /// The file.
        path: PathBuf,
        /// Line in the file, from 1.
        line: usize,
        /// Fields in that line.
        found: usize,
        /// Fields in the header.
        expected: usize,
    },
    /// A required value is empty, NaN, infinite or not a number.
    #[error("{}: line {line}: column `{column}` has no finite number; delete the row and those before or after it, or log the run again", path.display())]
    Missing {
        /// The file.
        path: PathBuf,
        /// Line in the file (text) or row (Parquet), from 1.
        line: usize,
        /// Name of the column.
        column: String,
    },
    /// An implausible value: a damaged number, counts taken for a length, or a wrong unit.
    #[error("{}: line {line}: column `{column}` holds {value} {unit}, beyond ±{most:e} {unit}; mend the number, or state the column's unit with --columns", path.display())]
    Absurd {
        /// The file.
        path: PathBuf,
        /// Line in the file (text) or row (Parquet), from 1.
        line: usize,
        /// Name of the column.
        column: String,
        /// The value.
        value: f64,
        /// Largest accepted magnitude.
        most: f64,
        /// Unit of both.
        unit: &'static str,
    },
    /// The command of an axis moves and its actual position does not.
    #[error("{}: the command travels {travel:.3} {unit} but column `{column}` never changes; log the encoder's position", path.display())]
    Stuck {
        /// The file.
        path: PathBuf,
        /// Name of the column of the actual position.
        column: String,
        /// Travel of the command.
        travel: f64,
        /// Its unit.
        unit: &'static str,
    },
    /// The column mapping cannot be parsed.
    #[error("column mapping `{text}`: {reason}; write it as `t=time_s,x_ref=x_cmd_mm,x_act=x_act:um`")]
    Mapping {
        /// The entry.
        text: String,
        /// Description of the fault.
        reason: String,
    },
    /// Required columns are missing or not unique.
    #[error("{}: {reason}; the columns are {}; name them with a mapping like `t=time_s,x_ref=x_cmd_mm,x_act=x_act:um`", path.display(), list(names))]
    Columns {
        /// The file.
        path: PathBuf,
        /// Description of the missing or ambiguous columns.
        reason: String,
        /// Names of all columns of the file.
        names: Vec<String>,
    },
    /// The sampling times are unknown.
    #[error("{}: no time column and no sampling period given{hints}", path.display())]
    NoTime {
        /// The file.
        path: PathBuf,
        /// Estimate of rate and digits from the data; empty or starting with `; `.
        hints: String,
    },
    /// A time stamp is not later than the previous one.
    #[error("{}: line {line}: time {time_s} s does not come after {before_s} s; sort the rows, or cut the file there into two runs", path.display())]
    TimeOrder {
        /// The file.
        path: PathBuf,
        /// Line in the file, from 1.
        line: usize,
        /// Time stamp, s.
        time_s: f64,
        /// Previous time stamp, s.
        before_s: f64,
    },
    /// A commanded path whose time stamps have a gap.
    #[error("{}: line {line}: the time steps by {step_s:.6} s after {time_s} s; a commanded path has no gaps: what is commanded there is not known. Write every sample, or cut the file there into two paths", path.display())]
    Gap {
        /// The file.
        path: PathBuf,
        /// Line before the gap, from 1.
        line: usize,
        /// Time stamp before the gap, s.
        time_s: f64,
        /// Length of the gap, s.
        step_s: f64,
    },
    /// Too few rows.
    #[error("{}: {rows} rows; a log needs at least {needed}", path.display())]
    TooShort {
        /// The file.
        path: PathBuf,
        /// Rows found.
        rows: usize,
        /// Rows needed.
        needed: usize,
    },
    /// A setting is out of range.
    #[error("{name} is {value}; {remedy}")]
    BadSetting {
        /// The setting, with its unit.
        name: &'static str,
        /// The value given.
        value: f64,
        /// Accepted range.
        remedy: &'static str,
    },
    /// Runs cannot be split or combined.
    #[error("{0}")]
    Runs(String),
    /// Columns that do not form a trajectory.
    #[error(transparent)]
    Motion(#[from] MotionError),
}

impl DatasetError {
    pub(crate) fn io(path: &Path, source: std::io::Error) -> Self {
        Self::Io { path: path.to_owned(), source }
    }

    pub(crate) fn format(path: &Path, message: impl ToString) -> Self {
        Self::Format { path: path.to_owned(), message: message.to_string() }
    }
}

fn list(names: &[String]) -> String {
    const SHOWN: usize = 16;
    let mut text = names.iter().take(SHOWN).map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    if names.len() > SHOWN {
        text += &format!(" and {} more", names.len() - SHOWN);
    }
    text
}
