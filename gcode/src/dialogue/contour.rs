//! Parts of a contour that the control computes: roundings, chamfers, approach and departure.

use super::block::Block;
use super::state::{FeedWord, Interpreter};
use super::words::PathWords;
use crate::modal::CutterCompensation;
use crate::toolpath::{Fixed, MoveKind};

impl Interpreter<'_> {
    /// RND, CHF, APPR, DEP and free contours. Returns whether the block is one of these.
    pub fn contour(&mut self, block: &Block<'_>) -> bool {
        let Some(first) = block.words.first() else { return false };
        let name = block.name(first);
        match name.as_slice() {
            b"RND" | b"CHF" => self.corner(),
            b"APPR" => self.approach(block),
            b"DEP" => self.depart(block),
            b"LN" | b"SPL" | b"FPOL" | b"FL" | b"FLT" | b"FC" | b"FCT" | b"FSELECT" => {
                let what = "this path function is not interpreted; the block is left alone";
                self.report.warning(first.span, what, Some("positions are known again where the program states them"));
                self.keep_feed(block);
                if matches!(name.as_slice(), b"FLT" | b"FCT") {
                    self.fix_last();
                }
                let is_free = name.starts_with(b"F") && !block.words.iter().any(|word| self.leaves_plane(&block.name(word)));
                if is_free { self.lose_plane() } else { self.lose_place() }
            }
            _ => return false,
        }
        true
    }

    /// Whether a word names an axis that does not lie in the working plane. Free contours run in that plane.
    fn leaves_plane(&self, name: &[u8]) -> bool {
        let normal = b"XYZ"[self.modal.plane.axes()[2]];
        matches!(name, [letter] | [b'I', letter] if *letter == normal || b"ABCUVW".contains(letter))
    }

    /// The coordinates in the working plane are not known.
    fn lose_plane(&mut self) {
        let [first, second, _] = self.modal.plane.axes();
        self.position.forget(first);
        self.position.forget(second);
        self.lose_contour();
        self.pole = None;
    }

    /// The corner between two moves is replaced: both keep their points.
    fn corner(&mut self) {
        self.fix_last();
        self.start_is_computed = true;
        self.lose_contour();
    }

    /// The control computes something from the move before.
    fn fix_last(&mut self) {
        let before = self.last_feed_move();
        self.fix(before.into_iter().collect());
    }

    /// APPR: the control computes the way to the first point of the contour, which the block states, from the direction of the move behind it.
    fn approach(&mut self, block: &Block<'_>) {
        self.computed(block, |name| name.starts_with(b"P"));
        self.start_is_computed = true;
        if block.has("RL") {
            self.modal.cutter = CutterCompensation::Left;
        } else if block.has("RR") {
            self.modal.cutter = CutterCompensation::Right;
        }
    }

    /// DEP: the end is computed from the direction of the move before, unless the block states it (LCT). Radius compensation ends with it.
    fn depart(&mut self, block: &Block<'_>) {
        self.fix_last();
        self.computed(block, |name| name != b"LCT");
        self.modal.cutter = CutterCompensation::Off;
    }

    /// Pushes the move of an APPR or DEP block. The plane coordinates are lost where `is_lost` says so for its second word.
    fn computed(&mut self, block: &Block<'_>, is_lost: fn(&[u8]) -> bool) {
        let start = self.position;
        self.keep_feed(block);
        let words = PathWords::of(block, self, true);
        self.position = self.target(&words);
        let kind = block.words.get(1).map(|word| block.text(word)).unwrap_or_default();
        if is_lost(&kind) {
            let pole = self.pole;
            self.lose_plane();
            self.pole = pole;
        }
        self.lose_contour();
        self.push_fixed(MoveKind::Line, start, Fixed::Adjoining);
        if let Some(step) = self.moves.last_mut() {
            step.feed = None;
        }
    }

    /// The feed of a block that is not interpreted stays in force.
    fn keep_feed(&mut self, block: &Block<'_>) {
        if let Some(word) = block.words.iter().find(|word| word.is(b'F')) {
            self.feed = self.value(word).map_or(FeedWord::Unknown, FeedWord::PerMinute);
        }
    }
}
