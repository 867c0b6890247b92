//! Reading of a long program in parts: moves are handed over as they are read, and reading can begin again between two blocks.

use std::ops::Range;

use super::assumed_centres;
use super::codes::Motion;
use super::gather::Gathered;
use super::shifts::Shifts;
use super::state::{FeedWord, Interpreter, StatedFrame, Whole};
use crate::diagnostic::Diagnostic;
use crate::dialect::Options;
use crate::error::GcodeError;
use crate::evaluate::is_plain;
use crate::execution::Ran;
use crate::modal::{Distance, Modal};
use crate::position::Position;
use crate::program::{Language, Program};
use crate::toolpath::Toolpath;

/// What the blocks after a place in a program depend on: modal codes, position, coordinate system and feed.
#[derive(Clone, Debug)]
pub struct Resume {
    modal: Modal,
    motion: Option<Motion>,
    position: Position,
    whole: Whole,
    shifts: Shifts,
    feed: FeedWord,
    units_stated: bool,
    arc_distance_stated: bool,
    stated: StatedFrame,
    tool_offset_stated: bool,
    content_seen: bool,
}

impl Resume {
    /// Whether coordinates are absolute (G90) from here on.
    #[must_use]
    pub fn is_absolute(&self) -> bool {
        self.modal.distance == Distance::Absolute
    }
}

/// A program that is read part by part. Only the moves of the present part are held.
pub struct Reader<'a> {
    interpreter: Interpreter<'a>,
    words: Gathered,
    next: usize,
    is_done: bool,
    /// Whether arc centres are read as absolute because they fit no circles otherwise.
    absolute_centres: bool,
}

impl<'a> Reader<'a> {
    /// A reader at the first block. `None` for programs that run in another order than that of their lines, or in another language than
    /// RS-274: parameters, branches and subprograms have to be written out first ([`expand`](crate::expand)).
    #[must_use]
    pub fn new(program: &'a Program, options: &'a Options) -> Option<Self> {
        let in_order = program.language() == Language::Rs274
            && options.dialect.language_of(program).is_none()
            && program.execution().is_none()
            && program.is_whole()
            && is_plain(program);
        let interpreter = || Interpreter::new(program, options, assumed_centres(options));
        in_order.then(|| Self {
            interpreter: interpreter(),
            words: Gathered::default(),
            next: 0,
            is_done: false,
            absolute_centres: false,
        })
    }

    /// A reader at the first block that takes arc centres as absolute, for a program whose arcs fit no circle otherwise ([`Reader::finish`]).
    #[must_use]
    pub fn with_absolute_centres(program: &'a Program, options: &'a Options) -> Option<Self> {
        let interpreter = Interpreter::new(program, options, Distance::Absolute);
        Some(Self { interpreter, absolute_centres: true, ..Self::new(program, options)? })
    }

    /// Index of the next block.
    #[must_use]
    pub fn block(&self) -> usize {
        self.next
    }

    /// The moves of the next `blocks` blocks; `None` at the end of the program. Their diagnostics come with [`Reader::finish`].
    pub fn read(&mut self, blocks: usize) -> Option<Toolpath> {
        if self.is_done {
            return None;
        }
        for _ in 0..blocks {
            self.is_done = !self.interpreter.read_step(self.next, &mut self.words);
            self.next += 1;
            if self.is_done {
                break;
            }
        }
        let (moves, modals) = (std::mem::take(&mut self.interpreter.moves), std::mem::take(&mut self.interpreter.modals));
        Some(Toolpath { moves, modals, warnings: Vec::new() })
    }

    /// The present state, whether or not reading can be resumed from it: of use before the first block.
    #[must_use]
    pub fn state(&self) -> Resume {
        resume_of(&self.interpreter)
    }

    /// What the next blocks depend on. `None` where that is more than modal codes and a known position: in canned cycles, corners, open
    /// sections, transformed coordinates, and after blocks that may be skipped.
    #[must_use]
    pub fn resume(&self) -> Option<Resume> {
        let at = &self.interpreter;
        let feed_known = !matches!(at.feed, FeedWord::Unpredictable { .. });
        let unclear = at.optional_feed || at.unclear_feed || at.optional_motion || at.optional_since_code;
        let open = at.cycle.is_some()
            || at.sections.is_open()
            || at.has_doubts()
            || at.in_corner
            || at.corner_moves > 0
            || at.rounds_corners
            || at.inputs_data
            || at.mirrored != 0
            || at.unsettled.contains(&true);
        let plain = !self.is_done && at.ran == Ran::Once && !at.shared_since && at.position.xyz_mm().is_some();
        (plain && feed_known && !unclear && !open).then(|| resume_of(at))
    }

    /// The warnings of the blocks read. `None` where arcs fit no circle: unless [with absolute centres](Reader::with_absolute_centres), which only
    /// the whole program can tell.
    ///
    /// # Errors
    /// As [`interpret`](crate::interpret).
    pub fn finish(mut self) -> Result<Option<Vec<Diagnostic>>, GcodeError> {
        if self.absolute_centres {
            if self.interpreter.arc_faults.any {
                return Ok(None);
            }
            self.interpreter.warn_of_absolute_centres();
        } else if self.interpreter.doubts_centres() {
            return Ok(None);
        }
        self.interpreter.finish().map(|read| Some(read.warnings))
    }
}

