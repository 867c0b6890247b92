//! A section of a long program as a part of its own.

use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;

use gcode::{Options, Program, Resume, Toolpath, WorkOffset};
use motion::{PlanSettings, Vec6};

use super::faults::refused;
use super::offsets::Placement;
use super::{Part, Read, ReadSettings, named_axes};
use crate::error::Result;
use crate::setup::Setup;

/// What is known of a whole program before its moves are read.
#[derive(Debug, Clone)]
pub struct Whole {
    /// File name, for messages.
    pub name: String,
    /// Bytes, blocks and words.
    pub program: Arc<Program>,
    /// Options of the interpreter.
    pub options: Options,
    /// Planner settings.
    pub settings: PlanSettings,
    /// Which of X, Y, Z, A, B, C it names anywhere.
    pub named_axes: [bool; 6],
    /// Whether all coordinates are without a decimal point.
    pub is_integer: bool,
}

impl Whole {
    /// The program on a setup.
    ///
    /// # Errors
    /// Where the settings do not fit, or coordinates can be read in two ways.
    pub fn new(name: &str, program: Arc<Program>, setup: &Setup, settings: &ReadSettings) -> Result<Self> {
        let options = settings.options(name, &program, setup)?;
        let (named_axes, is_integer) = (named_axes(&program), gcode::is_integer_program(&program));
        let settings = setup.program_plan(settings.corner_tolerance_mm);
        Ok(Self { name: name.to_owned(), program, options, settings, named_axes, is_integer })
    }

    /// Placement of the coordinate systems in which it cuts.
    #[must_use]
    pub fn placement(&self, systems: &BTreeSet<WorkOffset>, setup: &Setup, settings: &ReadSettings) -> Placement {
        settings.offsets(setup).placement_of(&systems.iter().copied().collect::<Vec<_>>())
    }
}

/// A section of a program: its core, whose moves are written, and the moves before and after it, which bring the axes into the state that they
/// are in when the whole program runs.
#[derive(Debug, Clone)]
pub struct Section {
    /// What is known of the whole program.
    pub whole: Arc<Whole>,
    /// Blocks of core and surroundings.
    pub blocks: Range<usize>,
    /// State before the first of them.
    pub start: Resume,
    /// Blocks of the core.
    pub core: Range<usize>,
    /// State before the first of these.
    pub core_start: Resume,
    /// Position from which the machine comes, machine coordinates in mm and rad: every axis moves to the first block in the direction of its
    /// last motion, so that backlash and friction are on the side on which they are in the whole program.
    pub before: Option<Vec6>,
}

impl Section {
    /// Reads and plans the section.
    ///
    /// # Errors
    /// As [`Part::read`].
    pub fn part(self, placement: &Placement, setup: &Setup) -> Result<Part> {
        let whole = Arc::clone(&self.whole);
        let toolpath = gcode::interpret_part(&whole.program, self.blocks.clone(), &whole.options, &self.start)
            .map_err(|error| refused(error, &whole.program, &whole.name))?;
        let read = Read {
            program: Arc::clone(&whole.program),
            section: Some(self),
            options: whole.options,
            toolpath,
            placement: placement.clone(),
        };
        Part::on_path(&whole.name, read, setup, &whole.settings)
    }

    /// Indices of the moves of the core.
    #[must_use]
    pub fn core_moves(&self, part: &Part) -> Range<usize> {
        let at = |block: usize| part.toolpath.moves.partition_point(|of| (of.block as usize) < block);
        at(self.core.start)..at(self.core.end)
    }

    /// Samples of the plan that belong to the core; those of a rapid that the program does not state belong to the move before it.
    #[must_use]
    pub fn core_samples(&self, part: &Part) -> Range<usize> {
        let moves = self.core_moves(part);
        let mut next = part.owners.len();
        let mut first_at = |wanted: usize| {
            while next > 0 && part.owners[..next].iter().rev().flatten().next().is_some_and(|owner| *owner >= wanted) {
                next -= 1;
            }
            part.plan.samples.partition_point(|sample| sample.piece < next)
        };
        let end = if self.core.end >= self.blocks.end { part.plan.samples.len() } else { first_at(moves.end) };
        let start = if self.core.start <= self.blocks.start { 0 } else { first_at(moves.start) };
        start..end
    }

    /// Moves of the core, read from its bytes.
    ///
    /// # Errors
    /// As [`gcode::interpret_part`].
    pub(crate) fn read_core(&self, part: &Part, bytes: Vec<u8>) -> Result<Toolpath> {
        let program = gcode::parse_in(bytes, part.program.language());
        Ok(gcode::interpret_part(&program, 0..program.blocks().len(), &part.options, &self.core_start)?)
    }

    /// Another version of the section of `part`, from its bytes.
    pub(super) fn reread(&self, part: &Part, bytes: Vec<u8>) -> Result<Read> {
        let program = gcode::parse_in(bytes, part.program.language());
        let blocks = 0..program.blocks().len();
        let toolpath = gcode::interpret_part(&program, blocks.clone(), &part.options, &self.start)
            .map_err(|error| refused(error, &program, &part.name))?;
        let section = Self { core: blocks.clone(), blocks, core_start: self.start.clone(), ..self.clone() };
        let placement = part.placement.clone();
        Ok(Read { program: Arc::new(program), section: Some(section), options: part.options, toolpath, placement })
    }
}
