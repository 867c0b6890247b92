//! Poles and polar coordinates of SINUMERIK: G110, G111, G112, AP, RP. The blocks are left alone, their ends are computed.
//!
//! Source: SINUMERIK ONE, "NC programming" (6FC5398-2EP40-0BA0), "Reference point of the polar coordinates (G110, G111, G112)" and "Travel commands
//! with polar coordinates (G0, G1, G2, G3, AP, RP)"; SINUMERIK 808D, "Programming and Operating Manual (Milling)", "Polar coordinates, pole
//! definition". Where the manuals differ or are silent, the end is not determined and the position after the block is unknown.

use super::codes::{Code, Motion, PoleFrom};
use super::gather::Gathered;
use super::pole::{Polar, PolarPoint, Pole};
use super::sinumerik::{has_unread, is_of_every_move};
use super::state::Interpreter;
use crate::modal::Distance;
use crate::position::{AXIS_LETTERS, LARGEST_COORDINATE, Position};
use crate::sinumerik::names::Name;
use crate::toolpath::{Fixed, MoveKind};

/// Points closer than this, mm, are the same: a hundredth of the smallest increment of a control (10⁻⁴ mm).
const SAME_POINT_MM: f64 = 1e-6;
/// Largest polar angle, degrees ("Travel commands with polar coordinates": ± 0…360°).
const LARGEST_ANGLE_DEG: f64 = 360.0;

