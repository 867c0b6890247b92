//! Rotation of the working plane, CYCL DEF 10, and its mirror image, CYCL DEF 8.
//!
//! Moves are read in turned coordinates and put into the work frame when they are recorded. What is uncertain in any way is a section that is left
//! alone, and so are a rotation and an image at the same time.
//!
//! Source: HEIDENHAIN iTNC 530 "Cycle programming", "ROTATION (Cycle 10)", "MIRROR IMAGE (Cycle 8)".

use super::block::Block;
use super::sections::Cause;
use super::state::Interpreter;
use crate::modal::CutterCompensation;
use crate::position::AXIS_LETTERS;
use crate::rotation::Rotation;
use crate::word::Word;

/// Largest angle, degrees ("Cycle 10 ROTATION").
const LARGEST_ANGLE_DEG: f64 = 360.0;
/// How the mirror image ends.
const END_OF_IMAGE: &str = "CYCL DEF 8.1 without axes ends it";

impl Interpreter<'_> {
    /// CYCL DEF 10.1: a rotation about the active datum, or its end. An angle in ROT replaces the one before.
    pub fn rotate(&mut self, block: &Block<'_>) {
        if self.is_image {
            self.lose_rotation("a rotation");
        }
        self.turn(None);
        self.close(Cause::Rotation);
        match block.value("ROT") {
            Some(0.0) if block.words.len() == 4 => {}
            Some(angle) if self.may_turn(block) && block.words.len() == 4 && angle.abs() <= LARGEST_ANGLE_DEG => {
                self.turn(Some(Rotation::about(self.modal.plane, self.datum_mm(), angle)));
            }
            _ => self.open(Cause::Rotation, self.span_of_block(), "this rotation is not interpreted", None),
        }
    }

    /// CYCL DEF 8.1: a mirror image of axes of the plane about the active datum, or without axes its end.
    pub fn mirror(&mut self, block: &Block<'_>) {
        let axes = &block.words[block.words.len().min(3)..];
        if axes.is_empty() {
            if std::mem::take(&mut self.is_image) {
                self.turn(None);
            }
            self.close(Cause::Mirror);
            return;
        }
        match self.named_image(axes, block) {
            Some(image) if self.may_turn(block) && self.modal.rotation.is_none() => {
                self.turn(Some(image));
                self.is_image = true;
            }
            _ => {
                self.open(Cause::Mirror, self.span_of_block(), "this mirror image is not interpreted", Some(END_OF_IMAGE));
                self.lose_place();
            }
        }
    }

    /// The image about the datum in the axes of the plane that the words name, each once and without a value.
    fn named_image(&self, axes: &[Word], block: &Block<'_>) -> Option<Rotation> {
        let [first, second, _] = self.modal.plane.axes();
        let datum_mm = self.datum_mm();
        let mut about_mm = [None, None];
        for word in axes {
            let text = block.text(word);
            let axis = [first, second].iter().position(|axis| text == [AXIS_LETTERS[*axis]])?;
            if about_mm[axis].replace(datum_mm[axis]).is_some() {
                return None;
            }
        }
        Some(Rotation::mirror(self.modal.plane, about_mm))
    }

    /// The active datum in the axes of the plane.
    fn datum_mm(&self) -> [f64; 2] {
        let [first, second, _] = self.modal.plane.axes();
        [self.modal.shift[first], self.modal.shift[second]]
    }

    /// Whether nothing that is active may act together with a rotation or an image in a way that is not known. A rotary axis may carry the part.
    fn may_turn(&self, block: &Block<'_>) -> bool {
        let is_optional = block.is_optional && self.options.block_delete.is_none();
        !self.sections.is_open() && self.modal.cutter == CutterCompensation::Off && !self.names_rotary && !is_optional
    }

    /// Begins or ends the rotation. The position is not known until it is stated: all axes of the plane have to be moved for it to act.
    fn turn(&mut self, rotation: Option<Rotation>) {
        let before = std::mem::replace(&mut self.modal.rotation, rotation);
        if let Some(before) = before {
            self.position = before.in_work(self.position);
        }
        if let Some(rotation) = rotation {
            self.position = rotation.out_of_work(self.position);
        }
        if before.or(rotation).is_some() {
            self.lose_place();
        }
    }

    /// What a rotation or an image is from here on is not known: `what` may change it.
    pub fn lose_rotation(&mut self, what: &str) {
        if self.modal.rotation.is_some() {
            self.turn(None);
            let (cause, under, help) = match std::mem::take(&mut self.is_image) {
                true => (Cause::Mirror, "a mirror image", END_OF_IMAGE),
                false => (Cause::Rotation, "a rotation", "CYCL DEF 10.1 ROT+0 ends it"),
            };
            self.open(cause, self.span_of_block(), &format!("{what} under {under} is not interpreted"), Some(help));
        }
    }

    /// Turned coordinates are known both or not at all: a machine axis that moves alone changes both.
    pub fn pair_turned(&mut self) {
        if let Some(rotation) = self.modal.rotation {
            let [first, second, _] = rotation.plane().axes();
            self.position.keep_pair(first, second);
        }
    }
}
