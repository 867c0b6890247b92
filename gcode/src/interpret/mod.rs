//! The modal interpreter: reads a program block by block and tracks the tool position.

mod arc_faults;
mod arc_move;
mod calls;
mod circles;
mod classify;
mod codes;
mod conflicts;
mod doubts;
mod feed_move;
mod frames;
mod gather;
mod mirrors;
mod motion;
mod one_shots;
mod open_centres;
mod other_controls;
mod parts;
mod polar;
mod pole;
pub(crate) mod report;
mod rotations;
mod sections;
mod settings;
mod shifts;
mod sinumerik;
mod sinumerik_codes;
mod state;
mod transforms;
mod unknown;

pub use parts::{Reader, Resume, interpret_part};

use codes::{Code, Motion};
use gather::Gathered;
use state::{FeedWord, Interpreter};

use crate::cycle::CycleState;
use crate::dialect::{ArcCentres, Dialect, Options};
use crate::dialogue;
use crate::error::GcodeError;
use crate::evaluate::{evaluate, is_plain};
use crate::execution::Ran;
use crate::modal::{Distance, PathMode};
use crate::program::{Language, Program};
use crate::sinumerik::names::Name;
use crate::toolpath::Toolpath;
use crate::word::{Span, Word};

/// Axis and arc letters.
const GEOMETRY: &[u8] = b"XYZABCIJKUVW";

/// Reads a program into moves.
///
/// A program with parameters, branches, loops or subprograms should be evaluated first ([`evaluate`]). Otherwise it is evaluated here,
/// without subprograms of other files, and its expressions do not get their values.
///
/// # Errors
/// [`GcodeError::Refused`] with the errors found (at most 20) if a feed move is not interpreted,
/// has no feed, has no circle through its ends, or runs several times; and the errors of [`evaluate`].
pub fn interpret(program: &Program, options: &Options) -> Result<Toolpath, GcodeError> {
    if program.language() == Language::Dialogue {
        return dialogue::interpret(program, options);
    }
    if let Some(language) = options.dialect.language_of(program) {
        return interpret(&program.clone().in_language(language), options);
    }
    if program.execution().is_none() && !is_plain(program) {
        let mut evaluated = program.clone();
        evaluate(&mut evaluated, options, &|_| None)?;
        return interpret(&evaluated, options);
    }
    let read = Interpreter::new(program, options, assumed_centres(options)).run();
    if read.doubts_centres() {
        let mut absolute = Interpreter::new(program, options, Distance::Absolute).run();
        if !absolute.arc_faults.any {
            absolute.warn_of_absolute_centres();
            return absolute.finish();
        }
    }
    read.finish()
}

/// How arc centres are stated until the program says it.
fn assumed_centres(options: &Options) -> Distance {
    match options.arc_centres {
        ArcCentres::Absolute => Distance::Absolute,
        ArcCentres::Auto | ArcCentres::Incremental => Distance::Incremental,
    }
}

