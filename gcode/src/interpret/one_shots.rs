//! Codes that use the axis words of their block themselves, and blocks whose axis words are not understood.

use super::GEOMETRY;
use super::codes::{AxisWords, Code, Motion, OneShot, axis_words, has_axis_words, written};
use super::gather::{GWord, Gathered};
use super::sections::has_end;
use super::state::Interpreter;
use crate::toolpath::{Fixed, MoveKind};

impl Interpreter<'_> {
    /// Codes that use the axis words themselves. Returns whether there was one.
    pub(super) fn apply_one_shots(&mut self, words: &Gathered) -> bool {
        let mut taken = false;
        for g in &words.g {
            taken |= self.apply_one_shot(words, g);
        }
        taken
    }

    /// Returns whether the code took the axis words.
    fn apply_one_shot(&mut self, words: &Gathered, g: &GWord) -> bool {
        match g.code {
            Code::OneShot(OneShot::Dwell) => return self.dwell(words),
            Code::OneShot(OneShot::SetData) => self.set_data(words),
            Code::OneShot(OneShot::Home) => self.home(words),
            Code::OneShot(OneShot::LocalShift) => self.local_shift(words),
            Code::OneShot(OneShot::SetPosition) => self.set_position(words),
            Code::OneShot(OneShot::MacroCall) => self.call(self.span(g.index)),
            Code::OneShot(OneShot::ToolOffset) => self.forget_all(),
            Code::OneShot(OneShot::Data) | Code::ModalMacroOn | Code::CylinderMapping => {}
            Code::OneShot(OneShot::Pole(from)) => self.set_pole(words, from),
            Code::OneShot(OneShot::HolePattern) => {
                self.leave_unread(words, g.index, "holes of a pattern are not read: the position after them is not known");
            }
            Code::OneShot(OneShot::Unread) => {
                // It may change the corner before it, and the motion code: blocks without one are left alone too.
                self.fix_last_move();
                self.leave_path_unread(words, g);
                self.motion = Some(Motion::Curve);
            }
            Code::OneShot(OneShot::Pocket) => self.leave_path_unread(words, g),
            Code::TransformOn if has_axis_words(g.tenths) => return words.explicit_motion().is_none(),
            Code::ClearPositionShift => {
                self.clear_position_shift(false);
                return false;
            }
            Code::SuspendPositionShift => {
                self.clear_position_shift(true);
                return false;
            }
            Code::RestorePositionShift => {
                self.restore_position_shift();
                return false;
            }
            _ => return false,
        }
        true
    }

    /// Whether a code of the block has the axis words, or may have them: they are no target of a move then.
    pub(super) fn keeps_axis_words(&mut self, words: &Gathered) -> bool {
        // R is the retract level of a cycle.
        if words.any(GEOMETRY).is_none() && !(self.cycle.is_some() && words.has(b'R')) {
            return false;
        }
        let states_motion = words.explicit_motion().is_some();
        let of = |g: &GWord| axis_words(g.code, g.tenths, self.options.dialect, states_motion, |letter| words.has(letter));
        if let Some(g) = words.g.iter().find(|g| of(g) == AxisWords::Unknown && !self.names_mirror(g)) {
            // It may change the corner before it.
            if g.code == Code::Unknown && !has_end(g.tenths) {
                self.fix_last_move();
            }
            let message =
                format!("what the axis words beside {} do is not known: nor is the position after them", written(g.tenths));
            self.leave_unread(words, g.index, &message);
            return true;
        }
        words.g.iter().any(|g| of(g) == AxisWords::Data || self.names_mirror(g))
    }

    /// A block that may move the tool and is left alone. The position and, where the block states one, the motion code are unknown afterwards.
    fn leave_unread(&mut self, words: &Gathered, index: usize, message: &str) {
        self.report.warning(self.span(index), message, None);
        self.forget_all();
        let states_motion = words.explicit_motion().is_some();
        self.optional_motion |= states_motion;
        self.keep_code_of_last_arc(words.optional, states_motion);
        self.push_fixed(MoveKind::Line, self.position, Fixed::NotUnderstood, states_motion);
    }

    /// A block whose path is not interpreted.
    fn leave_path_unread(&mut self, words: &Gathered, g: &GWord) {
        let message = format!("the path of {} is not read: the position after it is not known", written(g.tenths));
        self.leave_unread(words, g.index, &message);
    }
}
