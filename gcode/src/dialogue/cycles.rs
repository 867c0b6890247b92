//! Definitions of cycles and of work frames.

use super::block::Block;
use super::functions::{CycleEffect, cycle_effect};
use super::sections::Cause;
use super::state::Interpreter;
use super::words::PathWords;
use crate::modal::{PathMode, WorkOffset};
use crate::toolpath::{Fixed, MoveKind};

impl Interpreter<'_> {
    /// CYCL DEF n or n.k. The values of old cycles stand in blocks of their own, from n.1 on.
    pub fn define_cycle(&mut self, block: &Block<'_>) {
        let text = block.words.get(2).map(|word| block.text(word)).unwrap_or_default();
        let text = String::from_utf8_lossy(&text).into_owned();
        let (number, part) = text.split_once('.').unwrap_or((&text, ""));
        let effect = number.parse().map_or(CycleEffect::Unknown, cycle_effect);
        let has_values = !part.is_empty() && part != "0";
        if !matches!(effect, CycleEffect::OnCall | CycleEffect::Dwell | CycleEffect::Tolerance | CycleEffect::Transform(_)) {
            self.lose_rotation("this cycle");
        }
        match effect {
            CycleEffect::OnCall => {}
            CycleEffect::Dwell if has_values => {
                let seconds = block.words.last().map(|word| word.value).filter(|value| value.is_finite());
                self.push_fixed(MoveKind::Dwell { seconds }, self.position, Fixed::Dwell);
            }
            CycleEffect::Tolerance if part == "1" => self.set_tolerance(block),
            CycleEffect::Shift => self.shift(block, has_values),
            CycleEffect::Transform(Cause::Rotation) if has_values => self.rotate(block),
            CycleEffect::Transform(Cause::Mirror) if has_values => self.mirror(block),
            CycleEffect::Transform(Cause::Scaling) if has_values => self.scale(block),
            CycleEffect::Transform(_) => {}
            CycleEffect::Preset => {
                self.lose_place();
                self.modal.work_offset = WorkOffset::Unpredictable;
                self.continued_preset = true;
            }
            CycleEffect::Dwell | CycleEffect::Tolerance => {}
            CycleEffect::Unknown => {
                let what = format!("CYCL DEF {number}: what it changes is not known");
                self.open(Cause::Lasting, self.span_of_block(), &what, None);
                self.lose_place();
            }
        }
    }

    /// A line behind `~`. Of those only the preset's number is read; a positioning block has none.
    pub fn continue_block(&mut self, block: &Block<'_>) {
        if self.continued_preset
            && let Some(number) = block.words.iter().find(|word| block.text(word).starts_with(b"Q339")).and(block.words.last())
            && (0.0..=9999.0).contains(&number.value)
        {
            self.modal.work_offset = WorkOffset::Extended(number.value as u16);
        }
    }

    /// CYCL DEF 32.1 T: how far the control may leave the path.
    fn set_tolerance(&mut self, block: &Block<'_>) {
        let tolerance_mm = block.value("T").map(|value| value * self.modal.units.mm());
        self.modal.path = match tolerance_mm {
            Some(value) if value > 0.0 => PathMode::Continuous { tolerance_mm, merge_mm: None },
            _ => PathMode::Default,
        };
    }

    /// CYCL DEF 7: moves the datum. Axes that it does not name keep their shift.
    fn shift(&mut self, block: &Block<'_>, has_values: bool) {
        self.lose_place();
        if has_values {
            self.apply_shift(block);
        }
    }

    /// Sets the shifts of the words behind the first three, or adds to them. Shifts that are not known open a section, which ends when all of them are
    /// stated.
    fn apply_shift(&mut self, block: &Block<'_>) {
        // The words of a positioning block follow its first word.
        let words = PathWords::of(&block.without(2), self, false);
        if words.stray.is_some() || !words.moves() {
            // A line of a table holds all axes.
            self.unknown_shifts = [true, true, true, self.names_rotary, self.names_rotary, self.names_rotary];
        }
        // Whether a shift within another frame is one of its axes depends on their order. None at all is none in every frame.
        let in_frame =
            self.sections.any(|cause| matches!(cause, Cause::Mirror | Cause::Rotation | Cause::Scaling | Cause::Plane));
        for (axis, word) in words.axes.iter().enumerate() {
            let Some(word) = word else { continue };
            let Some(value) = word.value.filter(|value| !in_frame || (*value == 0.0 && !word.incremental)) else {
                self.unknown_shifts[axis] = true;
                continue;
            };
            let unit = if axis < 3 { self.modal.units.mm() } else { 1.0_f64.to_radians() };
            let before = if word.incremental { self.modal.shift[axis] } else { 0.0 };
            self.modal.shift[axis] = before + value * unit;
            self.unknown_shifts[axis] &= word.incremental;
        }
        if self.unknown_shifts == [false; 6] {
            self.sections.close(Cause::Shift);
        } else {
            let help = "state all axes of the shift by numbers, outside of other frames";
            self.open(Cause::Shift, self.span_of_block(), "a datum shift that is not known", Some(help));
        }
    }

    /// CYCL DEF 11.1: on, or off again. Which axes it scales depends on machine parameter 7410.
    fn scale(&mut self, block: &Block<'_>) {
        if block.value("SCL") == Some(1.0) {
            self.close(Cause::Scaling);
        } else {
            self.open(Cause::Scaling, self.span_of_block(), "scaling is not interpreted", None);
            self.lose_place();
        }
    }

    /// PLANE, FUNCTION TCPM, TRANS DATUM. Returns whether the block is one of these.
    pub fn frame(&mut self, block: &Block<'_>) -> bool {
        let starts = |names: &[&str]| block.begins(names);
        if starts(&["PLANE"]) || starts(&["TRANS"]) || starts(&["FUNCTION", "RESET", "TCPM"]) {
            self.lose_rotation("another frame");
        }
        // Angles of zero are the plane that is not tilted.
        let is_untilted =
            || starts(&["PLANE", "SPATIAL"]) && ["SPA", "SPB", "SPC"].iter().all(|name| block.value(name) == Some(0.0));
        if starts(&["PLANE", "RESET"]) || is_untilted() {
            self.lose_place();
            self.close(Cause::Plane);
        } else if starts(&["PLANE"]) {
            self.open(
                Cause::Plane,
                self.span_of_block(),
                "a tilted working plane is not interpreted",
                Some("PLANE RESET ends it"),
            );
            self.lose_place();
        } else if starts(&["FUNCTION", "RESET", "TCPM"]) {
            self.close(Cause::ToolCentrePoint);
        } else if starts(&["FUNCTION", "TCPM"]) {
            self.open(Cause::ToolCentrePoint, self.span_of_block(), "tool centre point control is not interpreted", None);
            self.lose_place();
        } else if starts(&["TRANS", "DATUM", "RESET"]) {
            self.modal.shift = [0.0; 6];
            self.unknown_shifts = [false; 6];
            self.sections.close(Cause::Shift);
            self.lose_place();
        } else if starts(&["TRANS", "DATUM", "AXIS"]) {
            self.lose_place();
            self.apply_shift(block);
        } else {
            return false;
        }
        true
    }
}
