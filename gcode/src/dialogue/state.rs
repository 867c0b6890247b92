//! State of the dialogue interpreter: modal state, position, pole, open sections and the moves so far.

use super::parameters::Constants;
use super::sections::Cause;
use crate::dialect::Options;
use crate::interpret::report::Report;
use crate::modal::{Distance, Modal, PathMode, Units, WorkOffset};
use crate::named_blocks::NamedBlocks;
use crate::position::Position;
use crate::program::Program;
use crate::sections::Sections;
use crate::toolpath::{Fixed, Move, Shiftable};
use crate::word::{Span, Word};

/// The modal F.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum FeedWord {
    Unset,
    /// Units per minute.
    PerMinute(f64),
    /// FU: units per revolution.
    PerRevolution(f64),
    /// FZ, or a parameter.
    Unknown,
}

/// The pole of circles and polar coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pole {
    /// In the axes of the plane, mm.
    pub centre_mm: [f64; 2],
    /// The move whose end it is measured from, where that end may be shifted.
    pub from_move: Option<usize>,
}

/// Interpreter state.
pub(super) struct Interpreter<'a> {
    pub program: &'a Program,
    pub options: &'a Options,
    pub report: Report<'a>,
    pub constants: Constants,
    /// Contours that a cycle runs again.
    pub named_blocks: NamedBlocks,
    pub block: usize,
    pub modal: Modal,
    pub position: Position,
    pub feed: FeedWord,
    /// F of the last TOOL CALL, for `F AUTO`.
    pub tool_feed: FeedWord,
    pub sections: Sections<Cause>,
    pub pole: Option<Pole>,
    /// Radius in mm and angle in rad of the last move to polar coordinates, about the present pole.
    pub polar: Option<[f64; 2]>,
    /// Direction in the plane at the end of the last feed move.
    pub tangent: Option<[f64; 2]>,
    /// Whether the control computes the start of the next feed move (RND, CHF).
    pub start_is_computed: bool,
    /// Whether the next lines behind `~` are those of CYCL DEF 247.
    pub continued_preset: bool,
    pub ended: bool,
    /// Whether the program names A, B or C anywhere.
    pub names_rotary: bool,
    /// Axes whose datum shift is not known.
    pub unknown_shifts: [bool; 6],
    /// Whether the known rotation is a mirror image.
    pub is_image: bool,
    pub moves: Vec<Move>,
    pub modals: Vec<Modal>,
    /// Moves whose ends a move depends on beside its own start: that before a tangent, or that of a pole.
    pub needs: Vec<[Option<usize>; 2]>,
}

impl<'a> Interpreter<'a> {
    pub fn new(program: &'a Program, options: &'a Options) -> Self {
        let mut modal = Modal::initial(Units::Mm, Distance::Absolute);
        modal.work_offset = WorkOffset::Extended(0);
        modal.path = PathMode::Default;
        let mut position = Position::unknown();
        for (axis, value) in options.start_mm.iter().flatten().enumerate() {
            position.set(axis, *value);
        }
        Self {
            program,
            options,
            report: Report::new(program),
            constants: Constants::of(program),
            named_blocks: NamedBlocks::of(program, options),
            block: 0,
            modal,
            position,
            feed: FeedWord::Unset,
            tool_feed: FeedWord::Unset,
            sections: Sections::default(),
            pole: None,
            polar: None,
            tangent: None,
            start_is_computed: false,
            continued_preset: false,
            ended: false,
            names_rotary: program.words().iter().any(|word| is_rotary(program, word)),
            unknown_shifts: [false; 6],
            is_image: false,
            moves: Vec::new(),
            modals: Vec::new(),
            needs: Vec::new(),
        }
    }

    pub fn span_of_block(&self) -> Span {
        let first = self.program.block_words(self.block).iter().find(|word| !word.is(b'N'));
        first.or(self.program.block_words(self.block).first()).map_or(Span { start: 0, end: 0 }, |word| word.span)
    }

    /// Opens a section, with a warning where it is new.
    pub fn open(&mut self, cause: Cause, span: Span, what: &str, help: Option<&str>) {
        if cause != Cause::Rotation {
            self.lose_rotation("another function");
        }
        if self.sections.open(cause) {
            let until = if cause == Cause::Lasting { "up to the program's end" } else { "until it is cancelled" };
            self.report.warning(span, format!("{what}; the moves after it are left alone {until}"), help);
        }
    }

    /// Ends a section. What it did to the position is not known.
    pub fn close(&mut self, cause: Cause) {
        if self.sections.close(cause) {
            self.lose_place();
        }
    }

    /// Position, pole and direction are not known.
    pub fn lose_place(&mut self) {
        self.position.known = 0;
        self.lose_contour();
        self.pole = None;
    }

    /// The next move continues no contour.
    pub fn lose_contour(&mut self) {
        self.tangent = None;
        self.polar = None;
    }

    /// Adds a move. What a fixed move depends on becomes fixed too.
    pub fn push(&mut self, step: Move, needs: [Option<usize>; 2]) {
        let step = self.modal.rotation.map_or(step, |rotation| step.in_work(&rotation));
        self.moves.push(step);
        self.needs.push(needs);
        if step.shiftable != Shiftable::Yes {
            let pole = self.pole.as_mut().and_then(|pole| pole.from_move.take());
            self.fix(needs.into_iter().chain([pole]).flatten().collect());
        }
    }

    /// Marks moves whose end another block needs where the program has it, and those that they need.
    pub fn fix(&mut self, mut waiting: Vec<usize>) {
        while let Some(index) = waiting.pop() {
            if self.moves[index].shiftable == Shiftable::Yes {
                self.moves[index].shiftable = Shiftable::No(Fixed::Adjoining);
                waiting.extend(self.needs[index].iter().flatten());
            }
        }
    }

    /// The last move, if it is a feed move.
    pub fn last_feed_move(&self) -> Option<usize> {
        self.moves.last().filter(|step| step.is_feed()).map(|_| self.moves.len() - 1)
    }

    /// Index of the current modal state in the toolpath.
    pub fn modal_index(&mut self) -> u32 {
        if self.modals.last() != Some(&self.modal) {
            self.modals.push(self.modal);
        }
        (self.modals.len() - 1) as u32
    }
}

/// Whether a word is a coordinate of a rotary axis.
fn is_rotary(program: &Program, word: &Word) -> bool {
    let name = program.text(Span { start: word.span.start, end: word.value_start }).to_ascii_uppercase();
    word.value_start < word.span.end && matches!(name.as_slice(), [b'A'..=b'C'] | [b'I', b'A'..=b'C'])
}
