//! What can go wrong between bytes and bytes.

use compensation::CompensationError;
use datasets::{DatasetError, Severity};
use gcode::{Diagnostic, GcodeError};
use machine::MachineError;
use models::ModelError;
use motion::MotionError;
use thiserror::Error;
use training::TrainingError;

use crate::units::{ErrorUnit, um};

mod read_back;

pub use read_back::{ProgramFault, VerifyError};

/// Result of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Errors of this crate. Those of a program name its line; those of a log its run.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Error {
    /// The program was refused: its faults, and the same as text with a caret under each word.
    #[error("{text}")]
    Program {
        /// Every fault with its place.
        diagnostics: Vec<Diagnostic>,
        /// The faults as they are shown; the label of the first one is left to whoever shows the text.
        text: String,
    },
    /// Nothing of the program cuts.
    #[error("{name}: the program has no feed move; there is nothing to plan or to compensate")]
    NoFeedMove {
        /// Name of the program.
        name: String,
    },
    /// The program moves none of the machine's axes.
    #[error(
        "{name}: no move of the program moves an axis of the machine ({}); describe the axes that it moves in the machine file",
        axes.join(", ")
    )]
    NoAxisMoved {
        /// Name of the program.
        name: String,
        /// Axes of the machine.
        axes: Vec<String>,
    },
    /// A tool length for a machine whose description holds it.
    #[error(
        "--tool-length is for machines that do not turn tool or part; here the machine file says it (kinematics.tool_length_mm), \
         as the positions of all axes go by it"
    )]
    ToolLengthOfTurningMachine,
    /// A path without a program leaves the travel of an axis.
    #[error("{name}: at t = {time_s:.3} s {what}")]
    OffTravel {
        /// Name of the path.
        name: String,
        /// When, s.
        time_s: f64,
        /// Axis, position and limits.
        what: String,
    },
    /// No sample of the path counts in figures.
    #[error("the path has no samples")]
    NoSamples,
    /// The path that a run is compared with stands still.
    #[error("the path does not move")]
    NoMotion,
    /// The description of the machine in a model is not sound.
    #[error("the model's machine: {0}")]
    ModelMachine(#[source] MachineError),
    /// What is asked for needs a part program, and the path comes from none.
    #[error("this needs a part program; a reference has no lines, feeds or commands of its own")]
    NoProgram,
    /// A log that is no run of the program.
    #[error(
        "`{log}` is not the log of a run of {program}, uncompensated and whole; where the part lies elsewhere on the machine, say so with --work-offset"
    )]
    OtherRun {
        /// Name of the log.
        log: String,
        /// Name of the program.
        program: String,
        /// Where the comparison failed.
        source: Box<Error>,
    },
    /// A recorded command that leaves the program's path.
    #[error(
        "the recorded command is up to {} µm off the program's path: the log is of another program, or the control rounds corners so \
         far off that lines have no place on it; tighten its tolerance and record again",
        um(*off_mm)
    )]
    CommandOffPath {
        /// How far it is off at most, mm.
        off_mm: f64,
    },
    /// A recorded command that is not of a whole run.
    #[error("`{log}` {verb} {off_mm:.3} mm from the program's {place}; record the whole run, with a rest before and after")]
    PartOfRun {
        /// Name of the log.
        log: String,
        /// `begins` or `ends`.
        verb: &'static str,
        /// `start` or `end`.
        place: &'static str,
        /// Distance, mm.
        off_mm: f64,
    },
    /// A recorded command whose rotary axes turn elsewhere than the tool tip says.
    #[error(
        "axis {axis} of the recorded command is up to {:.3}° from where the program has it while the tip is there; moves that turn \
         the tool about a resting tip have no place on a recorded path: compensate from the plan, without --reference",
        off_rad.to_degrees()
    )]
    CommandTurnsElsewhere {
        /// The axis.
        axis: String,
        /// How far it is off at most, rad.
        off_rad: f64,
    },
    /// Setpoints of a program that cuts in several coordinate systems.
    #[error(
        "{name}: the program cuts in coordinate systems whose offsets differ: setpoints know only one; split it by coordinate system, or write a program \
         (--format keep)"
    )]
    SetpointsInSeveralSystems {
        /// Name of the program.
        name: String,
    },
    /// Setpoints cannot stand for a block of the program.
    #[error(
        "{name}: line {line} {why}: setpoints cannot stand for it; cut the program there, or write a program (--format keep)"
    )]
    SetpointsCannotHold {
        /// Name of the program.
        name: String,
        /// Line, from 1.
        line: usize,
        /// What the block does.
        why: &'static str,
    },
    /// The output did not pass its own check.
    #[error("the compensated program did not pass its check and was not written")]
    Verify(#[from] VerifyError),
    /// A move in inverse time without a time.
    #[error("line {line}: a move in inverse time has no F")]
    NoInverseTime {
        /// Line, from 1.
        line: usize,
    },
    /// An excitation run that could not be written as a program.
    #[error("the program of run {run} was not written")]
    Excitation {
        /// Name of the run.
        run: String,
        /// Where it differs when read back.
        source: ProgramFault,
    },
    /// Logs that nothing can be learned from.
    #[error("the log is not fit for training:\n  {}", reasons.join("\n  "))]
    UnfitLogs {
        /// One reason a fault.
        reasons: Vec<String>,
    },
    /// There is no log.
    #[error("there is no log")]
    NoLog,
    /// A recipe without a predictor.
    #[error("the recipe has no stage")]
    EmptyRecipe,
    /// A thread that trained an axis ended early.
    #[error("a training thread failed")]
    Thread,
    /// A model that does no better on held-out data than none.
    #[error(
        "axis {axis}: the model leaves {} of {} RMS on held-out data, no better than no model; nothing is written. Look for exchanged columns, lost rows or \
         too little motion, or leave the axis out with --columns",
        unit.number(*rms),
        unit.text(*raw_rms)
    )]
    NoBetterThanNoModel {
        /// The axis.
        axis: String,
        /// Unit in which its errors are shown.
        unit: ErrorUnit,
        /// What the model leaves, mm or rad.
        rms: f64,
        /// The tracking error itself, mm or rad.
        raw_rms: f64,
    },
    /// A predictor that cannot be adapted.
    #[error("axis {axis} has a predictor of the kind `{kind}`; only staged models can be adapted: train a new one")]
    NotAdaptable {
        /// The axis.
        axis: String,
        /// Kind of its predictor.
        kind: String,
    },
    /// A log without an axis that the model has.
    #[error("the log {log} lacks the axis {axis}, which the model has")]
    LogLacksAxis {
        /// Name of the log.
        log: String,
        /// The axis.
        axis: String,
    },
    /// A log with none of the model's axes.
    #[error("the log has none of the model's axes")]
    NoCommonAxis,
    /// A log sampled at another rate than the model.
    #[error("the model was trained at {model_ms} ms a sample, the log has {log_ms} ms")]
    OtherRate {
        /// Period of the model, ms.
        model_ms: f64,
        /// Period of the log, ms.
        log_ms: f64,
    },
    /// The curve on which ILC is tuned does not fit the machine.
    #[error("the curve on which ILC is tuned does not fit the machine; give its gain and cut-off with --gain and --low-pass")]
    TuningCurve(#[source] Box<Error>),
    /// A law of which no run was made.
    #[error("{0} made no run")]
    NoRun(&'static str),
    /// The caller asked to stop.
    #[error("cancelled")]
    Cancelled,
    /// Of the program.
    #[error(transparent)]
    Gcode(#[from] GcodeError),
    /// Of curves, trajectories and plans.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// Of a machine.
    #[error(transparent)]
    Machine(#[from] MachineError),
    /// Of laws.
    #[error(transparent)]
    Compensation(#[from] CompensationError),
    /// Of logs and references.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// Of a model.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// Of a fit.
    #[error(transparent)]
    Training(#[from] TrainingError),
}

impl Error {
    /// The reasons for which a report refuses logs.
    pub(crate) fn unfit(report: &datasets::Report) -> Self {
        Self::UnfitLogs { reasons: report.of(Severity::Refuse).map(ToString::to_string).collect() }
    }
}
