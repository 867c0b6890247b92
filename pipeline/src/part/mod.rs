//! A part program as a planned path.
//!
//! [`Part::read`] interprets the blocks of a program, places them on the machine by their work offsets, and plans the
//! feed profile. [`Part::is_shiftable`] states which moves may be compensated.

mod borders;
mod faults;
mod fixed;
mod missing;
mod moves;
mod offsets;
mod recording;
mod section;
mod settings;
mod subprograms;
mod taper;
mod tool_path;

use std::collections::BTreeMap;
use std::sync::Arc;

use gcode::{Edits, Feed, Files, Fixed, Move, Options, Program, Shiftable, Toolpath};
use machine::ProgramWords;
use motion::{Limits, MotionError, Plan, PlanSettings, ToolPath, Trajectory};

use crate::error::{Error, Result};
use crate::setup::Setup;

pub(crate) use faults::refused;
use faults::{on_line, on_move, with_warnings};
pub(crate) use missing::MissingAxes;
use tool_path::pieces;

pub use borders::PathSegment;
pub use faults::render;
pub use fixed::FixedMoves;
pub use offsets::{GivenOffset, Placement, WorkOffsets};
pub use recording::Recording;
pub use section::{Section, Whole};
pub use settings::ReadSettings;
pub use subprograms::Subprograms;
pub use taper::taper;
pub use tool_path::{POINT_MM, coordinates, stated};

/// A part program, interpreted and planned.
#[derive(Debug)]
pub struct Part {
    /// File name, for messages.
    pub name: String,
    /// Bytes, blocks and words of the program.
    pub program: Arc<Program>,
    /// The section that the part holds of it; `None` for the whole.
    pub section: Option<Section>,
    /// Options of the interpreter.
    pub options: Options,
    /// Moves of the program.
    pub toolpath: Toolpath,
    /// Path in machine coordinates: program coordinates plus work offset.
    pub path: ToolPath,
    /// Index of the move of every path piece; `None` for a piece that the program does not state, such as the return
    /// from a tool change or from a home position.
    pub owners: Vec<Option<usize>>,
    /// Work offsets of the program on the machine.
    pub placement: Placement,
    /// Default meaning of the words: axis positions or tool tip coordinates.
    pub words: ProgramWords,
    /// Feed factor of every move.
    pub feed_factors: Vec<f64>,
    /// Planner settings.
    pub settings: PlanSettings,
    /// Limits of axes and path.
    pub limits: Limits,
    /// Planned positions over time.
    pub plan: Plan,
    /// Whether compensated segments state a path mode of their own, in which the control does not stop at added points.
    pub states_path: bool,
    /// Whether the lines of compensated segments state their times (G93).
    pub states_line_times: bool,
    /// Command of the control, one sample for each sample of the plan, where it is not the plan itself: that of a recorded run, or the
    /// filtered plan.
    pub command: Option<Trajectory>,
    /// The plan, where `plan` and `command` are those of a recorded run.
    pub recording: Option<Box<Recording>>,
}

/// What was read of a program, before it is planned.
struct Read {
    program: Arc<Program>,
    section: Option<Section>,
    options: Options,
    toolpath: Toolpath,
    placement: Placement,
}

/// Whether the feed of a move is that of the rotary axes.
pub(crate) fn turns_at_feed(of: &Move) -> bool {
    matches!(of.feed, Some(Feed::Angular { .. }))
}

fn named_axes(program: &Program) -> [bool; 6] {
    b"XYZABC".map(|letter| program.words().iter().any(|word| word.is(letter)))
}

/// Refuses content of another kind.
fn known(name: &str, program: &Program) -> Result<()> {
    gcode::recognise(program).map_or(Ok(()), |kind| Err(Error::NotAProgram { name: name.to_owned(), kind }))
}

/// Length of the taper of a correction beside moves that are not compensated, s.
pub const TAPER_S: f64 = 0.03;

impl Part {
    /// Interprets and plans a program for a setup.
    ///
    /// # Errors
    /// [`Error::NotAProgram`] for content of another kind; [`Error::Program`] with the line of a feed move that cannot be predicted; [`Error::NoFeedMove`] or
    /// [`Error::NoAxisMoved`] when nothing is planned; [`Error::ToolLengthOfTurningMachine`] when a tool length is
    /// given for a machine with rotary axes, whose description holds it.
    pub fn read(name: &str, bytes: impl Into<Vec<u8>>, setup: &Setup, settings: &ReadSettings) -> Result<Self> {
        Self::of(name, gcode::parse(bytes), setup, settings)
    }

