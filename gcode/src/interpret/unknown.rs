//! Codes and statements that are not interpreted. They open sections that are not changed.

use super::codes::{Code, Motion, OneShot, written};
use super::gather::{GWord, Gathered};
use super::sections::Cause;
use super::state::{FeedWord, Interpreter};
use crate::dialect::Dialect;
use crate::execution::Ran;
use crate::passive::{changes_nothing, is_user_defined};
use crate::sinumerik::signs::{SINUMERIK_HELP, is_likely};
use crate::toolpath::{Fixed, MoveKind};
use crate::word::{Word, WordKind};

/// Statements for operator messages and look-ahead only.
const SILENT: [&[u8]; 2] = [b"MSG", b"STOPRE"];

/// Where a section ends whose end is not found.
const TO_END: &str = "up to the program's end";

/// A command of Grbl.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Grbl {
    /// `$H`, `$HX` (homing), or `$X` (unlock, after which the position may be lost).
    Homing,
    /// Shows settings or states, or resumes.
    View,
}

impl Interpreter<'_> {
    /// Opens and ends sections by the codes of a block, before the block is executed.
    pub fn note_unknown(&mut self, words: &Gathered) {
        self.guard_rotation(words);
        for g in &words.g {
            let ended = self.end_sections(words, g.tenths);
            self.note_transform(words, g);
            self.note_other_control(words, g);
            let is_unknown = g.code == Code::Unknown || g.tenths == 1130 && self.is_work_offset_of_haas(words);
            if is_unknown && !ended && !self.ends_fixture_offset(words, g.tenths) {
                let cause = if self.is_sinumerik() { Cause::Lasting } else { Cause::G(g.tenths) };
                self.open_section(g.index, &written(g.tenths), cause, None);
            }
        }
        for &index in &words.m {
            let number = self.program.words()[index].number().filter(|n| n.fract() == 0.0 && (0.0..1024.0).contains(n));
            match number.map(|n| n as u16) {
                Some(number) if self.is_return_level(number, words) => {
                    let what = format!("M{number} beside a cycle may change the level to which it returns");
                    self.open_section(index, &what, Cause::Lasting, None);
                }
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
            let command = self.grbl_command();
            if command == Some(Grbl::Homing) {
                self.forget_all();
                self.push_fixed(MoveKind::Home, self.position, Fixed::Home, false);
            } else if command.is_none()
                && !self.is_program_number()
                && !self.is_malformed_move(words)
                && !SILENT.iter().any(|silent| text.starts_with(silent))
            {
                let is_likely = !self.is_sinumerik() && is_likely(self.program.text(self.span_of_block()));
                let what = self.quoted(index, "this statement");
                self.open_section(index, &what, Cause::Lasting, is_likely.then_some(SINUMERIK_HELP));
            }
        }
        if let Some(index) = words.blocks_behind {
            let help = "write one block a line, or the comment in parentheses";
            self.open_section(index, "words behind `;` may be a block of their own", Cause::Lasting, Some(help));
        }
        if let Some(index) = words.assignment {
            self.open_section(index, "this parameter of the control", Cause::Lasting, None);
        }
        if let Some(index) = words.bad_g.filter(|_| self.is_sinumerik()) {
            self.open_section(index, "this G code", Cause::Lasting, None);
        }
        self.note_names(words);
        if words.optional {
            self.note_optional(words);
        }
        self.note_optional_modes(words);
    }

    /// G54.2 P0 ends the dynamic fixture offset of G54.2 (Fanuc 30i Operator's Manual, "Rotary Table Dynamic Fixture Offset").
    fn ends_fixture_offset(&mut self, words: &Gathered, tenths: u16) -> bool {
        let ends = self.options.dialect == Dialect::Fanuc && tenths == 542 && words.number(self.program, b'P') == Some(0.0);
        if ends {
            self.sections.close(Cause::G(tenths));
            self.forget_all();
        }
        ends
    }

    /// Whether the block is a feed move whose only words that are not read are coordinates with values that are none, such as `X22,5` or `X--5`: they concern
    /// the move alone.
    fn is_malformed_move(&self, words: &Gathered) -> bool {
        let motion = match words.explicit_motion() {
            Some((_, Code::Motion(motion))) => Some(motion),
            Some(_) => None,
            None => self.motion.filter(|_| self.cycle.is_none()),
        };
        let feeds = matches!(motion, Some(Motion::Line | Motion::ArcClockwise | Motion::ArcCounterClockwise));
        let is_plain = words.m.is_empty() && words.g.iter().all(|g| matches!(g.code, Code::Motion(_)));
        if self.options.dialect != Dialect::Fanuc || !feeds || !is_plain || is_likely(self.program.text(self.span_of_block())) {
            return false;
        }
        let mut behind_coordinate = false;
        self.program.block_words(self.block).iter().all(|word| {
            let text = self.program.text(word.span);
            let first = text.first().map_or(0, u8::to_ascii_uppercase);
            let is_coordinate = b"XYZABCIJKR".contains(&first);
            let is_tail = || text.iter().all(|byte| byte.is_ascii_digit() || b"=+-.,#".contains(byte));
            match word.kind {
                WordKind::Comment => true,
                WordKind::Number | WordKind::Expression => {
                    behind_coordinate = is_coordinate;
                    is_coordinate || word.kind == WordKind::Number && b"GNF".contains(&first)
                }
                WordKind::Unknown => {
                    let is_bare = is_coordinate && text.len() == 1;
                    let reads = is_bare || behind_coordinate && is_tail();
                    behind_coordinate |= is_bare;
                    reads
                }
                _ => false,
            }
        })
    }

    /// Whether the block is `:0815`, a program number in the ISO code of tapes, or `<NAME>` (Fanuc 0i-F Operator's Manual, "Program Number", "Program Name").
    fn is_program_number(&self) -> bool {
        let text = self.program.text(self.span_of_block());
        let text = text.split(|byte| b";(".contains(byte)).next().unwrap_or_default().trim_ascii();
        let digits = text.strip_prefix(b":").unwrap_or_default();
        let is_number = !digits.is_empty() && digits.iter().all(u8::is_ascii_digit);
        let name = text.strip_prefix(b"<").and_then(|name| name.strip_suffix(b">")).unwrap_or_default();
        let is_name = !name.is_empty() && name.iter().all(|byte| byte.is_ascii_alphanumeric() || b"-+_.".contains(byte));
        self.options.dialect == Dialect::Fanuc && (is_number || is_name)
    }

    /// The command of Grbl that stands alone in the block; the modal state stays as it is (Grbl v1.1, "Commands").
    fn grbl_command(&self) -> Option<Grbl> {
        let text = self.program.text(self.span_of_block());
        let text = text.split(|byte| b";(".contains(byte)).next().unwrap_or_default().trim_ascii().to_ascii_uppercase();
        match text.as_slice() {
            _ if self.options.dialect != Dialect::Fanuc => None,
            b"$X" => Some(Grbl::Homing),
            [b'$', b'H', axes @ ..] => axes.iter().all(|axis| b"XYZABC".contains(axis)).then_some(Grbl::Homing),
            b"$" | b"$$" | b"$#" | b"$G" | b"$I" | b"$N" | b"?" | b"~" => Some(Grbl::View),
            _ => None,
        }
    }

    /// A feed and a motion code of an optional block are uncertain until another block states them.
    fn note_optional_modes(&mut self, words: &Gathered) {
        let optional = words.optional;
        let is_motion = |code: &Code| matches!(code, Code::Motion(_) | Code::Cycle(_) | Code::CancelCycle);
        if let Some(g) = words.g.iter().find(|g| is_motion(&g.code)) {
            let same = self.motion.is_some_and(|motion| g.code == Code::Motion(motion));
            // The end of cycles states no motion.
            let states = g.code != Code::CancelCycle || self.motion.is_some();
            self.optional_motion =
                if states { optional && (self.optional_motion || !same) } else { self.optional_motion || optional };
            self.optional_since_code = optional;
        }
        if words.has(b'F') {
            let same = matches!(self.feed, FeedWord::Value { written, .. } if words.number(self.program, b'F') == Some(written));
            self.optional_feed = optional && (self.optional_feed || !same);
        }
    }

    /// Opens a section at the rotation of a coordinate system, `None` if it is not known which. The section ends when all are turned back.
    pub fn note_rotation(&mut self, index: usize, system: Option<u16>, angle: Option<f64>) {
        if angle != Some(0.0) {
            self.rotated.push(system);
            self.open_section(index, "a coordinate system turned by R", Cause::G(100), Some("R0 turns it back"));
        } else if system.is_some() {
            self.rotated.retain(|turned| *turned != system);
            if self.rotated.is_empty() {
                self.sections.close(Cause::G(100));
            }
        }
    }

    /// An E that no code of the block takes: the exponent of a number, which controls do not read (`P1E9`), or a word without a known meaning. What
    /// the block does is not known.
    pub fn note_exponent(&mut self, words: &Gathered) {
        // In a feed move it is an error.
        let Some(index) = self.free_exponent(words).filter(|_| !self.report.has_errors()) else { return };
        self.forget_all();
        let help = "write numbers without an exponent";
        self.open_section(index, "an E that belongs to no code of its block", Cause::Lasting, Some(help));
    }

    /// Index of an E that no code of the block takes.
    pub fn free_exponent(&self, words: &Gathered) -> Option<usize> {
        let takes = |code: Code| match code {
            Code::OneShot(of) => matches!(of, OneShot::MacroCall | OneShot::Pocket | OneShot::Unread),
            Code::Motion(motion) => {
                !matches!(motion, Motion::Rapid | Motion::Line | Motion::ArcClockwise | Motion::ArcCounterClockwise)
            }
            Code::Silent | Code::Unknown | Code::Cycle(_) | Code::ModalMacroOn => true,
            _ => false,
        };
        // Outputs have a number or a value in E; codes of the builder may have anything.
        let is_output =
            |index: &usize| self.program.words()[*index].number().is_none_or(|n| (62.0..=68.0).contains(&n) || n >= 100.0);
        let is_taken =
            self.is_sinumerik() || self.cycle.is_some() || words.g.iter().any(|g| takes(g.code)) || words.m.iter().any(is_output);
        words.index(b'E').filter(|_| !is_taken)
    }

    /// Words of another control's geometry: R, Q, I, J or K without an axis under G0 or G1 (polar coordinates, chamfers), and A, B or C of axes
    /// that the machine lacks (angle of a line, chamfer). Whether and where the tool moves is not known. `axes_taken`: a code of the block has its axis
    /// words.
    pub fn note_foreign_geometry(&mut self, words: &Gathered, axes_taken: bool) {
        let is_line = matches!(self.motion, Some(Motion::Rapid | Motion::Line)) && self.cycle.is_none();
        let is_motion = |code: Code| matches!(code, Code::Motion(Motion::Rapid | Motion::Line) | Code::Distance(_));
        let is_plain = words.m.is_empty() && words.g.iter().all(|g| is_motion(g.code)) && words.unknown.is_none();
        // Mazak's G61.1 ,K states how closely corners are followed.
        let is_accuracy = words.g.iter().any(|g| g.tenths == 611) && words.any(b"XYZABCUVW").is_none();
        let (index, what) = if let Some(index) = words.drawing.filter(|_| !is_accuracy) {
            (index, "the end of this line follows from a dimension of the drawing, which is not read")
        } else if let Some(index) = self.lacking_axis(words).filter(|_| !axes_taken) {
            (index, "the machine has no such axis: whether this is an angle or a chamfer is not known")
        } else if self.is_sinumerik() || !is_line || !is_plain || self.sections.is_open() {
            return;
        } else if let Some(index) = words.any(b"RQIJK").filter(|_| words.any(b"XYZABCUVW").is_none()) {
            (index, "a word of another control's geometry: whether the tool moves is not known")
        } else {
            return;
        };
        self.forget_all();
        self.corner_moves = self.corner_moves.max(1);
        self.report.warning(
            self.span(index),
            format!("{what}; nor is the position after it"),
            Some("state all coordinates after it"),
        );
    }

    /// Index of a word A, B or C of an axis that the machine lacks, in a line (Fanuc and its like).
    pub fn lacking_axis(&self, words: &Gathered) -> Option<usize> {
        let is_line = match words.explicit_motion() {
            Some((_, code)) => code == Code::Motion(Motion::Line),
            None => self.motion == Some(Motion::Line),
        };
        let letters = b"ABC".iter().zip(self.options.rotary_axes).filter(|(_, has)| !has);
        let lacking = letters.filter_map(|(letter, _)| words.index(*letter)).min();
        lacking.filter(|_| self.options.dialect == Dialect::Fanuc && is_line)
    }

    /// U, V and W move an axis parallel to X, Y or Z, or are increments of X, Y, Z (Fanuc, G code system A).
    /// Which of them is not known, so the coordinate is not known afterwards. Beside a dwell U is its time, beside a macro call an argument.
    pub fn note_parallel_axes(&mut self, words: &Gathered) {
        let takes_u = |code: Code| {
            matches!(
                code,
                Code::OneShot(OneShot::Dwell | OneShot::MacroCall | OneShot::Data | OneShot::Pole(_)) | Code::ModalMacroOn
            )
        };
        if words.g.iter().any(|g| takes_u(g.code)) {
            return;
        }
        for (axis, letter) in [b'U', b'V', b'W'].into_iter().enumerate() {
            let Some(index) = words.index(letter) else { continue };
            self.position.forget(axis);
            let message = "what U, V and W move is not known: nor is the position of X, Y or Z after them";
            self.report.warning(self.span(index), message, Some("state the coordinate after it"));
        }
    }

    /// A block that a switch may skip: its modal codes may be active afterwards or not.
    fn note_optional(&mut self, words: &Gathered) {
        let changes = |code: &Code| match code {
            Code::Distance(distance) => *distance != self.modal.distance,
            Code::Motion(_)
            | Code::OneShot(OneShot::Dwell | OneShot::Home | OneShot::MacroCall | OneShot::Data | OneShot::Pole(_))
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
            let (what, help) = match self.ran {
                Ran::Perhaps => ("in a block that may not run", "take the block out of the branch or loop"),
                _ => ("in a block that a switch may skip", "state whether it runs: --block-delete on or off"),
            };
            self.open_section(g.index, &format!("{} {what}", written(g.tenths)), Cause::Lasting, Some(help));
        }
    }

    /// A word in quotes, or `otherwise` where it is long.
    pub fn quoted(&self, index: usize, otherwise: &str) -> String {
        let text = String::from_utf8_lossy(self.program.text(self.span(index)));
        if (1..=20).contains(&text.trim().len()) { format!("`{}`", text.trim()) } else { otherwise.to_owned() }
    }

    pub fn open_section(&mut self, index: usize, what: &str, cause: Cause, help: Option<&str>) {
        self.polar.lose();
        if self.sections.open(cause) {
            let why = match cause {
                Cause::Transform(_) => "coordinates are not those of the path",
                Cause::G(_) | Cause::Named(_) | Cause::Lasting => "what it changes is not known",
            };
            self.unended.push((cause, self.report.len()));
            let message = format!("{what}: {why}; the moves after it are left alone {TO_END}");
            self.report.warning(self.span(index), message, help);
        }
    }

    /// Completes the warnings of the sections that end in this block.
    pub fn report_ends(&mut self) {
        let (sections, report, line) = (&self.sections, &mut self.report, self.block + 1);
        self.unended.retain(|(cause, index)| {
            let is_open = sections.any(|open| open == cause);
            if !is_open {
                report.amend(*index, TO_END, &format!("up to line {line}"));
            }
            is_open
        });
    }

    /// Whether G113 may be one of Haas's work offsets G110 to G129: G112, which it ends elsewhere, does not occur, and no other mode is ended beside it or
    /// before any motion.
    fn is_work_offset_of_haas(&self, words: &Gathered) -> bool {
        let begins = |word: &Word| word.is(b'G') && [112.0, 12.1].contains(&word.value);
        let ends = |g: &GWord| {
            matches!(g.code, Code::Cutter(_) | Code::ToolLength(_) | Code::CancelCycle | Code::TransformOff) && g.tenths != 1130
        };
        let is_safety = words.g.iter().any(ends) || self.motion.is_none() && words.any(b"XYZABC").is_none();
        self.options.dialect == Dialect::Fanuc && !is_safety && !self.program.words().iter().any(begins)
    }

    /// Whether an M code may state the return level of a cycle: M52 the upper limit, M53 the level of G71, M54 the plane R (Okuma, "Fixed cycles").
    fn is_return_level(&self, number: u16, words: &Gathered) -> bool {
        let has_cycle = || self.cycle.is_some() || words.g.iter().any(|g| matches!(g.code, Code::Cycle(_)));
        let is_declared = self.options.passive.holds(number);
        self.options.dialect == Dialect::Fanuc && matches!(number, 52..=54) && !is_declared && has_cycle()
    }

    fn is_passive(&self, number: u16) -> bool {
        let user = self.options.dialect == Dialect::LinuxCnc && is_user_defined(number);
        // Subprogram calls of other controls.
        let is_call = self.is_sinumerik() && matches!(number, 97..=99 | 198);
        user || self.options.passive.holds(number) || (changes_nothing(number) && !is_call)
    }
}
