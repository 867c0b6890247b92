//! Words of one block, indexed by letter.

use std::ops::Range;

use super::classify::classify;
use super::codes::{Code, Motion, tenths};
use super::sinumerik_codes::classify_sinumerik;
use crate::block_end::is_behind;
use crate::dialect::Dialect;
use crate::lexer::is_output;
use crate::number::{has_two_signs, scan_number};
use crate::program::Program;
use crate::sinumerik::names::Name;
use crate::word::{Word, WordKind};

/// One G word with its meaning.
#[derive(Clone, Copy, Debug)]
pub(super) struct GWord {
    pub index: usize,
    pub tenths: u16,
    pub code: Code,
}

/// Number of a code that has a name instead; it is in no message.
const NAMED: u16 = u16::MAX;

impl GWord {
    /// Whether the code has a name instead of a number.
    pub fn is_named(&self) -> bool {
        self.tenths == NAMED
    }
}

/// Words of a block by letter. The buffers are reused for every block.
#[derive(Debug, Default)]
pub(super) struct Gathered {
    by_letter: [Option<u32>; 26],
    pub g: Vec<GWord>,
    pub m: Vec<usize>,
    /// Words of SINUMERIK with a name, and values in AC( ) or IC( ) of none of the axes.
    pub named: Vec<(usize, Name)>,
    /// G words whose value is an expression or no code.
    pub bad_g: Option<usize>,
    pub unknown: Option<usize>,
    /// The first letter that stands twice with different values, and all of them, a bit each.
    pub duplicate: Option<usize>,
    doubled: u32,
    /// Whether the control rounds or chamfers the corner at the end of the block (`,R`, `,C`).
    pub corner: bool,
    /// A dimension of a drawing, `,A45.`: the control computes the end of the line from it.
    pub drawing: Option<usize>,
    pub flow: Option<usize>,
    pub percent: bool,
    pub block_delete: bool,
    /// Whether it is unknown if the block runs.
    pub optional: bool,
    /// An assignment that may move the coordinate system; evaluation leaves no others.
    pub assignment: Option<usize>,
    /// Behind `;` stand words that may be blocks of their own: some controls end a block there.
    pub blocks_behind: Option<usize>,
    pub is_empty: bool,
}

impl Gathered {
    /// Sorts the words with these indices. `ends_blocks`: whether `;` may end a block.
    pub fn fill(&mut self, program: &Program, range: Range<usize>, dialect: Dialect, ends_blocks: bool) {
        let (mut g, mut m, mut named) =
            (std::mem::take(&mut self.g), std::mem::take(&mut self.m), std::mem::take(&mut self.named));
        g.clear();
        m.clear();
        named.clear();
        *self = Self { g, m, named, is_empty: true, ..Self::default() };
        let block = &program.words()[range.clone()];
        let first = range.start;
        for index in range {
            let word = &program.words()[index];
            let is_block = ends_blocks && is_behind(program, word, index == first);
            self.is_empty &= word.kind == WordKind::Comment && !is_block;
            self.note_name(index, word.name);
            match word.kind {
                WordKind::Comment => {
                    self.blocks_behind = self.blocks_behind.or(is_block.then_some(index));
                }
                WordKind::Keyword if word.name != Name::None => {}
                WordKind::Assignment => self.assignment = self.assignment.or(Some(index)),
                WordKind::BlockDelete => self.block_delete = true,
                WordKind::Percent => self.percent = true,
                WordKind::Flow => self.flow = self.flow.or(Some(index)),
                WordKind::Unknown if dialect == Dialect::Fanuc && is_corner(program.text(word.span)) => self.corner = true,
                WordKind::Unknown if dialect == Dialect::Fanuc && is_drawing(program.text(word.span)) => {
                    self.drawing = self.drawing.or(Some(index));
                }
                WordKind::Unknown if moves_nothing(program.text(word.span), dialect) => {}
                WordKind::Unknown | WordKind::Motion | WordKind::Keyword => self.unknown = self.unknown.or(Some(index)),
                // LinuxCNC reads `X--1` as 1, other controls report it.
                WordKind::Expression if dialect == Dialect::Fanuc && has_two_signs(program.text(word.value_span())) => {
                    self.unknown = self.unknown.or(Some(index));
                }
                WordKind::Number | WordKind::Expression => self.add(index, word, dialect, (first, block)),
            }
        }
    }

    fn note_name(&mut self, index: usize, name: Name) {
        let code = |code: Code| GWord { index, tenths: NAMED, code };
        match name {
            Name::None | Name::Absolute | Name::Incremental => {}
            Name::Curve => self.g.push(code(Code::Motion(Motion::Curve))),
            Name::CircleThroughPoint => self.g.push(code(Code::Motion(Motion::CircleThroughPoint))),
            Name::TangentialCircle => self.g.push(code(Code::Motion(Motion::TangentialCircle))),
            Name::MachineFrame => self.g.push(code(Code::MachineCoordinates)),
            name => {
                if name.is_coordinate() && name != Name::Geometry && self.name(name).is_some() {
                    self.duplicate = self.duplicate.or(Some(index));
                }
                self.named.push((index, name));
            }
        }
    }

