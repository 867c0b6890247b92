//! Mirror images that are known: G51.1 with absolute coordinates of the axes of the plane, until G50.1 names the same axes.
//!
//! They are followed as rotations are (`rotations.rs`). Source: Fanuc 0i-F Operator's Manual (B-64604EN), "Programmable Mirror Image (G50.1, G51.1)". Images
//! of SINUMERIK (`MIRROR X0`) depend on machine data (10610 `MIRROR_REF_AX`, Function Manual K2) and are left alone.

use super::gather::{GWord, Gathered};
use super::state::Interpreter;
use super::transforms::{MIRROR_OFF, MIRROR_ON, axes};
use crate::decimal_point::has_point;
use crate::modal::Distance;
use crate::position::{AXIS_LETTERS, LARGEST_COORDINATE};
use crate::rotation::Rotation;

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
