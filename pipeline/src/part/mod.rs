//! A part program as a planned path.

mod faults;
mod fixed;
mod offsets;
mod taper;
mod tool_path;

use std::collections::BTreeMap;

use gcode::{
    Dialect, FeedMode, GcodeError, Move, MoveKind, Options, PassiveCodes, PathMode, Program, Shiftable, ToolLength, Toolpath,
};
use machine::ProgramWords;
use motion::{Limits, MotionError, Plan, PlanSettings, ToolPath, Trajectory, Vec6};

use crate::error::{Error, Result};
use crate::setup::Setup;

use faults::{on_line, on_move};
use tool_path::{offset_of, pieces, words_of};

pub use faults::render;
pub use offsets::{GivenOffset, Placement, WorkOffsets};
pub use taper::taper;
pub use tool_path::{POINT_MM, coordinates, stated};

/// How a program is read and planned.
#[derive(Debug, Clone, PartialEq)]
pub struct ReadSettings {
    /// Dialect of the program; the setup's, or found from the program, when `None`.
    pub dialect: Option<Dialect>,
    /// M codes with which the machine changes nothing of path or frame.
    pub passive: PassiveCodes,
    /// Whether the control skips blocks that begin with `/`; `None` leaves them and what depends on them alone.
    pub block_delete: Option<bool>,
    /// Machine minus program coordinates, mm: beside those of the setup, or in their place.
    pub work_offsets: Vec<GivenOffset>,
    /// Length of the tool, mm, where the offsets' Z is without it.
    pub tool_length_mm: f64,
    /// Whether coordinate systems without an offset lie at 0,0,0, as on a simulated machine.
    pub at_zero: bool,
    /// How far the control may round corners off where the program does not say so, mm; 0 plans a stop at every corner.
    pub corner_tolerance_mm: f64,
}

impl Default for ReadSettings {
    fn default() -> Self {
        Self {
            dialect: None,
            passive: PassiveCodes::default(),
            block_delete: None,
            work_offsets: Vec::new(),
            tool_length_mm: 0.0,
            at_zero: false,
            corner_tolerance_mm: 0.002,
        }
    }
}

/// A part program, read and planned.
#[derive(Debug)]
pub struct Part {
    /// File name, for messages.
    pub name: String,
    /// The program's bytes, blocks and words.
    pub program: Program,
    /// How it was read.
    pub options: Options,
    /// Its moves.
    pub toolpath: Toolpath,
    /// The path in machine coordinates; program coordinates plus the work offset.
    pub path: ToolPath,
    /// For every piece of the path the move that it stands for; `None` for a way that the program does not state (from a tool
    /// change, from a home position).
    pub owners: Vec<Option<usize>>,
    /// Where its coordinate systems lie on the machine.
    pub placement: Placement,
    /// What its words mean while it does not say so itself.
    pub words: ProgramWords,
    /// What the programmed feed of every move is multiplied by.
    pub feed_factors: Vec<f64>,
    /// How it is planned.
    pub settings: PlanSettings,
    /// What the axes and the path are allowed to do.
    pub limits: Limits,
    /// Positions over time.
    pub plan: Plan,
    /// Whether compensated stretches state a path mode of their own, in which the control goes on through points that are put in.
    pub states_path: bool,
    /// What the control commanded when it ran the program, one sample each of the plan, where a recorded run says so.
    pub command: Option<Trajectory>,
}

/// Time over which a correction begins and ends beside moves that must not be shifted, s.
pub const FADE_S: f64 = 0.03;

/// Share of the time of all feed moves that may go without a stated time before the program counts as one whose time the control plans.
const UNTIMED: f64 = 0.05;

impl Part {
    /// Interprets and plans the bytes of a program for a setup.
    ///
    /// # Errors
    /// [`Error::Program`] when the program holds a feed move that cannot be predicted, with its line; when it moves none of the machine's
    /// axes at a feed; when a tool length is given on a machine that turns tool or part, whose description holds it.
    pub fn read(name: &str, bytes: impl Into<Vec<u8>>, setup: &Setup, settings: &ReadSettings) -> Result<Self> {
        Self::of(name, gcode::parse(bytes), setup, settings)
    }

