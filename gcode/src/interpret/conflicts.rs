//! Codes of one group, and letters, that stand twice in a block.

use super::codes::{Code, written};
use super::gather::{GWord, Gathered};
use super::sections::Cause;
use super::state::Interpreter;
use crate::dialect::Dialect;
use crate::toolpath::{Fixed, Move, MoveKind, Shiftable};

impl Interpreter<'_> {
    /// The first two motion codes of the block that are not the same, by their words.
    pub fn conflicting_motion(&self, words: &Gathered) -> Option<(usize, usize)> {
        let is_motion = |code| matches!(code, Code::Motion(_) | Code::Cycle(_) | Code::UnsupportedMotion);
        let mut motions = words.g.iter().filter(|g| is_motion(g.code));
        let first = motions.next()?;
        let differs = |other: &&GWord| {
            first.tenths != other.tenths || (first.is_named() && self.upper(first.index) != self.upper(other.index))
        };
        let other = motions.find(differs).map(|other| (first.index, other.index));
        // The end of cycles beside a cycle.
        let end =
            || words.g.iter().find(|g| g.code == Code::CancelCycle && words.g.iter().any(|g| matches!(g.code, Code::Cycle(_))));
        other.or_else(|| end().map(|end| (first.index, end.index)))
    }

    /// The text of a word in capitals.
    fn upper(&self, index: usize) -> String {
        String::from_utf8_lossy(self.program.text(self.span(index))).to_ascii_uppercase()
    }

    fn contradiction(&self, first: usize, second: usize) -> String {
        format!("{} contradicts {} in the same block", self.upper(second), self.upper(first))
    }

    /// Which of two motion codes in a block is in force, there and in the blocks after it, differs among controls (on Fanuc mostly the last one).
    pub fn doubt_motion(&mut self, words: &Gathered, (first, second): (usize, usize)) {
        let message = format!("{}: moves are left alone until a block states one of them", self.contradiction(first, second));
        self.report.warning(self.span(second), message, Some("one motion code a block"));
        (self.motion, self.cycle, self.optional_motion) = (None, None, true);
        let start = self.position;
        self.position = self.target(words, 1);
        self.forget_all();
        self.keep_code_of_last_arc(words.optional, true);
        let feed = self.known_feed(words);
        let step = self.step(MoveKind::Line, start, Shiftable::No(Fixed::NotUnderstood));
        self.moves.push(Move { feed, explicit_motion: true, ..step });
    }

    /// Two motion codes in one block conflict: LinuxCNC and SINUMERIK run no such program. Unknown codes with axis words may be motion.
    pub fn refuse_conflicts(&mut self, words: &Gathered, motion: Option<(usize, usize)>) -> bool {
        if let Some((first, second)) = motion.filter(|_| self.options.dialect != Dialect::Fanuc) {
            self.report.error(self.span(second), self.contradiction(first, second), Some("one motion code a block"));
            return true;
        }
        if let Some((first, second)) = self.contradicting_modes(words).filter(|modes| !self.may_be_either(*modes)) {
            let message = format!("{}: controls differ in which of them a word follows", self.contradiction(first, second));
            self.report.error(self.span(second), message, Some("write them in blocks of their own"));
            return true;
        }
        if self.is_sinumerik() {
            return false;
        }
        if let Some(index) = words.bad_g {
            self.report.error(self.span(index), "this G code cannot be identified", Some("write the code as a number"));
            return true;
        }
        let cycle = words.g.iter().find(|g| g.code == Code::UnsupportedMotion);
        if let Some(g) = cycle {
            let message = format!("{} is a cycle of lathes, which is not interpreted", written(g.tenths));
            self.report.error(self.span(g.index), message, Some("write its moves with G1, G2, G3"));
        }
        cycle.is_some()
    }

    /// Whether two codes are G90 and G91, on a control that takes one of them.
    fn may_be_either(&self, (first, _): (usize, usize)) -> bool {
        let is_distance = [90.0, 91.0].contains(&self.program.words()[first].value);
        self.options.dialect == Dialect::Fanuc && is_distance
    }

    /// Moves are left alone behind both of G90 and G91 until one of them is stated, as in `G91 G28 Z0 G90`.
    pub fn doubt_distance(&mut self, words: &Gathered) {
        let Some((first, second)) = self.contradicting_modes(words).filter(|modes| self.may_be_either(*modes)) else { return };
        let message = format!("{}: moves are left alone until a block states one of them", self.contradiction(first, second));
        self.report.warning(self.span(second), message, Some("write them in blocks of their own"));
        self.doubts.distance = true;
    }

    /// G90 and G91, or both units, in a block. Fanuc takes the last one for all words, Beckhoff the last one before a word (P-CHAN-00116),
    /// LinuxCNC refuses them.
    fn contradicting_modes(&self, words: &Gathered) -> Option<(usize, usize)> {
        let of = |is: fn(Code) -> bool| words.g.iter().filter(move |g| is(g.code));
        let groups: [fn(Code) -> bool; 2] = [|code| matches!(code, Code::Distance(_)), |code| matches!(code, Code::Units(_))];
        groups.into_iter().find_map(|is| {
            let first = of(is).next()?;
            of(is).find(|other| other.code != first.code).map(|other| (first.index, other.index))
        })
    }

    /// Letters that stand twice: which of the two is in force is not known. LinuxCNC runs no such program, SINUMERIK reads names.
    pub fn note_doubled(&mut self, words: &Gathered) {
        let Some(index) = words.duplicate.filter(|_| self.options.dialect == Dialect::Fanuc) else { return };
        if words.is_doubled(b'F') {
            self.report.warning(self.span(index), "F stands twice: moves are left alone until the feed is stated again", None);
            self.doubts.feed = true;
        }
        if words.is_doubled(b'S') {
            self.modal.spindle_rpm = None;
        }
        let is_motion = |code: Code| {
            matches!(
                code,
                Code::Motion(_)
                    | Code::Cycle(_)
                    | Code::CancelCycle
                    | Code::Distance(_)
                    | Code::Units(_)
                    | Code::FeedMode(_)
                    | Code::Plane(_)
                    | Code::WorkOffset(_)
                    | Code::MachineCoordinates
                    | Code::ReturnLevel(_)
            )
        };
        // Coordinates of a move concern it alone, those of an offset all that follow.
        let is_lasting =
            words.g.iter().any(|g| !is_motion(g.code)) && b"XYZABCUVWIJKR".iter().any(|letter| words.is_doubled(*letter));
        if is_lasting || b"DHPLQ".iter().any(|letter| words.is_doubled(*letter)) {
            self.open_section(index, "a letter that stands twice", Cause::Lasting, None);
        }
    }
}
