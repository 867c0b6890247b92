//! Rotation of the working plane, CYCL DEF 10.
//!
//! Moves are read in turned coordinates and put into the work frame when they are recorded. A rotation that is uncertain in any way is a section that
//! is left alone.

use super::block::Block;
use super::sections::Cause;
use super::state::Interpreter;
use crate::modal::CutterCompensation;
use crate::rotation::Rotation;

/// Largest angle, degrees ("Cycle 10 ROTATION").
const LARGEST_ANGLE_DEG: f64 = 360.0;

impl Interpreter<'_> {
    /// CYCL DEF 10.1: a rotation about the active datum, or its end. An angle in ROT replaces the one before.
    pub fn rotate(&mut self, block: &Block<'_>) {
        self.turn(None);
        self.close(Cause::Rotation);
        match block.value("ROT") {
            Some(0.0) if block.words.len() == 4 => {}
            Some(angle) if self.may_rotate(block) && angle.abs() <= LARGEST_ANGLE_DEG => {
                let [first, second, _] = self.modal.plane.axes();
                let centre_mm = [self.modal.shift[first], self.modal.shift[second]];
                self.turn(Some(Rotation::about(self.modal.plane, centre_mm, angle)));
            }
            _ => self.open(Cause::Rotation, self.span_of_block(), "this rotation is not interpreted", None),
        }
    }

    /// Whether nothing but the angle stands in the block, and nothing that is active may act together with it in a way that is not known. A rotary
    /// axis may carry the part.
    fn may_rotate(&self, block: &Block<'_>) -> bool {
        let is_optional = block.is_optional && self.options.block_delete.is_none();
        let is_alone = !self.sections.is_open() && self.modal.cutter == CutterCompensation::Off && !self.names_rotary;
        is_alone && !is_optional && block.words.len() == 4
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

    /// What a rotation is from here on is not known: `what` may change it.
    pub fn lose_rotation(&mut self, what: &str) {
        if self.modal.rotation.is_some() {
            self.turn(None);
            let what = format!("{what} under a rotation is not interpreted");
            self.open(Cause::Rotation, self.span_of_block(), &what, Some("CYCL DEF 10.1 ROT+0 ends it"));
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