impl Interpreter<'_> {
    /// Whether arcs may be stated by absolute centres, which were read as incremental.
    fn doubts_centres(&self) -> bool {
        self.centres_are_open() && self.arc_faults.is_telling
    }

    /// Whether neither program, control nor option say how centres are stated.
    fn centres_are_open(&self) -> bool {
        // SINUMERIK states absolute centres word by word.
        self.options.arc_centres == ArcCentres::Auto
            && self.options.dialect != Dialect::Sinumerik
            && !Dialect::Fanuc.is_certain(self.program)
            && !self.arc_distance_stated
    }

    fn warn_of_absolute_centres(&mut self) {
        self.report.warning(
            Span { start: 0, end: 0 },
            "arc centres are read as absolute (G90.1): as distances from the start they fit no circles",
            Some("state G90.1 or G91.1 in the program, or --arc-centres, to be sure"),
        );
    }

    fn run(mut self) -> Self {
        if !self.program.is_whole() {
            self.report.error(Span { start: 0, end: 0 }, "the program is longer than 4 GiB", None);
            return self;
        }
        let mut words = Gathered::default();
        let mut next = 0;
        while self.read_step(next, &mut words) {
            next += 1;
        }
        self
    }

    /// Reads the executed block with this index. Returns whether there was one and more may follow.
    fn read_step(&mut self, index: usize, words: &mut Gathered) -> bool {
        let Some(step) = self.program.step(index) else { return false };
        // What ran in between stands elsewhere in the file.
        self.shared_since |= (step.block as usize) < self.block;
        self.follows = step.block as usize == self.block + 1;
        self.block = step.block as usize;
        self.ran = step.ran;
        words.fill(self.program, step.words(), self.options.dialect, self.whole.ends_blocks);
        let skips = words.block_delete && self.options.block_delete.is_none();
        words.optional = skips || step.ran == Ran::Perhaps;
        self.shared_since |= step.ran != Ran::Once && !words.is_empty;
        self.read_block(words);
        self.pair_turned();
        let stops = self.ended || self.report.is_full();
        if stops {
            self.warn_after_end();
        }
        !stops
    }

    fn finish(mut self) -> Result<Toolpath, GcodeError> {
        if let Some(circle) = self.open_centres.doubt().filter(|_| self.centres_are_open()) {
            let message = "this arc begins beside its centre if I, J, K are its position, and aslant of it if they are distances from the start: which they are is not known";
            self.report.error(
                circle,
                message,
                Some("state --arc-centres incremental or absolute, or G91.1 or G90.1 in the program"),
            );
        }
        let refused = self.report.has_errors();
        let diagnostics = self.report.into_diagnostics();
        if refused {
            return Err(GcodeError::Refused { diagnostics });
        }
        Ok(Toolpath { moves: self.moves, modals: self.modals, warnings: diagnostics })
    }

    fn read_block(&mut self, words: &Gathered) {
        if words.is_empty || (words.block_delete && self.options.block_delete == Some(true)) {
            return;
        }
        if words.percent {
            // The first mark of a tape opens the program, any other closes it.
            self.ended = self.content_seen;
            self.content_seen = true;
            return;
        }
        self.content_seen = true;
        if words.has(b'O') && words.unknown.is_none() && self.begins_program() {
            let message = "another program begins here: it is not read and stays as it is";
            self.report.warning(self.span_of_block(), message, None);
            self.ended = true;
            return;
        }
        // What evaluation leaves are calls of subprograms that are not found.
        if words.flow.is_some() && self.is_sinumerik() {
            return self.lose_track(words);
        }
        if let Some(statement) = words.flow {
            self.call(self.span(statement));
            return;
        }
        let conflict = self.conflicting_motion(words);
        if self.refuse_conflicts(words, conflict) || self.refuse_jumps(words) {
            return;
        }
        self.settle_doubts(words);
        self.note_unknown(words);
        self.cutter_before = self.modal.cutter;
        let before = (self.motion, self.cycle);
        self.forget_by_tool(words);
        self.apply_settings(words);
        self.note_doubled(words);
        self.doubt_distance(words);
        let names_taken = self.apply_names(words);
        let axes_taken = self.apply_one_shots(words) || names_taken || self.keeps_axis_words(words);
        if let Some(conflict) = conflict {
            self.doubt_motion(words, conflict);
        } else if axes_taken {
            self.state_motion(words);
        } else {
            let path = self.modal.path;
            if words.g.iter().any(|g| g.code == Code::ExactStopHere) {
                self.modal.path = PathMode::ExactStop;
            }
            self.note_corner_alone(words);
            self.apply_motion(words);
            self.modal.path = path;
        }
        if self.doubts.distance {
            self.forget_all();
        }
        // Whether a change of the tool comes before the motion of its block or behind it is the machine's.
        if self.options.dialect != Dialect::LinuxCnc && self.changes_tool(words) {
            self.forget_all();
        }
        // Behind the motion of its block; whether it stops at M1 is the operator's choice.
        self.stopped |= self.ran == Ran::Once
            && !words.optional
            && (words.has_m(self.program, &[0.0, 60.0]) || words.name(Name::Holds).is_some());
        self.note_parallel_axes(words);
        self.note_foreign_geometry(words, axes_taken);
        self.note_exponent(words);
        // The position depends on whether the block ran.
        if words.optional {
            for axis in self.named(words).collect::<Vec<_>>() {
                self.position.forget(axis);
            }
        }
        if self.ran == Ran::Perhaps {
            self.doubt(words, before);
        }
        if self.is_sinumerik() {
            self.settle(words, !axes_taken);
        }
        self.apply_stops(words);
        self.report_ends();
    }

    /// Jumps that run time decides: M96 of Haas (to P where an input is 0) and of Fanuc (a macro that a signal calls), and G65 H80 to H86 of Fanuc's
    /// macro A. Where the tool comes from at their target is not known, nor whether the moves behind them run.
    fn refuse_jumps(&mut self, words: &Gathered) -> bool {
        let target = words.number(self.program, b'P');
        let jumps = target.is_some() && !self.is_sinumerik() && {
            let by_macro = words.number(self.program, b'H').is_some_and(|h| (80.0..=86.0).contains(&h))
                && words.g.iter().any(|g| g.code == Code::OneShot(codes::OneShot::MacroCall));
            words.has_m(self.program, &[96.0]) || by_macro && self.has_block_number(target)
        };
        if jumps {
            let message = "whether this block jumps is decided at run time: where the tool comes from at the target is not known";
            self.report.error(
                self.span_of_block(),
                message,
                Some("compensate the parts of the program before and behind it on their own"),
            );
        }
        jumps
    }

    fn has_block_number(&self, number: Option<f64>) -> bool {
        self.program.words().iter().any(|word| word.is(b'N') && word.number() == number)
    }

    /// After a block that may not have run, a changed motion code or feed is uncertain.
    fn doubt(&mut self, words: &Gathered, before: (Option<Motion>, Option<CycleState>)) {
        if (self.motion, self.cycle) != before {
            self.motion = None;
            self.cycle = None;
        }
        if words.has(b'F') {
            self.feed = FeedWord::Unpredictable { block: self.block };
        }
        if words.has(b'S') {
            self.modal.spindle_rpm = None;
        }
    }

    /// Whether the program number of the block is that of another program, stored under it. A subprogram is called.
    fn begins_program(&self) -> bool {
        let calls = |word: &Word| {
            let number = word.number().unwrap_or_default();
            word.is(b'M') && [97.0, 98.0, 198.0].contains(&number) || word.is(b'G') && [65.0, 66.0].contains(&number)
        };
        let is_called = || self.program.block_words(self.block - 1).iter().any(calls);
        self.options.dialect == Dialect::Fanuc && !self.moves.is_empty() && self.follows && !is_called()
    }

    fn warn_after_end(&mut self) {
        // Behind the end of an evaluated program its subprograms may stand.
        if !self.ended || self.program.execution().is_some() {
            return;
        }
        let next = self.block + 1;
        let first_word = self.program.word_range(next).start;
        let start = if next < self.program.blocks().len() { first_word } else { return };
        let more = self.program.words()[start..].iter().find(|word| word.is(b'G')).map(|word| word.span);
        if let Some(span) = more {
            let message = format!("the program ends on line {next}: what follows is not read and stays as it is");
            self.report.warning(span, message, None);
        }
    }
}