    /// As [`Part::read`], of a program that is parsed already.
    ///
    /// # Errors
    /// As [`Part::read`].
    pub fn of(name: &str, program: Program, setup: &Setup, settings: &ReadSettings) -> Result<Self> {
        if setup.kinematics.has_rotary_axes() && settings.tool_length_mm != 0.0 {
            return Err(Error::ToolLengthOfTurningMachine);
        }
        let dialect = settings.dialect.or(setup.dialect).unwrap_or_else(|| Dialect::detect(&program));
        let options = Options { passive: settings.passive, block_delete: settings.block_delete, ..dialect.into() };
        let given = WorkOffsets::new(&settings.work_offsets, &setup.work_offsets, settings.tool_length_mm);
        let offsets = if settings.at_zero { given.or_zero() } else { given };
        let plan = PlanSettings { corner_tolerance_mm: settings.corner_tolerance_mm, ..setup.plan_settings() };
        Self::planned(name, program, options, &offsets, setup, &plan)
    }

    /// Interprets and plans a program with everything stated.
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
        let toolpath = gcode::interpret(&program, &options).map_err(|error| match error {
            GcodeError::Refused { diagnostics } => {
                let text = render(&diagnostics, &program, name);
                Error::Program { diagnostics, text }
            }
            other => other.into(),
        })?;
        let placement = offsets.placement(&toolpath);
        let feed_factors = vec![1.0; toolpath.moves.len()];
        let (kinematics, words) = (&setup.kinematics, setup.words);
        let (path, owners) = pieces(&toolpath, &placement, &feed_factors, kinematics.as_ref(), words)?;
        if !toolpath.moves.iter().any(Move::is_feed) {
            return Err(Error::NoFeedMove { name: name.to_owned() });
        }
        if owners.is_empty() {
            let axes = kinematics.axes().iter().map(|axis| axis.name.clone()).collect();
            return Err(Error::NoAxisMoved { name: name.to_owned(), axes });
        }
        let plan = motion::plan(&path, kinematics, &setup.limits, settings)
            .map_err(|error| on_line(error, &owners, &toolpath, &program, name))?;
        Ok(Self {
            name: name.to_owned(),
            program,
            options,
            toolpath,
            path,
            owners,
            placement,
            words,
            feed_factors,
            settings: settings.clone(),
            limits: setup.limits.clone(),
            plan,
            states_path: false,
            command: None,
        })
    }

    /// The bytes of another version of the program, its moves a little elsewhere, planned as this one is.
    ///
    /// # Errors
    /// As [`Part::read`].
    pub fn replanned(&self, bytes: Vec<u8>) -> Result<Self> {
        let program = gcode::parse(bytes);
        let setup = Setup {
            name: String::new(),
            kinematics: self.plan.desired.kinematics().clone(),
            words: self.words,
            limits: self.limits.clone(),
            period_s: self.settings.period_s,
            plan: self.settings.clone(),
            controller: None,
            dialect: None,
            travel: Vec::new(),
            work_offsets: BTreeMap::new(),
        };
        Self::planned(&self.name, program, self.options, self.placement.offsets(), &setup, &self.settings)
    }

    /// The same program with its feeds multiplied by `factors`, one a move, and planned anew.
    ///
    /// # Errors
    /// When it cannot be planned.
    pub fn with_feeds(self, factors: Vec<f64>) -> Result<Self> {
        let kinematics = self.plan.desired.kinematics();
        let (path, owners) = pieces(&self.toolpath, &self.placement, &factors, kinematics.as_ref(), self.words)?;
        let plan = motion::plan(&path, kinematics, &self.limits, &self.settings)
            .map_err(|error| on_line(error, &owners, &self.toolpath, &self.program, &self.name))?;
        Ok(Self { path, owners, plan, feed_factors: factors, command: None, ..self })
    }

    /// What the control commands when it is given `reference`: this, off by as much as in the recorded run, where there is one.
    ///
    /// # Errors
    /// When `reference` does not have the plan's samples.
    pub fn commanded(&self, reference: &Trajectory) -> Result<Trajectory, MotionError> {
        let Some(command) = &self.command else { return Ok(reference.clone()) };
        let shifts = reference.tracking_error(self.plan.desired.trajectory())?;
        let columns = command.columns().iter().zip(shifts);
        command.with_columns(columns.map(|(at, shift)| at.iter().zip(shift).map(|(at, shift)| at + shift).collect()).collect())
    }

    /// The move that a sample of the plan belongs to.
    #[must_use]
    pub fn move_at(&self, sample: usize) -> Option<usize> {
        self.owners.get(self.plan.samples.get(sample)?.piece).copied().flatten()
    }

    /// Whether a sample of the plan belongs to a move that may be compensated.
    #[must_use]
    pub fn shiftable_at(&self, sample: usize) -> bool {
        self.move_at(sample).is_some_and(|index| self.is_shiftable(&self.toolpath.moves[index]))
    }

    /// Whether a move may be compensated: a feed move whose geometry is known; one that turns axes only on a machine whose kinematics says
    /// what that does to the tool.
    #[must_use]
    pub fn is_shiftable(&self, of: &Move) -> bool {
        let turned = of.start.nominal_rotary_rad() != of.end.nominal_rotary_rad();
        // Tip control is about rotary axes: which, a machine without any does not say.
        let tip = self.toolpath.modal(of).tool_length == ToolLength::TipControl;
        let stops_within = self.stops_exactly(of) && matches!(of.kind, MoveKind::Arc(_));
        let known = of.shiftable == Shiftable::Yes && !stops_within;
        known && of.is_feed() && (!(turned || tip) || self.plan.desired.kinematics().has_rotary_axes())
    }

    /// Whether the control stops at the end of every line that stands for a move (G9, G61.1) or goes through it exactly (G61, G64 P0), so that points that are
    /// put in would stop it too.
    #[must_use]
    pub fn stops_exactly(&self, of: &Move) -> bool {
        match self.toolpath.modal(of).path {
            PathMode::ExactStop => true,
            PathMode::ExactPath => !self.states_path,
            PathMode::Continuous { tolerance_mm, .. } => tolerance_mm == Some(0.0) && !self.states_path,
            PathMode::Default => false,
        }
    }

    /// Whether feed moves state their time (G93) but for a small share of it, such as an approach.
    #[must_use]
    pub fn states_times(&self) -> bool {
        let moves = (0..self.plan.samples.len()).filter_map(|k| self.move_at(k)).map(|index| &self.toolpath.moves[index]);
        let (mut stated, mut all) = (0, 0);
        for step in moves.filter(|step| step.is_feed()) {
            all += 1;
            stated += usize::from(self.toolpath.modal(step).feed_mode == FeedMode::InverseTime);
        }
        (all - stated) as f64 <= UNTIMED * all as f64
    }

    /// What the words of a move mean.
    #[must_use]
    pub fn words_of(&self, of: &Move) -> ProgramWords {
        words_of(&self.toolpath, of, self.words)
    }

    /// Whether a sample of the plan belongs to a feed move; the nearest one does for a place beyond the ends.
    #[must_use]
    pub fn feeds_at(&self, sample: usize) -> bool {
        let sample = sample.min(self.plan.samples.len().saturating_sub(1));
        self.move_at(sample).is_some_and(|index| self.toolpath.moves[index].is_feed())
    }

    /// Line of the program, from 1, that a sample of the plan belongs to.
    #[must_use]
    pub fn line_at(&self, sample: usize) -> Option<usize> {
        self.move_at(sample).map(|index| self.toolpath.moves[index].block as usize + 1)
    }

    /// Machine minus program coordinates of a move, mm and rad.
    #[must_use]
    pub fn offset_of(&self, of: &Move) -> Vec6 {
        offset_of(&self.placement, &self.toolpath, of)
    }

    /// A refusal of what the plan does at a sample, shown at its line.
    #[must_use]
    pub fn refused_at(&self, sample: usize, what: String) -> Error {
        let owner = self.plan.samples.get(sample).and_then(|at| self.owners[at.piece..].iter().flatten().next().copied());
        match owner {
            Some(owner) => on_move(&self.toolpath, owner, &self.program, &self.name, what),
            None => Error::Program { diagnostics: Vec::new(), text: format!("{}: {what}", self.name) },
        }
    }

    /// How much of a correction every sample may take: 1 on moves that may be compensated, 0 elsewhere, with a fade at both
    /// ends of each segment so that it begins and ends exactly where the program says.
    #[must_use]
    pub fn weights(&self) -> Vec<f64> {
        let shiftable: Vec<bool> = (0..self.plan.samples.len()).map(|k| self.shiftable_at(k)).collect();
        taper(&shiftable, FADE_S / self.plan.desired.trajectory().period_s())
    }
}
