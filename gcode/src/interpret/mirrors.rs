//! Mirror images that are known: G51.1 with absolute coordinates of the axes of the plane, until G50.1 names the same axes; MIRROR and AMIRROR of
//! axes of the plane, until TRANS or another frame that replaces it.
//!
//! They are followed as rotations are (`rotations.rs`). Source: Fanuc 0i-F Operator's Manual (B-64604EN), "Programmable Mirror Image (G50.1, G51.1)";
//! SINUMERIK "NC programming", "Programmable mirroring (MIRROR, AMIRROR)", and Function Manual K2. An image of SINUMERIK is about the zero of the
//! programmable frame. Machine data 10610 (`MIRROR_REF_AX`) maps it onto an image of another axis and a rotation by 180°, which is the same. By machine data
//! 10612 (`MIRROR_TOGGLE`) a control either does not evaluate the value of an axis, or ends the image of an axis with the value 0. A program in which every
//! value is 0 is for the first kind: for the other kind it would have no image at all.

use super::gather::{GWord, Gathered};
use super::state::Interpreter;
use super::transforms::{MIRROR_OFF, MIRROR_ON, axes};
use crate::decimal_point::has_point;
use crate::modal::Distance;
use crate::position::{AXIS_LETTERS, LARGEST_COORDINATE};
use crate::rotation::Rotation;
use crate::sinumerik::names::Name;

impl Interpreter<'_> {
    /// The mirror image that a block with G51.1 states: of absolute coordinates of the plane, with a decimal point or 0, and nothing else in the block.
    pub fn stated_mirror(&self, words: &Gathered, g: &GWord) -> Option<Rotation> {
        let [first, second, _] = self.modal.plane.axes();
        let letters = [AXIS_LETTERS[first], AXIS_LETTERS[second]];
        // Whether a shift is mirrored too is not stated.
        let is_shifted = [first, second].iter().any(|axis| self.modal.shift[*axis] != 0.0 || self.shifts.relaid[*axis]);
        if g.tenths != MIRROR_ON
            || words.g.len() > 1
            || self.modal.distance != Distance::Absolute
            || is_shifted
            || self.mirrored != 0
            || self.modal.rotation.is_some()
            || !self.states_only_known(words, &[letters[0], letters[1], b'N'])
            || words.any(&letters).is_none()
        {
            return None;
        }
        let about = |letter: u8| -> Option<Option<f64>> {
            let Some(index) = words.index(letter) else { return Some(None) };
            let word = &self.program.words()[index];
            let value = word.number().filter(|value| value.abs() <= LARGEST_COORDINATE)?;
            // Without a decimal point it may count increments.
            (has_point(self.program, word) || value == 0.0).then_some(Some(value * self.modal.units.mm()))
        };
        Some(Rotation::mirror(self.modal.plane, [about(letters[0])?, about(letters[1])?]))
    }

    /// The mirror image of a block with MIRROR or AMIRROR: of axes of the plane, none of which is mirrored already, with values that mean the same on
    /// every control.
    pub fn frame_mirror(&self, words: &Gathered) -> Option<Rotation> {
        let [first, second, _] = self.modal.plane.axes();
        let letters = [AXIS_LETTERS[first], AXIS_LETTERS[second]];
        if self.mirrored != 0 || words.any(&letters).is_none() || !self.states_only_known(words, &[letters[0], letters[1], b'N'])
        {
            return None;
        }
        let about = |axis: usize| -> Option<Option<f64>> {
            let Some(index) = words.index(AXIS_LETTERS[axis]) else { return Some(None) };
            let word = &self.program.words()[index];
            let value = word.number().filter(|_| word.name == Name::None)?;
            (value != 0.0 || !self.whole.mirrors_by_value).then(|| Some(self.modal.shift[axis]))
        };
        Some(Rotation::mirror(self.modal.plane, [about(first)?, about(second)?]))
    }

    /// Ends the known mirror image where G50.1 names all its axes. Returns whether it did.
    pub fn end_mirror(&mut self, words: &Gathered, off: u16) -> bool {
        let ends = off == MIRROR_OFF && self.is_mirror_known() && axes(words) == self.mirrored && words.g.len() == 1;
        if ends {
            self.mirrored = 0;
            self.turn(None);
            self.ended_mirror = Some(self.block);
        }
        ends
    }

    /// Whether a known mirror image is active.
    pub fn is_mirror_known(&self) -> bool {
        self.mirrored != 0 && self.modal.rotation.is_some() && !self.is_sinumerik()
    }

    /// Whether the block ends a known mirror image: its axis words name the axes.
    pub fn names_mirror(&self, g: &GWord) -> bool {
        g.tenths == MIRROR_OFF && self.ended_mirror == Some(self.block)
    }

    /// Whether a block ends the known mirror image.
    pub fn ends_known_mirror(&self, words: &Gathered) -> bool {
        self.is_mirror_known()
            && words.g.len() == 1
            && words.g.iter().any(|g| g.tenths == MIRROR_OFF)
            && axes(words) == self.mirrored
            && !words.optional
    }
}
