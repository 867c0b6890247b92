//! Sections in which the program is followed but not understood: nothing in them may be changed.
//!
//! A code that is neither understood nor known to leave path and frame alone opens a section; what is known to cancel it ends it, otherwise the program's end
//! does. After a section the place is unknown until it is stated in full.

use crate::codes::{Code, OneShot, cancels, written};
use crate::gather::Gathered;
use crate::interpret::Interpreter;

/// M codes that a program declares to change nothing of how or where the tool moves, beside those that are known to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PassiveCodes([u64; 16]);

impl PassiveCodes {
    /// Largest number of an M code.
    pub const LARGEST: u16 = 1023;

    /// The same with the code `M number`; numbers above [`Self::LARGEST`] are no codes.
    #[must_use]
    pub fn with(mut self, number: u16) -> Self {
        if let Some(bits) = self.0.get_mut(usize::from(number / 64)) {
            *bits |= 1 << (number % 64);
        }
        self
    }

    fn holds(self, number: u16) -> bool {
        self.0.get(usize::from(number / 64)).is_some_and(|bits| bits >> (number % 64) & 1 == 1)
    }
}

/// M codes without influence on path or frame: stops, spindle, coolant, tool change, clamps (ISO 6983; NIST RS274NGC, 3.6), rigid tapping, gears, doors, chip
/// conveyor, air, user relays and subprogram calls (Haas Mill Operator's Manual, M codes; Fanuc 0i Operator's Manual, auxiliary functions), inputs and outputs,
/// overrides and saving of modal states (LinuxCNC, M codes). Not among them: M21 to M23, which mirror axes on many machines, and M71 and M72, which bring back
/// modal states of before.
const PASSIVE: &[std::ops::RangeInclusive<u16>] = &[
    0..=11,
    13..=14,
    17..=17,
    19..=19,
    29..=31,
    33..=36,
    39..=39,
    41..=44,
    48..=56,
    60..=70,
    73..=73,
    75..=80,
    82..=89,
    95..=99,
    104..=105,
    109..=109,
    198..=199,
];

/// LinuxCNC's user-defined codes run a program beside the interpreter, which goes on as it was.
const USER_DEFINED: std::ops::RangeInclusive<u16> = 100..=199;

/// Statements that only speak to the operator or to look-ahead.
const SILENT: [&[u8]; 2] = [b"MSG", b"STOPRE"];

/// What opened a section.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Cause {
    /// A G code, in tenths.
    G(u16),
    /// Something that nothing is known to cancel.
    Lasting,
}

/// The sections that are open.
#[derive(Debug, Default)]
pub(crate) struct Opaque(Vec<Cause>);

impl Opaque {
    pub fn is_open(&self) -> bool {
        !self.0.is_empty()
    }

    /// Opens a section; returns whether it is a new one.
    fn open(&mut self, cause: Cause) -> bool {
        let new = !self.0.contains(&cause);
        if new {
            self.0.push(cause);
        }
        new
    }
}

/// Whether the code `off` ends what the unknown code `on` began (both in tenths).
fn ends(off: u16, on: u16) -> bool {
    match off {
        400 => matches!(on, 412..=419 | 422..=429 | 1410 | 1420),
        490 => matches!(on, 433..=439 | 2340),
        690 => matches!(on, 685..=689 | 1680),
        1130 => on == 1120,
        1690 => on == 1680,
        _ => cancels(off, on),
    }
}

impl Interpreter<'_> {
    /// Opens and ends sections by the codes of a block, before it is carried out.
    pub fn note_unknown(&mut self, words: &Gathered) {
        for g in &words.g {
            let open = self.opaque.0.len();
            self.opaque.0.retain(|cause| !matches!(cause, Cause::G(on) if ends(g.tenths, *on)));
            let ended = self.opaque.0.len() < open;
            if ended {
                self.forget_all();
            }
            if g.code == Code::Unknown && !ended {
                self.open_section(g.index, &written(g.tenths), Cause::G(g.tenths), None);
            }
        }
        for &index in &words.m {
            let number = self.program.words()[index].number().filter(|n| n.fract() == 0.0 && (0.0..1024.0).contains(n));
            match number.map(|n| n as u16) {
                Some(number) if self.is_passive(number) => {}
                Some(number) => {
                    let help = format!("give --passive M{number} if the machine does nothing with path or frame by it");
                    self.open_section(index, &format!("M{number}"), Cause::Lasting, Some(&help));
                }
                None => self.open_section(index, "this M code", Cause::Lasting, None),
            }
        }
        if let Some(index) = words.unknown {
            let text = self.program.text(self.span(index)).to_ascii_uppercase();
            if !SILENT.iter().any(|silent| text.starts_with(silent)) {
                self.open_section(index, "this statement", Cause::Lasting, None);
            }
        }
        if words.block_delete && self.options.block_delete.is_none() {
            self.note_optional(words);
        }
    }

    /// G10 L2 with R turns the coordinate system; R0 turns it back.
    pub fn note_rotation(&mut self, index: usize, angle: Option<f64>) {
        if angle == Some(0.0) {
            self.opaque.0.retain(|cause| *cause != Cause::G(100));
        } else {
            self.open_section(index, "a coordinate system turned by R", Cause::G(100), Some("R0 turns it back"));
        }
    }

    /// A block that a switch may skip: its modal codes may hold afterwards or not.
    fn note_optional(&mut self, words: &Gathered) {
        let changes = |code: &Code| match code {
            Code::Distance(distance) => *distance != self.modal.distance,
            Code::Motion(_)
            | Code::OneShot(OneShot::Dwell | OneShot::Home | OneShot::MacroCall)
            | Code::Silent
            | Code::ExactStopHere
            | Code::MachineCoordinates
            | Code::Cycle(_)
            | Code::CancelCycle => false,
            Code::Unknown | Code::SurfaceSpeed(_) | Code::ReturnLevel(_) => false,
            Code::Units(units) => *units != self.modal.units,
            Code::Plane(plane) => *plane != self.modal.plane,
            Code::WorkOffset(offset) => *offset != self.modal.work_offset,
            Code::FeedMode(mode) => *mode != self.modal.feed_mode,
            _ => true,
        };
        if let Some(g) = words.g.iter().find(|g| changes(&g.code)) {
            let what = format!("{} in a block that a switch may skip", written(g.tenths));
            self.open_section(g.index, &what, Cause::Lasting, Some("take the block out, or its slash"));
        }
    }

    fn open_section(&mut self, index: usize, what: &str, cause: Cause, help: Option<&str>) {
        if self.opaque.open(cause) {
            let until = match cause {
                Cause::G(_) => "until it is cancelled",
                Cause::Lasting => "up to the program's end",
            };
            let message = format!("{what}: what it changes is not known; the moves after it are left alone {until}");
            self.report.warning(self.span(index), message, help);
        }
    }

    fn is_passive(&self, number: u16) -> bool {
        let user = self.options.dialect == crate::dialect::Dialect::LinuxCnc && USER_DEFINED.contains(&number);
        user || self.options.passive.holds(number) || PASSIVE.iter().any(|range| range.contains(&number))
    }
}
