//! Codes that mean something else on a control that shares the rest of its codes with Fanuc, as far as their blocks show it.
//!
//! Fagor CNC 8055: mirror images (G11 to G14), pattern rotation (G73), polar origin (G93). Okuma OSP: shift and rotation of coordinates (G11), work
//! offset (G15 H), mirror image (G62), return level (G71). NUM 1060: coordinates of the measurement origin (G52). The manuals were not compared for each form: a
//! code that is wrongly listed here leaves moves alone, and changes none.

use super::codes::{Code, OneShot, written};
use super::gather::{GWord, Gathered};
use super::sections::Cause;
use super::state::Interpreter;
use crate::dialect::Dialect;
use crate::position::AXIS_LETTERS;

/// G05, in tenths.
const LOOK_AHEAD: u16 = 50;
/// G10, G11, G15 and G62, in tenths.
const DATA: u16 = 100;
const DATA_END: u16 = 110;
const POLAR_OFF: u16 = 150;
const CORNER_OVERRIDE: u16 = 620;

impl Interpreter<'_> {
    /// Opens a section at a code that may turn, mirror or scale coordinates on another control.
    pub fn note_other_control(&mut self, words: &Gathered, g: &GWord) {
        if self.options.dialect != Dialect::Fanuc {
            return;
        }
        let has_axes = words.any(&AXIS_LETTERS).is_some();
        match g.code {
            _ if g.tenths == DATA => self.inputs_data = words.has(b'L'),
            // G05 P10001 to P10999 call stored moves (Fanuc 30i Operator's Manual, "High-speed Cycle Machining").
            Code::Silent if g.tenths == LOOK_AHEAD && self.runs_stored_moves(words) => {
                self.doubt_modes(self.span(g.index), "G05 with this P may run stored moves, which are not read: the modal state");
            }
            // It ends a data input of G10, or turns (Okuma) or mirrors (Fagor) until G10.
            _ if g.tenths == DATA_END && !std::mem::take(&mut self.inputs_data) => self.open_transform(g),
            Code::OneShot(OneShot::Pocket) if matches!(g.tenths, 120 | 130) && words.any(b"ID").is_none() => {
                self.open_transform(g)
            }
            // Okuma: `G62 X1` mirrors. Fanuc's corner override has no axis words.
            _ if g.tenths == CORNER_OVERRIDE && has_axes && words.explicit_motion().is_none() => self.open_transform(g),
            // Okuma: `G15 H2` selects a work offset.
            _ if g.tenths == POLAR_OFF && words.has(b'H') => self.forget_all(),
            Code::Units(units) if matches!(g.tenths, 700 | 710) && has_axes && words.explicit_motion().is_none() => {
                if units != self.modal.units {
                    self.open_section(g.index, "the unit of this block with axis words", Cause::Lasting, None);
                }
                self.forget_all();
            }
            Code::Cycle(73) if self.cycle.is_none() && words.any(b"ZR").is_none() => {
                self.open_section(g.index, "G73 without a depth", Cause::Lasting, None);
                self.forget_all();
            }
            Code::FeedMode(_) if !has_axes && words.any(b"IJK").is_some() => {
                self.open_section(g.index, "a code with I, J or K and no motion", Cause::Lasting, None);
            }
            // Fagor: subprograms, calls, jumps (`G20 N1.1`, `G25 N100`); DIN/ISO of Heidenhain: chamfers and corners (`G25 R5`).
            _ if (200..=260).contains(&g.tenths)
                && (words.index(b'N').is_some_and(|n| n > g.index) || g.tenths >= 240 && words.has(b'R')) =>
            {
                self.open_section(g.index, "a code of G20 to G26 with N or R", Cause::Lasting, None);
                self.forget_all();
            }
            Code::OneShot(OneShot::LocalShift) if words.explicit_motion().is_some() || words.has(b'F') => {
                self.doubt_local_shift(words, g)
            }
            _ => {}
        }
    }

    /// Whether the P of G05 is none of those that select a look-ahead: 0, 1, 2 and 3, and 10000 and its multiples.
    fn runs_stored_moves(&self, words: &Gathered) -> bool {
        let is_mode = |p: f64| (0.0..=3.0).contains(&p) || p % 10_000.0 == 0.0;
        words.has(b'P') && !words.number(self.program, b'P').is_some_and(is_mode)
    }

    fn open_transform(&mut self, g: &GWord) {
        self.open_section(g.index, &written(g.tenths), Cause::Transform(g.tenths), None);
        self.forget_all();
    }

    /// G52 beside a motion code or a feed may be a move in machine coordinates, or until contact. Without a shift before and after it only the position is unknown.
    fn doubt_local_shift(&mut self, words: &Gathered, g: &GWord) {
        let is_zero = |axis: usize| self.scaled(words, axis) == Some(0.0) && self.shifts.local[axis] == 0.0;
        if !self.named(words).all(is_zero) {
            self.open_section(g.index, "G52 beside a motion code or F", Cause::Lasting, Some("write G52 in a block of its own"));
        } else if words.explicit_motion().is_none() {
            // Fagor: `G52 X0 F500` moves until contact.
            self.lose_named(words, self.position);
            return;
        }
        self.forget_all();
    }
}
