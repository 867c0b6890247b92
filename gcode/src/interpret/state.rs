//! Interpreter state: modal state, position, open sections and the moves so far.

use super::arc_faults::ArcFaults;
use super::codes::Motion;
use super::doubts::Doubts;
use super::open_centres::OpenCentres;
use super::pole::Polar;
use super::report::Report;
use super::sections::Cause;
use super::shifts::Shifts;
use crate::block_end::has_remarks;
use crate::cycle::CycleState;
use crate::dialect::{Dialect, Options};
use crate::execution::Ran;
use crate::modal::{CutterCompensation, Distance, Modal};
use crate::named_blocks::NamedBlocks;
use crate::position::Position;
use crate::program::Program;
use crate::sections::Sections;
use crate::toolpath::Move;
use crate::word::{Span, Word, WordKind};

/// Interpreter state.
pub(super) struct Interpreter<'a> {
    pub program: &'a Program,
    pub options: &'a Options,
    pub report: Report<'a>,
    pub block: usize,
    pub modal: Modal,
    pub motion: Option<Motion>,
    pub cycle: Option<CycleState>,
    pub position: Position,
    pub whole: Whole,
    pub shifts: Shifts,
    pub feed: FeedWord,
    /// Bits of the axes of which G51.1 or MIRROR program mirror images, in the order XYZABCUVW.
    pub mirrored: u16,
    /// The block that ended a known mirror image last.
    pub ended_mirror: Option<usize>,
    pub sections: Sections<Cause>,
    pub doubts: Doubts,
    /// Causes of open sections whose end is not reported yet, with the indices of their diagnostics.
    pub unended: Vec<(Cause, usize)>,
    /// How often the present block runs.
    pub ran: Ran,
    /// Whether blocks that run elsewhere too ran since the last move of a block that runs once.
    pub shared_since: bool,
    /// The last block with a feed move that may be edited.
    pub fed_block: Option<usize>,
    pub units_stated: bool,
    pub arc_distance_stated: bool,
    pub arc_faults: ArcFaults,
    pub open_centres: OpenCentres,
    /// Whether the feed, and whether the motion code, comes from a block that a switch may skip.
    pub optional_feed: bool,
    /// Whether an F beside a dwell may have changed the feed.
    pub unclear_feed: bool,
    /// Coordinate systems turned by G10 L2 with R, `None` where it is not known which.
    pub rotated: Vec<Option<u16>>,
    pub optional_motion: bool,
    /// Whether a block that a switch may skip came after the last motion code or move of the others.
    pub optional_since_code: bool,
    /// The block of the last move that runs in any case.
    pub last_certain: usize,
    /// Whether the program stopped since the last move.
    pub stopped: bool,
    /// What of the frame the program has stated so far.
    pub stated: StatedFrame,
    /// Whether G43.1 or G43.2 stated the tool offset.
    pub tool_offset_stated: bool,
    /// Whether G10 with L began an input of data, which G11 ends.
    pub inputs_data: bool,
    pub cutter_before: CutterCompensation,
    /// SINUMERIK: axes whose frame or tool changed since their last absolute word.
    pub unsettled: [bool; 6],
    /// SINUMERIK: pole and polar coordinates.
    pub polar: Polar,
    /// The present move begins or ends in a corner that the control rounds or chamfers; how many moves from here on do; on SINUMERIK all may.
    pub in_corner: bool,
    pub corner_moves: u8,
    pub rounds_corners: bool,
    pub compressor_noted: bool,
    /// Whether a name of the block closed a section.
    pub closes_section: bool,
    pub content_seen: bool,
    pub ended: bool,
    /// Whether the block stands behind the one that ran before it.
    pub follows: bool,
    pub moves: Vec<Move>,
    pub modals: Vec<Modal>,
}

/// What a program has stated of its frame. Before that, the frame is as an earlier program or the machine's settings left it: another offset, a tool length
/// and a shift may be active, which a code then changes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct StatedFrame {
    pub work_offset: bool,
    pub tool_length: bool,
    /// Of every axis; G92 adds to what was left, so that it states nothing.
    pub position_shift: [bool; 6],
}

/// What only all words of the program show.
#[derive(Clone, Debug)]
pub(super) struct Whole {
    /// Blocks that others name by their numbers.
    pub named_blocks: NamedBlocks,
    /// Linear axes that the program never names. Their position is constant and counts as known.
    pub idle: u8,
    /// Whether words behind `;` may be a block of their own.
    pub ends_blocks: bool,
    /// Whether the program may be of another control than the dialect that was found in it.
    pub is_guessed: bool,
    /// Whether G43, G44 or their like select a tool's length anywhere, or D stands beside G41 or G42: D is no tool's length then.
    pub states_tool_length: bool,
    /// Whether the program names a work offset anywhere.
    pub states_work_offset: bool,
    /// Whether the program names A, B or C anywhere.
    pub names_rotary: bool,
    /// Whether a MIRROR or AMIRROR anywhere has a value that is not the number 0.
    pub mirrors_by_value: bool,
}