    /// `block`: all words of the block, of which the first has the index `first`.
    fn add(&mut self, index: usize, word: &Word, dialect: Dialect, (first, block): (usize, &[Word])) {
        match word.letter {
            b'G' => match word.number().and_then(tenths) {
                Some(tenths) => {
                    let code = match dialect {
                        Dialect::Sinumerik => classify_sinumerik(tenths),
                        _ => classify(tenths, dialect, |letter| block.iter().any(|word| word.is(letter))),
                    };
                    self.g.push(GWord { index, tenths, code });
                }
                None => self.bad_g = self.bad_g.or(Some(index)),
            },
            b'M' => self.m.push(index),
            letter => {
                let Some(slot) = self.by_letter.get_mut(usize::from(letter.wrapping_sub(b'A'))) else { return };
                // The same number twice is one on controls that take it.
                let before = slot.and_then(|before| block.get((before as usize).checked_sub(first)?));
                let differs =
                    |before: &Word| dialect != Dialect::Fanuc || before.number().is_none() || before.number() != word.number();
                if before.is_some_and(differs) {
                    self.duplicate = self.duplicate.or(Some(index));
                    self.doubled |= 1 << (letter - b'A');
                }
                // The last one is active, as on controls that accept several.
                *slot = u32::try_from(index).ok();
            }
        }
    }

    /// Word and code of the motion stated in the block.
    pub fn explicit_motion(&self) -> Option<(usize, Code)> {
        self.g.iter().find(|g| matches!(g.code, Code::Motion(_) | Code::Cycle(_))).map(|g| (g.index, g.code))
    }

    /// Index of the word with this letter (not G or M).
    pub fn index(&self, letter: u8) -> Option<usize> {
        self.by_letter.get(usize::from(letter.wrapping_sub(b'A'))).copied().flatten().map(|index| index as usize)
    }

    /// Whether a letter stands twice.
    pub fn is_doubled(&self, letter: u8) -> bool {
        self.doubled & (1 << (letter - b'A')) != 0
    }

    /// Whether the block has a word with this letter.
    pub fn has(&self, letter: u8) -> bool {
        self.index(letter).is_some()
    }

    /// Index of the first part of a position that has a name.
    pub fn geometry(&self) -> Option<usize> {
        self.named.iter().find(|(_, name)| name.is_coordinate()).map(|(index, _)| *index)
    }

    /// Index of the first word with this name.
    pub fn name(&self, wanted: Name) -> Option<usize> {
        self.named.iter().find(|(_, name)| *name == wanted).map(|(index, _)| *index)
    }

    /// Whether a code of the block selects machine coordinates.
    pub fn is_in_machine_frame(&self) -> bool {
        self.g.iter().any(|g| g.code == Code::MachineCoordinates)
    }

    /// Value of the word with this letter.
    pub fn number(&self, program: &Program, letter: u8) -> Option<f64> {
        program.words().get(self.index(letter)?)?.number()
    }

    /// Index of the first word among these letters.
    pub fn any(&self, letters: &[u8]) -> Option<usize> {
        letters.iter().filter_map(|letter| self.index(*letter)).min()
    }

    /// Index of the first word among these letters whose value is unknown.
    pub fn unknown_value(&self, program: &Program, letters: &[u8]) -> Option<usize> {
        letters
            .iter()
            .filter_map(|letter| self.index(*letter))
            .filter(|index| program.words().get(*index).is_some_and(|word| word.number().is_none()))
            .min()
    }

    /// Whether the block has an M word with this number.
    pub fn has_m(&self, program: &Program, numbers: &[f64]) -> bool {
        self.m.iter().any(|index| program.words()[*index].number().is_some_and(|n| numbers.contains(&n)))
    }
}

/// Whether a word that is not interpreted is output to an interface, or the number of a spindle (`$0`, LinuxCNC).
fn moves_nothing(text: &[u8], dialect: Dialect) -> bool {
    match dialect {
        Dialect::Fanuc => is_output(text),
        // `$-1` stands for all spindles.
        Dialect::LinuxCnc => text
            .strip_prefix(b"$")
            .is_some_and(|number| number == b"-1" || !number.is_empty() && number.iter().all(u8::is_ascii_digit)),
        Dialect::Sinumerik => false,
    }
}

/// Whether a word is another dimension of a drawing: `,A45.` (Fanuc 0i-F Operator's Manual, "Direct Drawing Dimension Programming"), `,I3.`
/// (Mitsubishi).
fn is_drawing(text: &[u8]) -> bool {
    let [b',', letter, value @ ..] = text else { return false };
    // Codes, feeds and coordinates are no dimensions: some controls pass over the comma.
    let is_dimension = letter.is_ascii_alphabetic() && !b"GMFTNOXYZ".contains(&letter.to_ascii_uppercase());
    is_dimension && scan_number(value, 0).is_some_and(|(end, _)| end == value.len())
}

/// Whether a word rounds or chamfers a corner: `,R5.` or `,C1` (Fanuc 0i-F Operator's Manual, "Optional Chamfering and Corner R").
fn is_corner(text: &[u8]) -> bool {
    let [b',', letter, value @ ..] = text else { return false };
    let is_number = scan_number(value, 0).is_some_and(|(end, number)| end == value.len() && number >= 0.0);
    matches!(letter.to_ascii_uppercase(), b'R' | b'C') && is_number
}
