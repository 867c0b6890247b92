//! Calls of subprograms and macros that are not found, and what is known after them; ends of the program.

use super::codes::{Code, Motion};
use super::doubts::Doubts;
use super::gather::Gathered;
use super::sections::Cause;
use super::state::Interpreter;
use crate::dialect::{Dialect, Macros};
use crate::word::Span;

impl Interpreter<'_> {
    /// Executes the codes at the end of the block: calls, and the end of the program.
    pub fn apply_stops(&mut self, words: &Gathered) {
        let (calls, ends) = match self.options.dialect {
            Dialect::Fanuc => (&[97.0, 98.0, 198.0][..], &[2.0, 30.0, 99.0]),
            Dialect::LinuxCnc => (&[98.0][..], &[2.0, 30.0, 99.0]),
            Dialect::Sinumerik => (&[][..], &[2.0, 17.0, 30.0]),
        };
        if words.has_m(self.program, calls) || self.calls_by_l(words) {
            self.call(self.span_of_block());
        } else if words.has_m(self.program, ends) && !words.optional {
            self.ended = true;
        }
    }

    /// Whether L calls a subprogram: in every block of SINUMERIK, elsewhere in a block without codes and coordinates (Fadal). In a canned cycle
    /// it repeats.
    fn calls_by_l(&self, words: &Gathered) -> bool {
        let is_alone = words.g.is_empty() && words.m.is_empty() && words.any(b"XYZABCIJKUVWRQFSTDH").is_none();
        words.has(b'L') && (self.is_sinumerik() || (is_alone && self.cycle.is_none()))
    }

    /// A subprogram or macro that is not found. The position afterwards is unknown, and so are the modal groups that it may have changed.
    pub fn call(&mut self, span: Span) {
        self.doubt_modes(span, "a subprogram is called that is not found: its moves are not read, and the modal state");
    }

    /// What a macro may have changed is unknown. `what` begins the message.
    pub fn doubt_modes(&mut self, span: Span, what: &str) {
        self.forget_all();
        if self.options.macros == Macros::Keep {
            return self.report.warning(span, format!("{what} is taken to be the same afterwards"), None);
        }
        if self.modal.rotation.is_some() {
            let first = self.program.word_range(self.block).start;
            self.lose_rotation(first, "a subprogram that is not found", "put its file beside the program");
        }
        let until = if self.is_sinumerik() {
            self.sections.open(Cause::Lasting);
            "the program ends"
        } else {
            self.doubts =
                Doubts { distance: true, work_offset: self.whole.states_work_offset, plane: true, motion: true, feed: true };
            self.optional_motion = true;
            "G90 or G91, the plane, the work offset, the feed and the position are stated again"
        };
        let help = "put its file beside the program, or give --macros keep if it leaves modes and coordinate system as they were";
        self.report.warning(span, format!("{what} after it is not known: moves are left alone until {until}"), Some(help));
    }

    /// Whether a macro before may have changed what this block's move depends on.
    pub fn is_doubtful(&self) -> bool {
        self.doubts.concern(matches!(self.motion, Some(Motion::ArcClockwise | Motion::ArcCounterClockwise)))
    }

    /// Whether anything may have been changed by a macro and is not stated again.
    pub fn has_doubts(&self) -> bool {
        self.doubts.concern(true)
    }

    /// The block states modes again.
    pub fn settle_doubts(&mut self, words: &Gathered) {
        if words.optional || !self.has_doubts() {
            return;
        }
        for g in &words.g {
            match g.code {
                Code::Distance(_) => self.doubts.distance = false,
                Code::Plane(_) => self.doubts.plane = false,
                // Positions stated before may be of another coordinate system.
                Code::WorkOffset(_) | Code::ExtendedWorkOffset if self.doubts.work_offset => {
                    self.doubts.work_offset = false;
                    self.forget_all();
                }
                Code::Motion(_) | Code::Cycle(_) => self.doubts.motion = false,
                _ => {}
            }
        }
        self.doubts.feed &= !words.has(b'F');
    }
}
