//! Rotations by known angles: G68 with centre and angle, ROT and AROT about the normal of the plane. Scalings by known factors: SCALE and ASCALE with
//! one factor for both axes of the plane. Mirror images: `mirrors.rs`.
//!
//! Moves are read in turned coordinates and put into the work frame when they are recorded. After a rotation begins or ends, the coordinates of its
//! plane are unknown until one block states both. A rotation that is uncertain in any way is a section that is left alone.
//!
//! Source: Fanuc 0i-F Operator's Manual (B-64604EN), "Coordinate System Rotation (G68, G69)"; SINUMERIK "NC programming", "Programmable rotation (ROT,
//! AROT, RPL)", "Programmable scaling factor (SCALE, ASCALE)".

use super::codes::{Code, OneShot, written};
use super::gather::{GWord, Gathered};
use super::sections::Cause;
use super::state::Interpreter;
use super::transforms::MIRROR_ON;
use crate::decimal_point::has_point;
use crate::execution::Ran;
use crate::modal::{CutterCompensation, Distance, ToolLength};
use crate::plane::Plane;
use crate::position::{AXIS_LETTERS, LARGEST_COORDINATE};
use crate::rotation::Rotation;
use crate::sinumerik::names::{Name, Section};

/// G68, in tenths.
const ROTATION_ON: u16 = 680;
/// G69, in tenths.
const ROTATION_OFF: u16 = 690;
/// Largest angle, degrees (both manuals).
const LARGEST_ANGLE_DEG: f64 = 360.0;
/// Scale factors that are followed, all that act together: shrinkage and oversize. The rounding of a written coordinate grows with them.
const FACTORS: std::ops::RangeInclusive<f64> = 0.5..=2.0;