    /// Same as [`Part::read`], for a parsed program.
    ///
    /// # Errors
    /// As [`Part::read`].
    pub fn of(name: &str, program: Program, setup: &Setup, settings: &ReadSettings) -> Result<Self> {
        // A file that is no such program gets no questions about its numbers.
        known(name, &program)?;
        let options = settings.options(name, &program, setup)?;
        let offsets = settings.offsets(setup);
        let plan = setup.program_plan(settings.corner_tolerance_mm);
        let files = |file: &str| settings.subprograms.read(file);
        if !settings.expand {
            return Self::evaluated(name, program, options, &files, &offsets, setup, &plan);
        }
        let flat = gcode::expand(&program, &options, &files).map_err(|error| refused(error, &program, name))?;
        let changed = flat != program.bytes();
        let shown = if changed { format!("{name} (expanded)") } else { name.to_owned() };
        Self::evaluated(&shown, gcode::parse(flat), options, &files, &offsets, setup, &plan)
    }

    /// Interprets and plans a program with explicit options, work offsets and planner settings.
    ///
    /// # Errors
    /// As [`Part::read`].
    pub fn planned(
        name: &str,
        program: Program,
        options: Options,
        offsets: &WorkOffsets,
        setup: &Setup,
        settings: &PlanSettings,
    ) -> Result<Self> {
        Self::evaluated(name, program, options, &|_| None, offsets, setup, settings)
    }

    /// [`Part::planned`] with subprograms from `files`.
    fn evaluated(
        name: &str,
        mut program: Program,
        options: Options,
        files: Files<'_>,
        offsets: &WorkOffsets,
        setup: &Setup,
        settings: &PlanSettings,
    ) -> Result<Self> {
        known(name, &program)?;
        gcode::evaluate(&mut program, &options, files).map_err(|error| refused(error, &program, name))?;
        let mut toolpath = gcode::interpret(&program, &options).map_err(|error| refused(error, &program, name))?;
        let mut missing = MissingAxes::of(setup.kinematics.as_ref());
        toolpath.moves.iter().for_each(|step| missing.note(step));
        toolpath.warnings.extend(missing.warnings(&program));
        let placement = offsets.placement(&toolpath);
        let read = Read { program: Arc::new(program), section: None, options, toolpath, placement };
        Self::on_path(name, read, setup, settings)
    }

    /// Plans the moves of a program, or of a section of it.
    fn on_path(name: &str, read: Read, setup: &Setup, settings: &PlanSettings) -> Result<Self> {
        let Read { program, section, options, toolpath, placement } = read;
        let feed_factors = vec![1.0; toolpath.moves.len()];
        let (kinematics, words) = (&setup.kinematics, setup.words);
        let before = section.as_ref().and_then(|section| section.before);
        let (path, owners) = pieces(&toolpath, &placement, &feed_factors, kinematics.as_ref(), words, before)?;
        if !toolpath.moves.iter().any(Move::is_feed) {
            return Err(Error::NoFeedMove { name: name.to_owned() });
        }
        let unknown = |of: &Move| match of.shiftable {
            Shiftable::No(Fixed::RunTime) => Some("only the running program knows where this move leads"),
            Shiftable::No(Fixed::NotUnderstood) => {
                Some("a code before this move has an effect on path or frame that is not known")
            }
            Shiftable::No(Fixed::UnknownStart) if !owners.is_empty() => Some("the program does not say where this move starts"),
            _ => None,
        };
        let first_unknown =
            || toolpath.moves.iter().enumerate().find_map(|(owner, of)| Some((owner, unknown(of).filter(|_| of.is_feed())?)));
        let is_fed = |owner: &usize| toolpath.moves[*owner].is_feed();
        let plans_none = owners.is_empty() || section.is_none() && !owners.iter().flatten().any(is_fed);
        if let (true, Some((owner, why))) = (plans_none, first_unknown()) {
            let what = format!("{why}, and no other is planned");
            return Err(with_warnings(on_move(&toolpath, owner, &program, name, what), &toolpath, &program, name));
        }
        if owners.is_empty() {
            let axes = kinematics.axes().iter().map(|axis| axis.name.clone()).collect();
            return Err(Error::NoAxisMoved { name: name.to_owned(), axes });
        }
        let mut plan = motion::plan(&path, kinematics, &setup.limits, settings)
            .map_err(|error| on_line(error, &owners, &toolpath, &program, name))?;
        Ok(Self {
            name: name.to_owned(),
            program,
            section,
            options,
            toolpath,
            path,
            owners,
            placement,
            words,
            feed_factors,
            settings: settings.clone(),
            limits: setup.limits.clone(),
            command: plan.command.take(),
            plan,
            states_path: false,
            states_line_times: false,
            recording: None,
        })
    }

