//! Errors of this crate.

use compensation::CompensationError;
use datasets::{DatasetError, Severity};
use gcode::{Diagnostic, Foreign, GcodeError};
use machine::MachineError;
use models::ModelError;
use motion::MotionError;
use thiserror::Error;
use training::TrainingError;

use crate::units::{ErrorUnit, um};

mod read_back;

pub use read_back::{ProgramFault, VerifyError};

/// Result with an error of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Errors of this crate. Program errors carry the line, log errors the run.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum Error {
    /// The program is refused. The error holds its faults, and their text with a caret under each word.
    #[error("{text}")]
    Program {
        /// Every fault with its position in the program.
        diagnostics: Vec<Diagnostic>,
        /// Text of the faults; the first one has no `error:` label.
        text: String,
    },
    /// The content is no milling program in G-code.
    #[error("{name}: {kind}")]
    NotAProgram {
        /// Name of the file.
        name: String,
        /// What it is.
        kind: Foreign,
    },
    /// Dialogue has no words for the time of a line.
    #[error("{name}: Heidenhain dialogue keeps its feeds and cannot be written in the format {encoding}; give --format keep")]
    DialogueTimes {
        /// Name of the program.
        name: String,
        /// Name of the time encoding.
        encoding: &'static str,
    },
    /// The program has no feed move.
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
    /// The program was compensated before: its points are no longer those that the part needs.
    #[error("{name}: line {line} states that precomp compensated this program; give the original program instead")]
    AlreadyCompensated {
        /// Name of the program.
        name: String,
        /// Line of the comment, from 1.
        line: usize,
    },
    /// A tool length is given for a machine with rotary axes, whose description holds it.
    #[error(
        "--tool-length is for machines that do not turn tool or part; here the machine file says it (kinematics.tool_length_mm), \
         as the positions of all axes go by it"
    )]
    ToolLengthOfTurningMachine,
    /// A path without a program exceeds the travel of an axis.
    #[error("{name}: at t = {time_s:.3} s {what}")]
    OffTravel {
        /// Name of the path.
        name: String,
        /// Time on the path, s.
        time_s: f64,
        /// Axis, position and limits.
        what: String,
    },
    /// A reference moves an axis faster than any drive of this machine could follow.
    #[error(
        "{name}: at t = {time_s:.3} s axis {axis} moves at {speed:.1} per second, more than {times} times its limit of {limit:.1}: \
         mend the jump in the reference, or the limit in the machine file"
    )]
    TooFast {
        /// Name of the reference.
        name: String,
        /// Time since the first sample, s.
        time_s: f64,
        /// Name of the axis.
        axis: String,
        /// Speed, mm/s or rad/s.
        speed: f64,
        /// Speed limit of the axis, mm/s or rad/s.
        limit: f64,
        /// Multiple of the limit that is not exceeded.
        times: f64,
    },
    /// No feed of the program may change.
    #[error(
        "{name}: no feed may change: {}",
        if *named { "no compensable feed move lies in the lines or uses the tools that --lines and --tools name" }
        else { "the program has no compensable move with a feed in units per minute or revolution (G94, G95)" }
    )]
    NoFeedToChange {
        /// Name of the program.
        name: String,
        /// Whether lines or tools were named.
        named: bool,
    },
    /// No sample of the path is evaluated.
    #[error("nothing can be evaluated: the path has no feed move, or the run does not reach one")]
    NoSamples,
    /// The path of a comparison has no motion.
    #[error("the path does not move")]
    NoMotion,
    /// A program with a log does not move.
    #[error("{0} does not move, and says nothing about the control; leave it out of --programs")]
    StillProgram(String),
    /// The machine description in a model is invalid.
    #[error("the model's machine: {0}")]
    ModelMachine(#[source] MachineError),
    /// The model does not state its errors by regime of motion, or of no axis that moves.
    #[error(
        "the model does not say, of any axis that moves here, what its log holds of every kind of motion; train it with this version, on logs of this machine \
         of half a minute or more"
    )]
    NoRegimes,
    /// The operation needs a part program; the input is a reference or curve.
    #[error("this needs a part program; a reference has no lines, feeds or commands of its own")]
    NoProgram,
    /// The log is not of an uncompensated, complete run of the program.
    #[error(
        "`{log}` is not the log of a run of {program}, uncompensated and whole; where the part lies elsewhere on the machine, say so with --work-offset"
    )]
    OtherRun {
        /// Name of the log.
        log: String,
        /// Name of the program.
        program: String,
        /// Reason why the comparison failed.
        source: Box<Error>,
    },
    /// A recorded command deviates from the program's path.
    #[error(
        "the recorded command is up to {} µm off the program's path: the log is of another program, or the control rounds corners so \
         far off that lines have no place on it; tighten its tolerance and record again",
        um(*off_mm)
    )]
    CommandOffPath {
        /// Largest distance, mm.
        off_mm: f64,
    },
    /// A recorded command does not cover the complete run.
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
    /// A recorded command that is shifted as that of a compensated program.
    #[error("{log}: its command is shifted as that of a compensated program; give the log of a run of the program itself")]
    CompensatedRecord {
        /// Name of the log.
        log: String,
    },
    /// Rotary axes of a recorded command deviate from the program at the same tip position.
    #[error(
        "axis {axis} of the recorded command is up to {:.3}° from where the program has it while the tip is there: compensate from \
         the plan, without --reference",
        off_rad.to_degrees()
    )]
    CommandTurnsElsewhere {
        /// The axis.
        axis: String,
        /// Largest angle, rad.
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
    /// Setpoints cannot represent a block of the program.
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
    /// The output failed verification.
    #[error("the compensated program did not pass its check and was not written")]
    Verify(#[from] VerifyError),
    /// A move in inverse time (G93) has no F word.
    #[error("line {line}: a move in inverse time has no F")]
    NoInverseTime {
        /// Line, from 1.
        line: usize,
    },
    /// An excitation run could not be written as a program.
    #[error("the program of run {run} was not written")]
    Excitation {
        /// Name of the run.
        run: String,
        /// Difference found when it was read back.
        source: ProgramFault,
    },
    /// The origin of an excitation names an axis that the machine lacks.
    #[error("the origin names axis `{axis}`, and the machine has {}", known.join(", "))]
    OriginOfNoAxis {
        /// Name of the axis.
        axis: String,
        /// Names of the machine's axes.
        known: Vec<String>,
    },
    /// The origin of an excitation leaves no room to either side.
    #[error("the origin of axis `{axis}` is {origin} {unit}; excitation keeps within {low:.3} to {high:.3} {unit} of its travel")]
    OriginOutside {
        /// Name of the axis.
        axis: String,
        /// Stated origin, in `unit`.
        origin: f64,
        /// Lowest position, in `unit`.
        low: f64,
        /// Highest position, in `unit`.
        high: f64,
        /// Unit of positions in programs.
        unit: &'static str,
    },
    /// The logs are not fit for training.
    #[error("the log is not fit for training:\n  {}", reasons.join("\n  "))]
    UnfitLogs {
        /// One reason for each fault.
        reasons: Vec<String>,
    },
    /// No log is given.
    #[error("there is no log")]
    NoLog,
    /// The recipe has no predictor.
    #[error("the recipe has no stage")]
    EmptyRecipe,
    /// A training thread panicked.
    #[error("a training thread failed")]
    Thread,
    /// A model predicts an axis no better on held-out data than no model.
    #[error(
        "axis {axis}: the model leaves {} of {} RMS on held-out data, no better than no model; nothing is written. Look for exchanged columns, lost rows or \
         too little motion, or leave the axis out with --columns",
        unit.number(*rms),
        unit.text(*raw_rms)
    )]
    NoBetterThanNoModel {
        /// The axis.
        axis: String,
        /// Unit of its errors in reports.
        unit: ErrorUnit,
        /// RMS error of the model, mm or rad.
        rms: f64,
        /// RMS tracking error, mm or rad.
        raw_rms: f64,
    },
    /// A predictor of this kind cannot be adapted.
    #[error("axis {axis} has a predictor of the kind `{kind}`; only staged models can be adapted: train a new one")]
    NotAdaptable {
        /// The axis.
        axis: String,
        /// Kind of its predictor.
        kind: String,
    },
    /// The log lacks an axis of the model.
    #[error("the log {log} lacks the axis {axis}, which the model has")]
    LogLacksAxis {
        /// Name of the log.
        log: String,
        /// The axis.
        axis: String,
    },
    /// The log has no axis of the model.
    #[error("the log has none of the model's axes")]
    NoCommonAxis,
    /// The log has another sampling period than the model.
    #[error("the model was trained at {model_ms} ms a sample, the log has {log_ms} ms")]
    OtherRate {
        /// Sampling period of the model, ms.
        model_ms: f64,
        /// Sampling period of the log, ms.
        log_ms: f64,
    },
    /// The logs have another sampling period than the machine file.
    #[error(
        "the rows of the logs are {log_ms:.4} ms apart, `sampling_period_ms` of the machine file is {file_ms}: log at that rate, or state there the one of \
         the logs; where the two are nearly alike, the clock of the time stamps runs wrong"
    )]
    OtherPeriod {
        /// Period of the logs, ms.
        log_ms: f64,
        /// Period of the machine file, ms.
        file_ms: f64,
    },
    /// The logs move an axis many times as fast as the machine file allows.
    #[error(
        "axis {axis}: the logs move it at up to {reached:.4} {unit}, the machine file allows {allowed}: one of the two is in another unit, as \
         degrees for radians or mm for inches (--columns {axis}:deg, {axis}:inch), or of another machine"
    )]
    OtherSpeed {
        /// The axis.
        axis: String,
        /// Largest speed in the logs, mm/s or rad/s.
        reached: f64,
        /// Largest speed by the machine file, the same unit.
        allowed: f64,
        /// The unit.
        unit: &'static str,
    },
    /// The curve for tuning ILC cannot be planned on the machine.
    #[error("the curve on which ILC is tuned does not fit the machine; give its gain and cut-off with --gain and --low-pass")]
    TuningCurve(#[source] Box<Error>),
    /// A program whose control does not plan its time cannot be compared as one.
    #[error(
        "{0}: it states the times of its lines, so that as a program it runs as the reference does; compare it without --programs"
    )]
    NotReplanned(String),
    /// A method made no run.
    #[error("{0} made no run")]
    NoRun(&'static str),
    /// The progress callback cancelled the job.
    #[error("cancelled")]
    Cancelled,
    /// Error of the G-code crate.
    #[error(transparent)]
    Gcode(#[from] GcodeError),
    /// Error of curves, trajectories or plans.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// Error of a machine or its description.
    #[error(transparent)]
    Machine(#[from] MachineError),
    /// Error of a compensation law.
    #[error(transparent)]
    Compensation(#[from] CompensationError),
    /// Error of a log or reference.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// Error of a model.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// Error of a fit.
    #[error(transparent)]
    Training(#[from] TrainingError),
}

impl Error {
    /// Error with the reasons for which `report` refuses the logs.
    pub(crate) fn unfit(report: &datasets::Report) -> Self {
        Self::UnfitLogs { reasons: report.of(Severity::Refuse).map(ToString::to_string).collect() }
    }
}