fn resume_of(at: &Interpreter<'_>) -> Resume {
    Resume {
        modal: at.modal,
        motion: at.motion,
        position: at.position,
        whole: at.whole.clone(),
        shifts: at.shifts,
        feed: at.feed,
        units_stated: at.units_stated,
        arc_distance_stated: at.arc_distance_stated,
        stated: at.stated,
        tool_offset_stated: at.tool_offset_stated,
        content_seen: at.content_seen,
    }
}

/// The moves of some blocks of a program, read from the state `from` before the first of them.
///
/// # Errors
/// As [`interpret`](crate::interpret).
pub fn interpret_part(program: &Program, blocks: Range<usize>, options: &Options, from: &Resume) -> Result<Toolpath, GcodeError> {
    let mut interpreter = Interpreter::with(program, options, from.modal.arc_distance, from.whole.clone());
    let from = from.clone();
    interpreter.modal = from.modal;
    interpreter.motion = from.motion;
    interpreter.position = from.position;
    interpreter.shifts = from.shifts;
    interpreter.feed = from.feed;
    interpreter.units_stated = from.units_stated;
    interpreter.arc_distance_stated = from.arc_distance_stated;
    interpreter.stated = from.stated;
    interpreter.tool_offset_stated = from.tool_offset_stated;
    interpreter.content_seen = from.content_seen;
    interpreter.block = blocks.start;
    let mut words = Gathered::default();
    for block in blocks {
        if !interpreter.read_step(block, &mut words) {
            break;
        }
    }
    interpreter.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Dialect, interpret, parse};

    const PROGRAM: &str = "%\nG21 G90 G17\nG0 X0 Y0 Z5\nG1 Z0 F300\nX10 F600\nG3 X20 Y10 I0 J10\nG1 X5\nG91\nX-2 Y1\nX-2 Y1\nG90\n\
        G81 X0 Y0 Z-3 R1\nX4\nG80\nG68 X1 Y2 R30.\nG0 X0 Y0 Z5\nG1 Z0\nX9\nG2 X19 R5\nG1 X0\nG69\nG0 X5 Y2\nG1 Z0\nG2 X0 Y0 R40\nM30\n%\nG1 X99\n";

    #[test]
    fn parts_hold_the_moves_of_the_whole_program_wherever_it_is_cut() {
        let (program, options) = (parse(PROGRAM), Options::from(Dialect::Fanuc));
        let whole = interpret(&program, &options).unwrap();
        let mut resumed = 0;
        for cut in 1..program.blocks().len() {
            let mut reader = Reader::new(&program, &options).unwrap();
            let mut moves = reader.read(cut).unwrap().moves;
            let (count, state) = (moves.len(), reader.resume());
            while let Some(part) = reader.read(2) {
                moves.extend(part.moves);
            }
            let places = |moves: &[crate::Move]| -> Vec<_> {
                moves.iter().map(|of| (of.block, of.start, of.end, of.kind, of.feed)).collect()
            };
            assert_eq!(places(&moves), places(&whole.moves), "cut before block {cut}");
            assert_eq!(reader.finish().unwrap().unwrap().len(), whole.warnings.len());
            let Some(state) = state else { continue };
            resumed += 1;
            let rest = interpret_part(&program, cut..program.blocks().len(), &options, &state).unwrap();
            assert_eq!(places(&rest.moves), places(&whole.moves[count..]), "resumed before block {cut}");
            let modals =
                |path: &Toolpath, from: usize| -> Vec<Modal> { path.moves[from..].iter().map(|of| *path.modal(of)).collect() };
            assert_eq!(modals(&rest, 0), modals(&whole, count));
        }
        // Within the cycle and before the position is known, nothing can be resumed.
        assert!((8..program.blocks().len() - 4).contains(&resumed), "{resumed}");
    }

    #[test]
    fn programs_that_run_in_another_order_are_not_read_in_parts() {
        let options = Options::from(Dialect::LinuxCnc);
        for text in ["#1=3\nG1 X#1 F100\n", "o1 sub\nG1 X1 F100\no1 endsub\no1 call\n", "0 BEGIN PGM A MM\n1 L X+1 F100\n"] {
            assert!(Reader::new(&parse(text), &options).is_none(), "{text}");
        }
        // Absolute arc centres that nothing states.
        let options = Options::from(Dialect::Fanuc);
        let absolute = parse("G21 G90\nG0 X13 Y5 Z0\nG3 X5 Y13 I5 J5 F300\nM2\n");
        let mut reader = Reader::new(&absolute, &options).unwrap();
        while reader.read(10).is_some() {}
        assert!(reader.finish().unwrap().is_none());
        let mut reader = Reader::with_absolute_centres(&absolute, &options).unwrap();
        let mut moves = Vec::new();
        while let Some(part) = reader.read(1) {
            moves.extend(part.moves);
        }
        let whole = interpret(&absolute, &options).unwrap();
        assert_eq!(moves, whole.moves);
        let messages = |warnings: &[Diagnostic]| warnings.iter().map(|warning| warning.message.clone()).collect::<Vec<_>>();
        assert_eq!(messages(&reader.finish().unwrap().unwrap()), messages(&whole.warnings));
        // Arcs that are circles in neither reading.
        let neither = parse("G21 G90\nG0 X13 Y5 Z0\nG3 X5 Y13 I6 J5 F300\nM2\n");
        let mut reader = Reader::with_absolute_centres(&neither, &options).unwrap();
        while reader.read(10).is_some() {}
        assert!(reader.finish().unwrap().is_none());
    }
}