impl Interpreter<'_> {
    /// G110, G111, G112. The end of the move before G110 is needed where the program has it.
    pub fn set_pole(&mut self, words: &Gathered, from: PoleFrom) {
        if from == PoleFrom::Position {
            self.fix_last_move();
        }
        let (plane, shift_mm, work_offset) = (self.modal.plane, self.shift_in_plane(), self.modal.work_offset);
        let set = |centre_mm| Pole::Set { centre_mm, plane, shift_mm, work_offset };
        self.polar = Polar { pole: self.new_pole(words, from).map_or(Pole::Unknown, set), last: None };
    }

    /// The pole that the block states, mm. Dimensions (G90, G91) do not concern it.
    fn new_pole(&self, words: &Gathered, from: PoleFrom) -> Option<[f64; 2]> {
        let [first, second, _] = self.modal.plane.axes();
        let letters = [AXIS_LETTERS[first], AXIS_LETTERS[second]];
        // What other words do beside a pole is not stated.
        let is_unread = has_unread(words, |letter| letter == b'N' || letters.contains(&letter));
        let is_silent = |name: Name| matches!(name, Name::Silent | Name::Holds | Name::Label);
        let is_polar = |name: Name| matches!(name, Name::PolarAngle | Name::PolarRadius);
        let is_beside = |code: Code| matches!(code, Code::Motion(_) | Code::OneShot(_) | Code::MachineCoordinates);
        let stands_alone = words.g.iter().filter(|g| is_beside(g.code)).count() == 1
            && words.named.iter().all(|(_, name)| is_silent(*name) || is_polar(*name));
        if words.optional || self.sections.is_open() || is_unread || !stands_alone {
            return None;
        }
        let offset = match (words.name(Name::PolarAngle), words.name(Name::PolarRadius)) {
            // What G110 measures AP and RP from is described in two ways.
            (Some(angle), Some(radius)) if from != PoleFrom::Position && words.any(&letters).is_none() => {
                let is_plain = self.dimension(angle).is_empty() && self.dimension(radius).is_empty();
                let point = PolarPoint {
                    plane: self.modal.plane,
                    angle_deg: self.angle(angle).filter(|_| is_plain)?,
                    radius_mm: self.radius(radius)?,
                };
                point.about([0.0; 2])
            }
            (None, None) => {
                let is_plain =
                    |letter: u8| words.index(letter).is_some_and(|index| self.program.words()[index].name == Name::None);
                if !letters.iter().all(|letter| is_plain(*letter)) {
                    return None;
                }
                [self.scaled(words, first)?, self.scaled(words, second)?]
            }
            _ => return None,
        };
        let base = match from {
            PoleFrom::Position => {
                let is_settled = [first, second].iter().all(|axis| self.position.knows(*axis) && !self.unsettled[*axis]);
                is_settled.then(|| self.in_plane(self.position))?
            }
            PoleFrom::Zero => self.shift_in_plane(),
            PoleFrom::Pole => self.pole_mm()?,
        };
        Some([base[0] + offset[0], base[1] + offset[1]])
    }

    /// Executes a move with AP or RP. Returns whether it was one; those with other words that are not read are left to the caller.
    pub fn polar_move(&mut self, words: &Gathered, motion: Motion, explicit_motion: bool) -> bool {
        if words.name(Name::PolarAngle).or(words.name(Name::PolarRadius)).is_none() {
            return false;
        }
        let before = self.polar.last.take();
        if self.sections.is_open() || !self.reads_polar(words, motion) {
            return false;
        }
        self.polar.last = before;
        match self.polar_end(words) {
            Ok(point) => self.go_polar(words, motion, point, explicit_motion),
            Err(why) => self.go_astray(words, motion, why, explicit_motion),
        }
        true
    }

    /// Whether all words of a polar move are read: no Cartesian coordinate of the plane, no centre, no radius.
    fn reads_polar(&self, words: &Gathered, motion: Motion) -> bool {
        let [first, second, _] = self.modal.plane.axes();
        let in_plane = [AXIS_LETTERS[first], AXIS_LETTERS[second]];
        let is_other = |name: &Name| name.is_coordinate() && !matches!(name, Name::PolarAngle | Name::PolarRadius);
        motion.number().is_some()
            && !has_unread(words, |letter| is_of_every_move(letter) && !in_plane.contains(&letter))
            && !words.named.iter().any(|(_, name)| is_other(name))
    }

    /// Polar coordinates of the end, and the pole. A coordinate that is not stated, and AP=IC( ), refer to the last ones. They count only where the
    /// tool is at the point that they describe: the manuals do not say what Cartesian moves leave of them.
    fn polar_end(&self, words: &Gathered) -> Result<(PolarPoint, [f64; 2]), &'static str> {
        let pole = self.pole_mm().ok_or("the pole is not known")?;
        let plane = self.modal.plane;
        let last = || self.last_polar(pole).ok_or("the tool is not at the last polar coordinates");
        let angle_deg = match words.name(Name::PolarAngle) {
            None => last()?.angle_deg,
            Some(index) => {
                let value = self.angle(index).ok_or("this polar angle is not understood")?;
                match (self.distance_of_name(index), self.dimension(index).is_empty()) {
                    (Some(Distance::Absolute), _) => value,
                    (Some(Distance::Incremental), false) => last()?.angle_deg + value,
                    _ => return Err("what a polar angle without AC( ) and IC( ) is under G91 is not stated"),
                }
            }
        };
        let radius_mm = match words.name(Name::PolarRadius) {
            None => last()?.radius_mm,
            Some(index) => self.radius(index).ok_or("this polar radius is not understood")?,
        };
        Ok((PolarPoint { plane, angle_deg, radius_mm }, pole))
    }

    /// The last polar coordinates, if the tool is there.
    fn last_polar(&self, pole: [f64; 2]) -> Option<PolarPoint> {
        let [first, second, _] = self.modal.plane.axes();
        let last = self.polar.last.filter(|last| last.plane == self.modal.plane)?;
        let is_settled = [first, second].iter().all(|axis| self.position.knows(*axis) && !self.unsettled[*axis]);
        let (at, there) = (self.in_plane(self.position), last.about(pole));
        (is_settled && (at[0] - there[0]).hypot(at[1] - there[1]) <= SAME_POINT_MM).then_some(last)
    }

    fn go_polar(&mut self, words: &Gathered, motion: Motion, (point, pole): (PolarPoint, [f64; 2]), explicit_motion: bool) {
        let [first, second, _] = self.modal.plane.axes();
        let mut end = self.target(words, 1);
        let [at_first, at_second] = point.about(pole);
        end.set(first, at_first);
        end.set(second, at_second);
        let is_lost = words.is_in_machine_frame() || (self.optional_motion && !explicit_motion);
        self.polar.last = (!is_lost).then_some(point);
        // The end is absolute, as an absolute word is.
        self.unsettled[first] &= is_lost;
        self.unsettled[second] &= is_lost;
        if motion != Motion::Rapid {
            let kind = self.polar_path(words, motion, pole, end);
            return self.push_computed(words, end, kind, explicit_motion);
        }
        let start = self.position;
        if is_lost {
            self.forget_all();
        } else {
            self.position = end;
        }
        self.keep_code_of_last_arc(words.optional, explicit_motion);
        let fixed = if words.is_in_machine_frame() { Fixed::MachineCoordinates } else { Fixed::Rapid };
        self.push_fixed(MoveKind::Rapid, start, fixed, explicit_motion);
    }

    /// The path of a feed move: the pole is the centre of a circle.
    fn polar_path(&self, words: &Gathered, motion: Motion, pole: [f64; 2], end: Position) -> Result<MoveKind, &'static str> {
        if motion == Motion::Line {
            return Ok(MoveKind::Line);
        }
        let plane = self.modal.plane;
        let [first, second, _] = plane.axes();
        if words.name(Name::Turn).is_some() {
            return Err("full circles (TURN) about a pole are not interpreted");
        }
        if !(self.position.knows(first) && self.position.knows(second)) {
            return Err("the start of this circle is not known");
        }
        let (from, to) = (self.in_plane(self.position), self.in_plane(end));
        if (to[0] - from[0]).hypot(to[1] - from[1]) <= SAME_POINT_MM {
            return Err("whether a circle about a pole to its start is a full circle is not stated");
        }
        self.arc_in(plane, from, to, motion == Motion::ArcCounterClockwise, pole)
    }

    /// A polar move whose end is not determined.
    fn go_astray(&mut self, words: &Gathered, motion: Motion, why: &str, explicit_motion: bool) {
        self.polar.last = None;
        let message = format!("{why}: the block is left alone, and nothing is known of the position after it");
        self.report.warning(self.span_of_block(), message, Some("state X, Y and Z after it"));
        if motion == Motion::Rapid {
            let start = self.position;
            self.forget_all();
            self.keep_code_of_last_arc(words.optional, explicit_motion);
            return self.push_fixed(MoveKind::Rapid, start, Fixed::Rapid, explicit_motion);
        }
        let has_value = |name: Name| words.name(name).is_none_or(|index| self.program.words()[index].number().is_some());
        let is_stated = has_value(Name::PolarAngle) && has_value(Name::PolarRadius);
        let fixed = if is_stated { Fixed::NotUnderstood } else { Fixed::RunTime };
        self.opaque_move(words, (fixed, ""), 0, explicit_motion);
    }

    /// Value of AP, degrees.
    fn angle(&self, index: usize) -> Option<f64> {
        self.program.words()[index].number().filter(|angle| angle.abs() <= LARGEST_ANGLE_DEG)
    }

    /// Value of RP, mm: absolute and positive. Zero is not interpreted.
    fn radius(&self, index: usize) -> Option<f64> {
        let is_absolute = matches!(self.dimension(index).to_ascii_uppercase().as_slice(), b"" | b"AC");
        let radius = self.program.words()[index].number().filter(|radius| *radius > 0.0 && *radius <= LARGEST_COORDINATE)?;
        is_absolute.then_some(radius * self.modal.units.mm())
    }

    /// The active pole, mm.
    fn pole_mm(&self) -> Option<[f64; 2]> {
        match self.polar.pole {
            Pole::Unset => Some(self.shift_in_plane()),
            Pole::Set { centre_mm, plane, shift_mm, work_offset } => {
                let lasts =
                    plane == self.modal.plane && shift_mm == self.shift_in_plane() && work_offset == self.modal.work_offset;
                lasts.then_some(centre_mm)
            }
            Pole::Unknown => None,
        }
    }

    fn shift_in_plane(&self) -> [f64; 2] {
        let [first, second, _] = self.modal.plane.axes();
        [self.modal.shift[first], self.modal.shift[second]]
    }

    fn in_plane(&self, position: Position) -> [f64; 2] {
        let [first, second, _] = self.modal.plane.axes();
        [position.nominal[first], position.nominal[second]]
    }
}
