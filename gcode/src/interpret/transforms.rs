//! Modes under which programmed coordinates are not those of the path: rotation that is not known, scaling, mirror images, polar coordinates, mapping onto a
//! cylinder. A modal macro counts as one, since it moves the tool after each block. Moves in such a mode are left alone.

use super::codes::{Code, written};
use super::gather::{GWord, Gathered};
use super::sections::Cause;
use super::state::Interpreter;

/// Axes of which a mirror image can be programmed.
pub(super) const MIRROR_AXES: &[u8; 9] = b"XYZABCUVW";
/// G51.1, in tenths.
pub(super) const MIRROR_ON: u16 = 511;
/// G68.2, in tenths.
const TILTED: u16 = 682;
/// G10, in tenths.
const DATA: u16 = 100;
/// G50.1, in tenths.
pub(super) const MIRROR_OFF: u16 = 501;

impl Interpreter<'_> {
    /// Opens the section of a code under which coordinates are not those of the path.
    pub fn note_transform(&mut self, words: &Gathered, g: &GWord) {
        let opens = match g.code {
            Code::TransformOn | Code::ModalMacroOn => true,
            Code::CylinderMapping => !self.ends_mapping(words),
            _ => return,
        };
        let cause = Cause::Transform(g.tenths);
        if opens && let Some(rotation) = self.stated_rotation(words, g) {
            self.turn(Some(rotation));
        } else if opens && let Some(image) = self.stated_mirror(words, g) {
            self.mirrored = axes(words);
            self.turn(Some(image));
        } else if self.is_untilted(words, g) {
            self.forget_all();
        } else if opens {
            if g.tenths == MIRROR_ON {
                self.mirrored |= axes(words);
            }
            self.open_section(g.index, &written(g.tenths), cause, None);
            self.forget_all();
        } else if self.sections.close_where(|open| matches!(open, Cause::Transform(71 | 1070))) {
            self.forget_all();
        }
    }

    /// A tilted plane without shift or angle: its coordinates are those of the part, as posts write them before work in three axes.
    fn is_untilted(&self, words: &Gathered, g: &GWord) -> bool {
        let is_zero = |letter: &u8| words.number(self.program, *letter) == Some(0.0);
        g.tenths == TILTED && !self.sections.is_open() && b"XYZIJK".iter().all(is_zero) && words.any(b"PQR").is_none()
    }

    /// Ends the sections that a code (in tenths) cancels. Returns whether there were any.
    pub fn end_sections(&mut self, words: &Gathered, off: u16) -> bool {
        let turned_back = self.end_rotation(off) || self.end_mirror(words, off);
        let has_macro = self.sections.any(|cause| matches!(cause, Cause::Transform(660 | 661)));
        // G10 with words sets data.
        let sets_data = off == DATA && words.any(b"LPR").is_some();
        let mut ended = !sets_data && self.sections.close_by(off);
        if has_macro && ended && off == 670 {
            self.doubt_modes(self.span_of_block(), "the macro of G66 is not read: the modal state");
        }
        if off == MIRROR_OFF && !self.is_sinumerik() {
            // It ends the mirror images of the axes that it names (Fanuc 0i-F Operator's Manual, "Programmable Mirror Image").
            self.mirrored &= !axes(words);
            ended |= self.mirrored == 0 && self.sections.close(Cause::Transform(MIRROR_ON));
        }
        if ended {
            self.forget_all();
        }
        ended || turned_back
    }

    /// Whether the block ends the mapping onto a cylinder: `G7.1 C0`, `G107` without words, or a radius or diameter of zero.
    fn ends_mapping(&self, words: &Gathered) -> bool {
        let is_zero = |letter: u8| words.number(self.program, letter) == Some(0.0);
        let stated = |letters: &[u8]| -> Vec<u8> { letters.iter().copied().filter(|letter| words.has(*letter)).collect() };
        let radii = stated(b"QR");
        match stated(MIRROR_AXES).as_slice() {
            _ if !radii.is_empty() => radii.into_iter().all(is_zero),
            [] => true,
            [axis] => is_zero(*axis),
            _ => false,
        }
    }
}

/// Bits of the axes that the block names.
pub(super) fn axes(words: &Gathered) -> u16 {
    MIRROR_AXES.iter().enumerate().filter(|(_, letter)| words.has(**letter)).map(|(bit, _)| 1 << bit).sum()
}