impl Interpreter<'_> {
    /// Begins, changes or ends the rotation.
    pub fn turn(&mut self, rotation: Option<Rotation>) {
        let before = std::mem::replace(&mut self.modal.rotation, rotation);
        if let Some(before) = before {
            self.position = before.in_work(self.position);
        }
        if let Some(rotation) = rotation {
            self.position = rotation.out_of_work(self.position);
        }
        for turned in [before, rotation].into_iter().flatten() {
            let [first, second, normal] = turned.plane().axes();
            self.position.forget(first);
            self.position.forget(second);
            if turned.scales_normal() {
                self.position.forget(normal);
            }
            self.polar.lose();
        }
    }

    /// Ends the rotation of G68. Returns whether there was one.
    pub fn end_rotation(&mut self, off: u16) -> bool {
        let ends = off == ROTATION_OFF && self.modal.rotation.is_some() && self.mirrored == 0 && !self.is_sinumerik();
        if ends {
            self.turn(None);
        }
        ends
    }

    /// The rotation that a block with G68 states: about two absolute coordinates of the plane by an angle, and nothing else in the block.
    pub fn stated_rotation(&self, words: &Gathered, g: &GWord) -> Option<Rotation> {
        let of_block = words.g.iter().filter(|other| other.index != g.index);
        let (mut plane, mut distance) = (self.modal.plane, self.modal.distance);
        for other in of_block {
            match other.code {
                Code::Plane(stated) => plane = stated,
                Code::Distance(stated) => distance = stated,
                _ => return None,
            }
        }
        let [first, second, _] = plane.axes();
        let letters = [AXIS_LETTERS[first], AXIS_LETTERS[second]];
        let is_plain = self.is_plain(words) && states_only(words, &[letters[0], letters[1], b'R', b'N']);
        // Whether a shift is turned too is not stated.
        let is_shifted = [first, second].iter().any(|axis| self.modal.shift[*axis] != 0.0 || self.shifts.relaid[*axis]);
        if g.tenths != ROTATION_ON || distance != Distance::Absolute || !is_plain || is_shifted || !self.may_turn_frame() {
            return None;
        }
        let centre = |letter: u8| self.coordinate(words, letter).filter(|value| value.abs() <= LARGEST_COORDINATE);
        let centre_mm = [centre(letters[0])?, centre(letters[1])?].map(|value| value * self.modal.units.mm());
        let word = &self.program.words()[words.index(b'R')?];
        // Without a decimal point it may count thousandths of a degree.
        let angle =
            word.number().filter(|angle| angle.abs() <= LARGEST_ANGLE_DEG && (has_point(self.program, word) || *angle == 0.0));
        Some(Rotation::about(plane, centre_mm, angle?))
    }

    /// The rotation, scaling or mirror image that a block with ROT, SCALE, MIRROR or their additive forms (the word `index`) leads to, where nothing
    /// else stands in the block.
    pub fn known_frame(&self, words: &Gathered, index: usize) -> Option<Rotation> {
        let is_other =
            |(at, name): &(usize, Name)| *at != index && !matches!(name, Name::Angle | Name::Label | Name::Silent | Name::Holds);
        if !words.g.is_empty() || words.named.iter().any(is_other) || !self.is_plain(words) || !self.may_turn_frame() {
            return None;
        }
        let frame = match self.program.text(self.span(index)).to_ascii_uppercase().as_slice() {
            b"ROT" | b"AROT" => self.frame_rotation(words)?,
            b"SCALE" | b"ASCALE" => self.frame_scaling(words)?,
            b"MIRROR" | b"AMIRROR" => self.frame_mirror(words)?,
            _ => return None,
        };
        let frame = match self.modal.rotation {
            None => frame,
            Some(before) if before.plane() == self.modal.plane => before.then(&frame),
            Some(_) => return None,
        };
        frame.factors().iter().all(|factor| FACTORS.contains(factor)).then_some(frame)
    }

    /// By RPL, or about the axis that is normal to the plane. The zero of the programmable frame stays.
    fn frame_rotation(&self, words: &Gathered) -> Option<Rotation> {
        let [first, second, normal] = self.modal.plane.axes();
        let normal = AXIS_LETTERS[normal];
        let angle = match (words.name(Name::Angle), words.index(normal)) {
            (Some(angle), None) if states_only(words, b"N") => angle,
            (None, Some(angle)) if states_only(words, &[normal, b'N']) => angle,
            _ => return None,
        };
        let word = &self.program.words()[angle];
        let angle_deg =
            word.number().filter(|angle| angle.abs() <= LARGEST_ANGLE_DEG && matches!(word.name, Name::None | Name::Angle))?;
        Some(Rotation::about(self.modal.plane, [self.modal.shift[first], self.modal.shift[second]], angle_deg))
    }

    /// By the same factor in both axes of the plane: arcs stay arcs. The zero of the programmable frame stays.
    fn frame_scaling(&self, words: &Gathered) -> Option<Rotation> {
        let plane = self.modal.plane;
        if words.name(Name::Angle).is_some() || !states_only(words, b"XYZN") {
            return None;
        }
        let factor = |axis: usize| -> Option<f64> {
            let Some(index) = words.index(AXIS_LETTERS[axis]) else { return Some(1.0) };
            let word = &self.program.words()[index];
            word.number().filter(|factor| *factor > 0.0 && word.name == Name::None)
        };
        let [first, second, normal] = plane.axes();
        let factors = [factor(first)?, factor(second)?, factor(normal)?];
        let centre_mm = [first, second, normal].map(|axis| self.modal.shift[axis]);
        (factors[0] == factors[1]).then(|| Rotation::scaling(plane, centre_mm, [factors[0], factors[2]]))
    }

    /// Whether the block states nothing but known values of these letters, where nothing else is active that may act on a mirror image.
    pub fn states_only_known(&self, words: &Gathered, letters: &[u8]) -> bool {
        self.is_plain(words) && states_only(words, letters) && self.may_turn_frame()
    }

    /// Whether a block runs for certain and has no words without a meaning.
    fn is_plain(&self, words: &Gathered) -> bool {
        let unread = [words.unknown, words.duplicate, words.bad_g, words.assignment, words.flow];
        unread.iter().all(Option::is_none) && !words.optional && !words.corner && words.m.is_empty()
    }

    /// Whether nothing that is active may act together with a rotation in a way that is not known. A rotary axis may carry the part.
    fn may_turn_frame(&self) -> bool {
        self.runs_in_order()
            && !self.sections.is_open()
            && !self.has_doubts()
            && self.cycle.is_none()
            && self.modal.cutter == CutterCompensation::Off
            && self.modal.tool_length != ToolLength::TipControl
            && !self.whole.names_rotary
    }

    /// Opens a section, up to the end of the rotation, where the block holds a code whose effect in turned coordinates is not certain.
    pub fn guard_rotation(&mut self, words: &Gathered) {
        let Some(rotation) = self.modal.rotation else { return };
        let ends = words.g.iter().any(|g| g.tenths == ROTATION_OFF) && !self.is_sinumerik() && self.mirrored == 0;
        if ends || self.ends_known_mirror(words) {
            return;
        }
        let code = words.g.iter().find(|g| !self.keeps_rotation(g.code, rotation.plane()));
        let name = || words.named.iter().find(|(_, name)| matches!(name, Name::Opens(_) | Name::Untilted));
        let help = match self.mirrored {
            _ if self.is_sinumerik() => "TRANS ends it",
            0 => "G69 ends the rotation",
            _ => "G50.1 with its axes ends the mirror image",
        };
        if let Some(g) = code {
            let what = if g.is_named() { "this".to_owned() } else { written(g.tenths) };
            self.lose_rotation(g.index, &what, help);
        } else if let Some((index, _)) = name() {
            self.lose_rotation(*index, "this", help);
        } else if !self.runs_in_order() {
            let first = self.program.word_range(self.block).start;
            self.lose_rotation(
                first,
                "what runs in another order than that of the lines,",
                "give --expand: it writes the program without",
            );
        }
    }

    /// What a rotation is from here on is not known.
    pub fn lose_rotation(&mut self, index: usize, what: &str, help: &str) {
        self.turn(None);
        let (cause, under) = match self.mirrored {
            _ if self.is_sinumerik() => (Cause::Named(Section::Frame), "a rotation, scaling or mirror image"),
            0 => (Cause::Transform(ROTATION_ON), "a rotation"),
            _ => (Cause::Transform(MIRROR_ON), "a mirror image"),
        };
        self.open_section(index, &format!("{what} under {under}"), cause, Some(help));
        self.forget_all();
    }

    /// Whether the block runs once, and after the blocks with feed moves that stand before it.
    fn runs_in_order(&self) -> bool {
        self.ran == Ran::Once && self.fed_block.is_none_or(|last| self.block > last)
    }

    /// Whether a code is certain not to change a rotation in this plane.
    fn keeps_rotation(&self, code: Code, plane: Plane) -> bool {
        match code {
            Code::Plane(stated) => stated == plane,
            Code::Units(units) => units == self.modal.units,
            Code::ToolLength(length) => length != ToolLength::TipControl,
            Code::OneShot(one_shot) => matches!(one_shot, OneShot::Dwell | OneShot::Home),
            Code::Motion(motion) => motion.is_of_frame(),
            Code::Cycle(_)
            | Code::CancelCycle
            | Code::Distance(_)
            | Code::ArcDistance(_)
            | Code::FeedMode(_)
            | Code::Cutter(_)
            | Code::Path(_)
            | Code::ReturnLevel(_)
            | Code::SurfaceSpeed(_)
            | Code::ExactStopHere
            | Code::MachineCoordinates
            | Code::Silent => true,
            _ => false,
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

/// Whether the block has no letters but these (and G, M).
fn states_only(words: &Gathered, letters: &[u8]) -> bool {
    (b'A'..=b'Z').all(|letter| !words.has(letter) || letters.contains(&letter))
}
