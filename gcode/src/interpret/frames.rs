//! Offsets of program zero, data input, homing and dwell: blocks whose axis words are not targets.
//!
//! Positions are in the work frame *before* G52 and G92, so these leave no jump in the path. Under a known rotation they are turned coordinates until a
//! move is recorded. If G92
//! is given at an unknown position, that position redefines the frame.

use super::codes::Motion;
use super::gather::Gathered;
use super::sections::Cause;
use super::state::Interpreter;
use crate::decimal_point::{ANGLE_INCREMENT, has_point, length_increment};
use crate::dialect::{DecimalPoint, Dialect};
use crate::modal::{Distance, WorkOffset};
use crate::position::{AXIS_LETTERS, LARGEST_COORDINATE, Position};
use crate::toolpath::{Fixed, Move, MoveKind, Shiftable};

impl Interpreter<'_> {
    /// Value of a coordinate in program units or degrees, also where it is written in increments.
    pub fn coordinate(&self, words: &Gathered, letter: u8) -> Option<f64> {
        let word = self.program.words().get(words.index(letter)?)?;
        let value = word.number()?;
        if self.options.decimal_point == DecimalPoint::Unit || has_point(self.program, word) {
            return Some(value);
        }
        let increment = if matches!(letter, b'A' | b'B' | b'C') { ANGLE_INCREMENT } else { length_increment(self.modal.units) };
        Some(value * increment)
    }

    /// Value of a word, mm or rad. `None` if it is no coordinate.
    pub fn scaled(&self, words: &Gathered, axis: usize) -> Option<f64> {
        let number = self.coordinate(words, AXIS_LETTERS[axis]).filter(|n| n.abs() <= LARGEST_COORDINATE)?;
        Some(if axis < 3 { number * self.modal.units.mm() } else { number.to_radians() })
    }

    pub fn update_shift(&mut self) {
        for axis in 0..6 {
            self.modal.shift[axis] = self.shifts.local[axis] + self.shifts.position[axis];
        }
    }

    pub fn named(&self, words: &Gathered) -> impl Iterator<Item = usize> + use<> {
        let present: [bool; 6] = std::array::from_fn(|axis| words.has(AXIS_LETTERS[axis]));
        (0..6).filter(move |axis| present[*axis])
    }

    /// G52: moves program zero to these coordinates of the work frame.
    pub fn local_shift(&mut self, words: &Gathered) {
        for axis in self.named(words) {
            let value = self.scaled(words, axis);
            // In LinuxCNC's one store the value replaces the offset of G92, which is not known after a G92 at an unknown position.
            let is_shared = self.options.dialect == Dialect::LinuxCnc;
            let replaces = is_shared
                && (std::mem::take(&mut self.shifts.relaid[axis])
                    | !std::mem::replace(&mut self.stated.position_shift[axis], true));
            // Where the dialect is a guess, so is whether the value adds to the offset of G92 or replaces it.
            let is_open = self.is_dialect_open() && (self.shifts.position[axis] != 0.0 || self.shifts.relaid[axis]);
            let took_its_place = std::mem::take(&mut self.shifts.absorbed[axis]);
            if value.is_none() || replaces || is_open || took_its_place {
                self.position.forget(axis);
            }
            let shift = match self.options.dialect {
                Dialect::Fanuc | Dialect::Sinumerik => &mut self.shifts.local[axis],
                Dialect::LinuxCnc => &mut self.shifts.position[axis],
            };
            *shift = value.unwrap_or(*shift);
        }
        self.shifts.saved = self.shifts.position;
        self.update_shift();
    }

    /// G92: assigns these coordinates to the present position. On Fanuc controls it takes the place of the G52 of these axes (NCT 99M Programmer's
    /// Manual, "Local Coordinate System"); where others keep it, a later G52 leads elsewhere, so that the position is unknown after one.
    pub fn set_position(&mut self, words: &Gathered) {
        for axis in self.named(words) {
            let local = if self.options.dialect == Dialect::Fanuc { std::mem::take(&mut self.shifts.local[axis]) } else { 0.0 };
            self.shifts.absorbed[axis] |= local != 0.0;
            let Some(value) = self.scaled(words, axis) else {
                self.position.forget(axis);
                continue;
            };
            if self.position.knows(axis) {
                self.shifts.position[axis] = self.position.nominal[axis] - value - self.shifts.local[axis];
            } else {
                self.shifts.position[axis] = -self.shifts.local[axis];
                self.shifts.relaid[axis] = true;
                self.position.set(axis, value);
            }
        }
        self.shifts.saved = self.shifts.position;
        self.update_shift();
    }

    /// G92.1 (and G92.2, which keeps the values for G92.3).
    pub fn clear_position_shift(&mut self, keep: bool) {
        if !keep {
            self.shifts.saved = [0.0; 6];
        }
        self.shifts.position = [0.0; 6];
        if std::mem::replace(&mut self.stated.position_shift, [true; 6]).contains(&false) {
            self.forget_all();
        }
        for axis in 0..6 {
            if std::mem::take(&mut self.shifts.relaid[axis]) {
                self.position.forget(axis);
            }
        }
        self.update_shift();
    }

    /// G92.3. Another program may have set the values, or another position than the present frame
    /// knows: the position is unknown, and so it is when they are cleared again.
    pub fn restore_position_shift(&mut self) {
        self.shifts.position = self.shifts.saved;
        self.shifts.relaid = [true; 6];
        self.stated.position_shift = [true; 6];
        self.forget_all();
        self.update_shift();
    }

    /// G10: the named coordinates become unknown if it changes a work offset that may be active.
    pub fn set_data(&mut self, words: &Gathered) {
        let number = |letter| words.number(self.program, letter);
        if self.options.dialect == Dialect::Fanuc {
            self.set_tool_or_parameters(words);
        }
        let sets_offset = !words.has(b'L') || number(b'L').is_none_or(|l| l == 2.0 || l == 20.0);
        if !sets_offset {
            return;
        }
        let other = match (number(b'P'), self.modal.work_offset) {
            (Some(p), WorkOffset::Standard(active)) => (1.0..=9.0).contains(&p) && p != f64::from(active),
            (Some(p), WorkOffset::Extended(active)) => (1.0..=9.0).contains(&p) && p != f64::from(active),
            _ => false,
        };
        if let Some(index) = words.index(b'R').filter(|_| self.options.dialect == Dialect::LinuxCnc || number(b'L') == Some(2.0))
        {
            self.set_rotation(words, index, other);
        }
        if other {
            return;
        }
        for axis in self.named(words).collect::<Vec<_>>() {
            self.position.forget(axis);
        }
    }

    /// G10 with other data: lengths and radii of tools (L1, L10 to L13, or P and R alone), after which the position along the tool may be another;
    /// parameters of the control (L50, L52) and what is not known, which may be anything (Fanuc 0i-F Operator's Manual, "Programmable Data Input").
    fn set_tool_or_parameters(&mut self, words: &Gathered) {
        let kind = words.number(self.program, b'L');
        let is_offset = kind == Some(2.0) || kind == Some(20.0) || kind.is_none() && self.named(words).next().is_some();
        let is_tool = match kind {
            None => words.has(b'P') || words.has(b'R'),
            Some(kind) => kind == 1.0 || (10.0..=13.0).contains(&kind),
        };
        // L3 registers the lives of tools.
        if is_offset || kind == Some(3.0) {
            return;
        }
        if is_tool {
            return self.forget_all();
        }
        let Some(index) = words.index(b'L') else { return };
        self.open_section(index, "G10 with these data", Cause::Lasting, None);
        self.forget_all();
    }

    /// G10 L2 with R rotates a coordinate system. One that is not active is noted too: it may be selected later.
    fn set_rotation(&mut self, words: &Gathered, index: usize, other: bool) {
        let number = |letter| words.number(self.program, letter);
        let (angle, stated) = (number(b'R'), number(b'P'));
        let system = match (stated, self.modal.work_offset) {
            (Some(p), _) if (1.0..=9.0).contains(&p) && p.fract() == 0.0 => Some(p as u16),
            // P0 is the active system ("G10 L2 Set Coordinate System"). On other controls it is none of them.
            (None | Some(0.0), WorkOffset::Standard(active)) if self.options.dialect == Dialect::LinuxCnc => Some(active.into()),
            _ => None,
        };
        if !other || angle != Some(0.0) || !self.rotated.is_empty() {
            self.forget_all();
        }
        self.note_rotation(index, system, angle);
    }

    /// G27 to G30: the named axes (all, if none is named) move to a fixed machine position.
    pub fn home(&mut self, words: &Gathered) {
        let start = self.position;
        if words.any(&AXIS_LETTERS).is_some() {
            for axis in self.named(words).collect::<Vec<_>>() {
                self.position.forget(axis);
            }
        } else {
            self.forget_all();
        }
        self.push_fixed(MoveKind::Home, start, Fixed::Home, false);
    }

    /// G4. Returns whether it used the axis words (Fanuc's `G4 X1.`).
    pub fn dwell(&mut self, words: &Gathered) -> bool {
        let number = |letter| words.number(self.program, letter);
        let (seconds, taken) = match self.options.dialect {
            Dialect::LinuxCnc => (number(b'P'), false),
            // F is the time, S a number of revolutions of the spindle.
            Dialect::Sinumerik if words.has(b'F') => (number(b'F'), true),
            Dialect::Sinumerik => {
                (number(b'S').zip(self.modal.spindle_rpm).filter(|(_, rpm)| *rpm > 0.0).map(|(s, rpm)| 60.0 * s / rpm), true)
            }
            Dialect::Fanuc if words.has(b'P') => (self.dwell_of_p(words), true),
            Dialect::Fanuc => (self.coordinate(words, b'X').or_else(|| self.coordinate(words, b'U')), true),
        };
        let seconds = seconds.filter(|_| self.free_exponent(words).is_none());
        // A time is in X or U. What other axis words do is not known.
        let own: &[u8] = if self.options.dialect == Dialect::Fanuc && !words.has(b'P') { b"X" } else { b"" };
        for axis in self.named(words).filter(|axis| taken && !own.contains(&AXIS_LETTERS[*axis])).collect::<Vec<_>>() {
            self.position.forget(axis);
        }
        self.push_fixed(MoveKind::Dwell { seconds }, self.position, Fixed::Dwell, false);
        taken
    }

    /// Time of a dwell in P, s: in milliseconds, with a decimal point in seconds (Haas Mill Operator's Manual, "G04 Dwell").
    fn dwell_of_p(&self, words: &Gathered) -> Option<f64> {
        let word = &self.program.words()[words.index(b'P')?];
        let unit_s = if self.program.text(word.value_span()).contains(&b'.') { 1.0 } else { 1e-3 };
        word.number().map(|time| time * unit_s)
    }

    /// Records an unmodified move that ends at the present position.
    pub fn push_fixed(&mut self, kind: MoveKind, start: Position, why: Fixed, explicit_motion: bool) {
        let step = self.step(kind, start, Shiftable::No(why));
        self.moves.push(Move { explicit_motion, ..step });
    }

    /// A move without a feed that ends at the present position.
    pub fn step(&mut self, kind: MoveKind, start: Position, shiftable: Shiftable) -> Move {
        let step = Move {
            block: self.block as u32,
            modal: self.modal_index(),
            kind,
            start,
            end: self.position,
            feed: None,
            feed_word: None,
            motion_code: self.motion.and_then(Motion::number),
            explicit_motion: false,
            shiftable,
            after_shared: self.take_shared(),
            after_stop: std::mem::take(&mut self.stopped),
        };
        self.modal.rotation.map_or(step, |rotation| step.in_work(&rotation))
    }

    /// End of a move to the axis words of the block. Incremental words are applied `repeats` times.
    pub fn target(&self, words: &Gathered, repeats: u32) -> Position {
        let mut end = self.position;
        for axis in self.named(words) {
            match (self.scaled(words, axis), self.distance_of(words, axis)) {
                (None, _) => end.forget(axis),
                (Some(value), Distance::Incremental) if self.unsettled[axis] => {
                    end.nominal[axis] += value;
                    end.forget(axis);
                }
                (Some(value), Distance::Absolute) => {
                    end.set(axis, value + self.modal.shift[axis]);
                    // It may have been a distance.
                    if self.doubts.distance {
                        end.forget(axis);
                    }
                }
                (Some(value), Distance::Incremental) => end.nominal[axis] += value * f64::from(repeats),
            }
        }
        end
    }
}