    /// Bytes of the program with these edits; those of its section where it is one.
    ///
    /// # Errors
    /// As [`gcode::edit`].
    pub(crate) fn edited(&self, edits: &Edits) -> Result<Vec<u8>> {
        Ok(match &self.section {
            Some(section) => gcode::edit_blocks(&self.program, section.blocks.clone(), edits)?,
            None => gcode::edit(&self.program, edits)?,
        })
    }

    /// Plans another version of the program, given as bytes, with the settings of this part: for instance the output of
    /// [`Outcome::write`](crate::model_based_ilc::Outcome::write), to run it on a machine and measure the run against this part. The name stays.
    /// Of a section it is another version of the section.
    ///
    /// # Errors
    /// As [`Part::read`].
    pub fn replanned(&self, bytes: Vec<u8>) -> Result<Self> {
        self.planned_by(bytes, &self.limits)
    }

    /// The same by a control with other limits.
    ///
    /// # Errors
    /// As [`Part::read`].
    pub fn planned_by(&self, bytes: Vec<u8>, limits: &Limits) -> Result<Self> {
        let setup = Setup {
            name: String::new(),
            kinematics: self.plan.desired.kinematics().clone(),
            words: self.words,
            limits: limits.clone(),
            period_s: self.settings.period_s,
            plan: self.settings.clone(),
            states_corners: true,
            controller: None,
            dialect: None,
            decimal_point: None,
            travel: Vec::new(),
            work_offsets: BTreeMap::new(),
        };
        if let Some(section) = &self.section {
            let read = section.reread(self, bytes)?;
            return Self::on_path(&self.name, read, &setup, &self.settings);
        }
        let program = gcode::parse(bytes);
        let (offsets, files) = (self.placement.offsets(), |file: &str| self.subprogram(file));
        Self::evaluated(&self.name, program, self.options, &files, offsets, &setup, &self.settings)
    }

    /// Content of a subprogram file that the program called.
    pub(crate) fn subprogram(&self, name: &str) -> Option<Vec<u8>> {
        self.program.subprogram_file(name).map(<[u8]>::to_vec)
    }

    /// Replans the program with its feeds multiplied by `factors`, one for each move.
    ///
    /// # Errors
    /// When the program cannot be planned.
    pub fn with_feeds(self, factors: Vec<f64>) -> Result<Self> {
        let kinematics = self.plan.desired.kinematics();
        let before = self.section.as_ref().and_then(|section| section.before);
        let (path, owners) = pieces(&self.toolpath, &self.placement, &factors, kinematics.as_ref(), self.words, before)?;
        let mut plan = motion::plan(&path, kinematics, &self.limits, &self.settings)
            .map_err(|error| on_line(error, &owners, &self.toolpath, &self.program, &self.name))?;
        let command = plan.command.take();
        Ok(Self { path, owners, plan, feed_factors: factors, command, recording: None, ..self })
    }

    /// Command of the control for `reference`. Where the control commands something else than its plan, that difference is added.
    ///
    /// # Errors
    /// When the samples of `reference` are not those of the plan.
    pub fn commanded(&self, reference: &Trajectory) -> Result<Trajectory, MotionError> {
        let Some(command) = &self.command else { return Ok(reference.clone()) };
        let shifts = reference.tracking_error(self.plan.desired.trajectory())?;
        let columns = command.columns().iter().zip(shifts);
        command.with_columns(columns.map(|(at, shift)| at.iter().zip(shift).map(|(at, shift)| at + shift).collect()).collect())
    }
}