impl Whole {
    fn of(program: &Program, options: &Options) -> Self {
        let is_offset = |word: &Word| word.is(b'G') && ((54.0..60.0).contains(&word.value) || word.value == 154.0);
        Self {
            named_blocks: NamedBlocks::of(program, options),
            idle: idle_axes(program),
            ends_blocks: options.dialect == Dialect::Fanuc && !has_remarks(program),
            is_guessed: options.dialect == Dialect::detect(program) && !options.dialect.is_certain(program),
            states_tool_length: program.words().iter().any(|word| word.is(b'G') && (43.0..45.0).contains(&word.value))
                || (0..program.blocks().len()).any(|block| states_radius(program, block)),
            states_work_offset: program.words().iter().any(is_offset),
            names_rotary: program.words().iter().any(|word| matches!(word.letter, b'A'..=b'C')),
            mirrors_by_value: (0..program.blocks().len()).any(|block| mirrors_by_value(program, block)),
        }
    }
}

/// Whether a block states the radius of G41 or G42 by D.
fn states_radius(program: &Program, block: usize) -> bool {
    let words = program.block_words(block);
    words.iter().any(|word| word.is(b'D')) && words.iter().any(|word| word.is(b'G') && (41.0..43.0).contains(&word.value))
}

/// Whether a block programs a mirror image of SINUMERIK with a value that is not the number 0.
fn mirrors_by_value(program: &Program, block: usize) -> bool {
    let words = program.block_words(block);
    let has_value = |word: &Word| matches!(word.letter, b'A'..=b'C' | b'U'..=b'Z') && word.number() != Some(0.0);
    words.iter().any(|word| program.is_mirror_image(word)) && words.iter().any(has_value)
}

/// The modal F.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum FeedWord {
    Unset,
    /// Value as written, and in mm/min or mm/rev.
    Value {
        written: f64,
        mm: f64,
    },
    /// Set from a parameter in this block.
    Unpredictable {
        block: usize,
    },
}

impl<'a> Interpreter<'a> {
    pub fn new(program: &'a Program, options: &'a Options, arc_distance: Distance) -> Self {
        Self::with(program, options, arc_distance, Whole::of(program, options))
    }

    /// Same as [`Interpreter::new`], for a part of a program.
    pub fn with(program: &'a Program, options: &'a Options, arc_distance: Distance, whole: Whole) -> Self {
        let mut position = Position { nominal: [0.0; 6], known: whole.idle };
        for (axis, value) in options.start_mm.iter().flatten().enumerate() {
            position.set(axis, *value);
        }
        let modal = Modal::initial(options.units, arc_distance);
        Self {
            program,
            options,
            report: Report::new(program),
            block: 0,
            modal,
            motion: None,
            cycle: None,
            position,
            whole,
            shifts: Shifts::default(),
            feed: FeedWord::Unset,
            mirrored: 0,
            ended_mirror: None,
            sections: Sections::default(),
            doubts: Doubts::default(),
            unended: Vec::new(),
            ran: Ran::Once,
            shared_since: false,
            fed_block: None,
            units_stated: false,
            arc_distance_stated: false,
            arc_faults: ArcFaults::default(),
            open_centres: OpenCentres::default(),
            optional_feed: false,
            unclear_feed: false,
            rotated: Vec::new(),
            optional_motion: false,
            optional_since_code: false,
            last_certain: 0,
            stopped: false,
            stated: StatedFrame::default(),
            tool_offset_stated: false,
            inputs_data: false,
            cutter_before: modal.cutter,
            unsettled: [false; 6],
            polar: Polar::default(),
            in_corner: false,
            corner_moves: 0,
            rounds_corners: false,
            compressor_noted: false,
            closes_section: false,
            content_seen: false,
            ended: false,
            follows: false,
            moves: Vec::new(),
            modals: Vec::new(),
        }
    }

    /// Index of the current modal state in the toolpath.
    pub fn modal_index(&mut self) -> u32 {
        if self.modals.last() != Some(&self.modal) {
            self.modals.push(self.modal);
        }
        (self.modals.len() - 1) as u32
    }

    /// Whether the next move follows blocks that run elsewhere too.
    pub fn take_shared(&mut self) -> bool {
        let shared = self.shared_since;
        self.shared_since &= self.ran != Ran::Once;
        shared
    }

    pub fn span(&self, word: usize) -> Span {
        self.program.words().get(word).map_or_else(|| self.span_of_block(), |word| word.span)
    }

    pub fn span_of_block(&self) -> Span {
        self.program.blocks().get(self.block).map_or(Span { start: 0, end: 0 }, |block| block.span)
    }

    /// Marks the whole position as unknown.
    pub fn forget_all(&mut self) {
        self.position.known = self.whole.idle;
    }
}

/// Bit mask of the linear axes that no word of the program names.
fn idle_axes(program: &Program) -> u8 {
    // A word that is not read may name the axis too.
    let begins =
        |word: &Word, letter: u8| program.text(word.span).first().is_some_and(|first| first.eq_ignore_ascii_case(&letter));
    let is_named = |word: &Word, letter: u8| word.is(letter) || word.kind == WordKind::Unknown && begins(word, letter);
    let named = |letter: u8| program.words().iter().any(|word| is_named(word, letter));
    b"XYZ".iter().enumerate().filter(|(_, letter)| !named(**letter)).map(|(axis, _)| 1 << axis).sum()
}
