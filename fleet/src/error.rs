//! Errors of this crate.

use std::path::{Path, PathBuf};

use datasets::DatasetError;
use diagnosis::DiagnosisError;
use machine::MachineError;
use models::ModelError;
use polars::prelude::PolarsError;
use thiserror::Error;

/// Result of this crate.
pub type Result<T> = std::result::Result<T, FleetError>;

/// Errors of this crate.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FleetError {
    /// A file or folder cannot be read.
    #[error("cannot read {}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The reason.
        source: std::io::Error,
    },
    /// The folder holds no machine.
    #[error("{} holds no folder `machine=NAME`; logs are expected as machine=NAME/date=YYYY-MM-DD/*.parquet", path.display())]
    NoMachine {
        /// The folder.
        path: PathBuf,
    },
    /// No machine has this name.
    #[error("{} holds no machine `{name}`; its machines are {}", path.display(), known.join(" "))]
    UnknownMachine {
        /// The folder.
        path: PathBuf,
        /// The name.
        name: String,
        /// The names of the machines there.
        known: Vec<String>,
    },
    /// A machine has no log.
    #[error("{} holds no log; logs are expected as date=YYYY-MM-DD/*.parquet", path.display())]
    NoLog {
        /// The folder of the machine.
        path: PathBuf,
    },
    /// A folder of a day has a name that is no date.
    #[error("{}: `{date}` is no date; name the folder date=YYYY-MM-DD", path.display())]
    BadDate {
        /// The folder.
        path: PathBuf,
        /// What stands for the date.
        date: String,
    },
    /// A folder of a machine has a name that cannot be that of a model.
    #[error("{}: a machine's name may hold letters, digits, `-`, `_` and `.`, and does not begin with `.`; rename the folder", path.display())]
    BadName {
        /// The folder.
        path: PathBuf,
    },
    /// A Parquet file cannot be read, or an expression fails on it.
    #[error("{} cannot be read; check that it is a complete Parquet file of numbers", path.display())]
    Scan {
        /// The file or folder.
        path: PathBuf,
        /// The reason.
        source: Box<PolarsError>,
    },
    /// A log is not fit for use.
    #[error("{}: {reason}", path.display())]
    Unfit {
        /// The file.
        path: PathBuf,
        /// The reason, with the remedy.
        reason: String,
    },
    /// A log cannot be read.
    #[error(transparent)]
    Log(#[from] DatasetError),
    /// Logs of a machine cannot be analysed.
    #[error("machine {machine}")]
    Diagnosis {
        /// The machine.
        machine: String,
        /// The reason.
        source: Box<DiagnosisError>,
    },
    /// Training or evaluation of the model of a machine fails.
    #[error("machine {machine}")]
    Pipeline {
        /// The machine.
        machine: String,
        /// The reason.
        source: Box<pipeline::Error>,
    },
    /// A model cannot be used.
    #[error("{}", path.display())]
    Model {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: Box<ModelError>,
    },
    /// A machine file cannot be used.
    #[error("{}", path.display())]
    MachineFile {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: Box<MachineError>,
    },
    /// No servo model follows an axis.
    #[error(
        "machine {machine}: no servo model follows axis {axis}; record motion that excites it (precomp excite), or leave the axis out of the logs"
    )]
    NoServo {
        /// The machine.
        machine: String,
        /// The axis.
        axis: String,
    },
    /// A baseline file is damaged or of another version.
    #[error("{}: {reason}; train the machine again (remove the file first)", path.display())]
    Baseline {
        /// The file.
        path: PathBuf,
        /// The reason.
        reason: String,
    },
    /// A machine has no finished model.
    #[error("machine {machine} has no model in {}; run precomp fleet train first", path.display())]
    NotTrained {
        /// The machine.
        machine: String,
        /// The folder of the models.
        path: PathBuf,
    },
    /// A machine that should be simulated cannot have the fault.
    #[error("the fault `{fault}` does not fit: {reason}")]
    Fault {
        /// The fault, as stated.
        fault: String,
        /// The reason, with the remedy.
        reason: String,
    },
    /// A folder of a simulated machine is there already.
    #[error("{} is there already, and nothing is overwritten; name another folder, or remove it", path.display())]
    Exists {
        /// The folder.
        path: PathBuf,
    },
    /// A machine cannot be simulated.
    #[error(transparent)]
    Simulation(#[from] Box<pipeline::Error>),
    /// Results cannot be written as Parquet.
    #[error("the results cannot be written as Parquet: {0}")]
    Results(Box<PolarsError>),
}

impl FleetError {
    pub(crate) fn io(path: &Path) -> impl Fn(std::io::Error) -> Self + '_ {
        |source| Self::Io { path: path.to_owned(), source }
    }

    pub(crate) fn scan(path: &Path) -> impl Fn(PolarsError) -> Self + '_ {
        |source| Self::Scan { path: path.to_owned(), source: Box::new(source) }
    }

    pub(crate) fn pipeline(machine: &str) -> impl Fn(pipeline::Error) -> Self + '_ {
        |source| Self::Pipeline { machine: machine.to_owned(), source: Box::new(source) }
    }
}
