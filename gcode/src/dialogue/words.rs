//! The words of a positioning block.

use super::block::Block;
use super::functions::has_words;
use super::state::Interpreter;
use crate::modal::CutterCompensation;
use crate::position::LARGEST_COORDINATE;
use crate::word::{Word, WordKind};

/// A coordinate word.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Coordinate {
    pub incremental: bool,
    /// As written; `None` where it depends on a parameter.
    pub value: Option<f64>,
}

/// Feed of a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum BlockFeed {
    /// FMAX, for this block only.
    Rapid,
    /// F, FU or FZ with its name.
    Feed { per: Per, value: Option<f64> },
    /// F AUTO.
    OfTool,
}

/// Unit of a feed word.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Per {
    Minute,
    Revolution,
    Tooth,
}

/// Words of a positioning block.
#[derive(Debug, Default)]
pub(super) struct PathWords {
    /// X, Y, Z, A, B, C.
    pub axes: [Option<Coordinate>; 6],
    /// PR or IPR.
    pub polar_radius: Option<Coordinate>,
    /// PA or IPA.
    pub polar_angle: Option<Coordinate>,
    /// R of a circle.
    pub radius: Option<Coordinate>,
    /// DR: positive counter-clockwise.
    pub direction: Option<f64>,
    pub feed: Option<BlockFeed>,
    pub cutter: Option<CutterCompensation>,
    /// M functions, with their words.
    pub functions: Vec<(Word, Option<u16>)>,
    /// The first word that is not interpreted.
    pub stray: Option<Word>,
}

/// The M functions of a block, with their numbers.
pub(super) fn functions_of(block: &Block<'_>) -> Vec<(Word, Option<u16>)> {
    let functions = block.words.iter().filter(|word| block.name(word) == b"M");
    functions.map(|word| (*word, function_number(word))).collect()
}

fn function_number(word: &Word) -> Option<u16> {
    word.number().filter(|number| number.fract() == 0.0 && (0.0..1024.0).contains(number)).map(|number| number as u16)
}

impl PathWords {
    /// Reads the words behind the path function. In a block with `is_circle` R is the radius.
    pub fn of(block: &Block<'_>, state: &Interpreter<'_>, is_circle: bool) -> Self {
        let mut found = Self::default();
        let mut of_function = false;
        for word in block.words.iter().skip(1) {
            if word.is(b'M') {
                let number = function_number(word);
                of_function = number.is_some_and(has_words);
                found.functions.push((*word, number));
            } else if !of_function && !found.take(block, state, word, is_circle) {
                found.stray = found.stray.or(Some(*word));
            }
        }
        found
    }

    /// Stores a word. Returns whether it is interpreted and stands once.
    fn take(&mut self, block: &Block<'_>, state: &Interpreter<'_>, word: &Word, is_circle: bool) -> bool {
        let value = state.value(word);
        let absolute = Coordinate { incremental: false, value };
        let incremental = Coordinate { incremental: true, value };
        let has_value = matches!(word.kind, WordKind::Number | WordKind::Expression) || word.value_start < word.span.end;
        let name = block.name(word);
        let feed = |per| BlockFeed::Feed { per, value };
        match name.as_slice() {
            [letter @ b'X'..=b'Z'] if has_value => once(&mut self.axes[usize::from(letter - b'X')], absolute),
            [letter @ b'A'..=b'C'] if has_value => once(&mut self.axes[3 + usize::from(letter - b'A')], absolute),
            [b'I', letter @ b'X'..=b'Z'] if has_value => once(&mut self.axes[usize::from(letter - b'X')], incremental),
            [b'I', letter @ b'A'..=b'C'] if has_value => once(&mut self.axes[3 + usize::from(letter - b'A')], incremental),
            b"PR" => once(&mut self.polar_radius, absolute),
            b"IPR" => once(&mut self.polar_radius, incremental),
            b"PA" => once(&mut self.polar_angle, absolute),
            b"IPA" => once(&mut self.polar_angle, incremental),
            b"DR" if word.value.abs() == 1.0 => once(&mut self.direction, word.value),
            // A circle of radius zero does not exist.
            b"R" if block.text(word) == b"R0" => once(&mut self.cutter, CutterCompensation::Off),
            b"R" if is_circle && word.kind != WordKind::Motion => once(&mut self.radius, absolute),
            b"RL" => once(&mut self.cutter, CutterCompensation::Left),
            b"RR" => once(&mut self.cutter, CutterCompensation::Right),
            b"FMAX" => once(&mut self.feed, BlockFeed::Rapid),
            b"F" if has_value => once(&mut self.feed, feed(Per::Minute)),
            // `F MAX` and `F AUTO`: the second word says which.
            b"F" => self.feed.is_none(),
            b"MAX" => once(&mut self.feed, BlockFeed::Rapid),
            b"AUTO" => once(&mut self.feed, BlockFeed::OfTool),
            b"FAUTO" => once(&mut self.feed, BlockFeed::OfTool),
            b"FU" => once(&mut self.feed, feed(Per::Revolution)),
            b"FZ" => once(&mut self.feed, feed(Per::Tooth)),
            _ => false,
        }
    }

    /// Whether the block names an axis or a polar coordinate.
    pub fn moves(&self) -> bool {
        self.axes.iter().any(Option::is_some) || self.polar_radius.is_some() || self.polar_angle.is_some()
    }

    /// Whether every value of the geometry is a number.
    pub fn is_known(&self) -> bool {
        let words = self.axes.iter().chain([&self.polar_radius, &self.polar_angle, &self.radius]);
        words.flatten().all(|coordinate| coordinate.value.is_some())
    }
}

fn once<T>(slot: &mut Option<T>, value: T) -> bool {
    let is_first = slot.is_none();
    *slot = Some(value);
    is_first
}

impl Interpreter<'_> {
    /// Value of a word: its number, or that of its constant parameter.
    pub fn value(&self, word: &Word) -> Option<f64> {
        let value = if word.value.is_finite() {
            Some(word.value)
        } else {
            self.constants.value(self.program.text(word.value_span()), self.block)
        };
        value.filter(|value| value.abs() <= LARGEST_COORDINATE)
    }
}
