//! What a block states: its kind by the first words, and the blocks without a path.

use super::block::Block;
use super::path::function_of;
use super::sections::Cause;
use super::state::{FeedWord, Interpreter};
use crate::modal::{Plane, Units};
use crate::toolpath::{Fixed, Move, MoveKind, Shiftable};

/// First words of blocks that change neither path nor frame: blank and tool definitions, labels, contour and pattern definitions.
const SILENT: [&[&str]; 12] = [
    &["BLK", "FORM"],
    &["TOOL", "DEF"],
    &["LBL"],
    &["STOP"],
    &["PATTERN", "DEF"],
    &["SEL", "PATTERN"],
    &["SEL", "CONTOUR"],
    &["SEL", "TABLE"],
    &["CONTOUR", "DEF"],
    &["DECLARE", "CONTOUR"],
    &["DECLARE", "STRING"],
    &["FUNCTION", "MODE", "MILL"],
];
/// First words of blocks in which an M begins a name or a text.
const NO_FUNCTIONS: [&[&str]; 12] = [
    &["BEGIN", "PGM"],
    &["END", "PGM"],
    &["CALL", "PGM"],
    &["SEL"],
    &["DECLARE"],
    &["PATTERN"],
    &["CONTOUR"],
    &["BLK"],
    &["TOOL", "DEF"],
    &["LBL"],
    &["CALL", "LBL"],
    &["CYCL", "DEF"],
];
/// FN functions that only calculate, decide, report or read: 17 writes system data, 19, 20 and 29 act on the PLC, 27 writes tables. Jumps, 9 to
/// 12, are followed before the program is read.
const SILENT_FN: [u32; 20] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 18, 26, 28];

impl Interpreter<'_> {
    /// A block that a switch may skip and that changes frame or tool leaves everything after it alone.
    pub fn note_optional(&mut self, block: &Block<'_>) {
        let changes = [&["CYCL", "DEF"][..], &["PLANE"], &["FUNCTION"], &["TRANS"], &["TOOL", "CALL"], &["CC"]];
        let is_optional = block.is_optional && self.options.block_delete.is_none();
        if is_optional && changes.iter().any(|names| block.begins(names)) {
            let what = "a frame, a tool or a pole in a block that a switch may skip";
            self.open(Cause::Lasting, self.span_of_block(), what, Some("state whether it runs: --block-delete on or off"));
            self.lose_place();
        }
    }

    /// Executes a block. `continued`: it belongs to the block before it.
    pub fn execute(&mut self, block: &Block<'_>, continued: bool) {
        if let Some(function) = function_of(block) {
            return self.position(block, function);
        }
        if continued && block.words.first().is_some_and(|word| word.is(b'Q')) {
            return self.continue_block(block);
        }
        self.continued_preset &= continued;
        let starts = |names: &[&str]| block.begins(names);
        if starts(&["CC"]) {
            self.set_pole(block);
        } else if starts(&["BEGIN", "PGM"]) {
            self.begin(block);
        } else if starts(&["END", "PGM"]) {
            self.ended = true;
        } else if starts(&["TOOL", "CALL"]) {
            self.call_tool(block);
        } else if starts(&["CYCL", "CALL"]) {
            self.call_cycle();
        } else if starts(&["CYCL", "DEF"]) {
            self.define_cycle(block);
        // What the lines of an unknown block do, its first line has reported.
        } else if !self.contour(block) && !self.frame(block) && !self.is_silent(block) && !continued {
            self.unknown(block);
        }
        if !NO_FUNCTIONS.iter().any(|names| block.begins(names)) {
            self.execute_functions(block);
        }
    }

    fn is_silent(&self, block: &Block<'_>) -> bool {
        let fn_number = if block.begins(&["FN"]) { block.number_at(1) } else { None };
        let assigns = block.words.get(1).is_some_and(|word| block.text(word) == b"=")
            && block.words.first().is_some_and(|word| block.text(word).starts_with(b"Q"));
        let only_functions = block.words.first().is_some_and(|word| word.is(b'M'));
        assigns
            || only_functions
            || fn_number.is_some_and(|number| SILENT_FN.contains(&number))
            // Calls of labels are followed before the program is read.
            || block.begins(&["CALL", "LBL"])
            || SILENT.iter().any(|names| block.begins(names))
    }

    fn unknown(&mut self, block: &Block<'_>) {
        let names: Vec<String> =
            block.words.iter().take(2).map(|word| String::from_utf8_lossy(&block.text(word)).into_owned()).collect();
        let what = format!("{}: what it changes is not known", names.join(" "));
        self.open(Cause::Lasting, self.span_of_block(), &what, None);
        self.lose_place();
    }

    /// BEGIN PGM: the unit is the last word.
    fn begin(&mut self, block: &Block<'_>) {
        let last = block.words.last().map(|word| block.text(word)).unwrap_or_default();
        self.modal.units = if last == b"INCH" { Units::Inch } else { Units::Mm };
        // F is in tenths of an inch a minute (TNC 640 Klartext manual, "Feed rate F").
        self.modal.feed_unit_mm = if self.modal.units == Units::Inch { 0.1 * Units::Inch.mm() } else { 1.0 };
        if last != b"INCH" && last != b"MM" {
            self.report.warning(self.span_of_block(), "BEGIN PGM states neither MM nor INCH: mm is taken", None);
        }
    }

    /// TOOL CALL: another tool, or only speed and feed.
    fn call_tool(&mut self, block: &Block<'_>) {
        let is_tool = block.words.get(2).is_some_and(|word| {
            block.name(word).is_empty() || block.text(word).starts_with(b"\"") || block.text(word).starts_with(b"Q")
        });
        if is_tool {
            self.modal.tool = block.number_at(2);
        }
        for (name, plane) in [("Z", Plane::Xy), ("Y", Plane::Zx), ("X", Plane::Yz)] {
            if block.has(name) {
                if plane != self.modal.plane {
                    self.lose_rotation("another plane");
                }
                self.modal.plane = plane;
            }
        }
        if block.words.iter().any(|word| word.is(b'S')) {
            self.modal.spindle_rpm = block.value("S");
        }
        if let Some(word) = block.words.iter().find(|word| word.is(b'F')) {
            self.feed = self.value(word).map_or(FeedWord::Unknown, FeedWord::PerMinute);
            self.tool_feed = self.feed;
        } else if block.value("FU").is_some() || block.value("FZ").is_some() {
            self.feed = FeedWord::Unknown;
            self.tool_feed = self.feed;
        }
        let keeps_length = !is_tool && ["DL", "DR", "DR2"].iter().all(|name| block.value(name).is_none());
        if !keeps_length {
            self.lose_place();
        }
    }

    /// CYCL CALL, M99: the defined cycle runs here.
    pub fn call_cycle(&mut self) {
        let start = self.position;
        self.lose_place();
        let cycle = crate::cycle::Cycle { code: 0, bottom_mm: None, retract_mm: None, repeats: 1 };
        self.push_fixed(MoveKind::Cycle(cycle), start, Fixed::Cycle);
    }

    /// A move that is never compensated, to the present position.
    pub fn push_fixed(&mut self, kind: MoveKind, start: crate::position::Position, why: Fixed) {
        let (modal, block, end) = (self.modal_index(), self.block as u32, self.position);
        let shiftable = Shiftable::No(why);
        let step = Move {
            block,
            modal,
            kind,
            start,
            end,
            feed: None,
            feed_word: None,
            motion_code: None,
            explicit_motion: true,
            shiftable,
            after_shared: false,
            after_stop: false,
        };
        self.push(step, [None; 2]);
    }
}
