//! Names of SINUMERIK in a block: frames, sections, corners, and moves that are not interpreted.
//!
//! Source: SINUMERIK "NC programming", "Coordinate transformations (frames)", "Chamfer, rounding", "Transformations".

use super::codes::{Code, Motion};
use super::gather::Gathered;
use super::sections::Cause;
use super::state::{FeedWord, Interpreter};
use super::transforms::axes;
use crate::dialect::Dialect;
use crate::modal::{Distance, FeedMode};
use crate::position::AXIS_LETTERS;
use crate::sinumerik::names::{Name, Section};
use crate::sinumerik::scan::{is_dimension, name};
use crate::toolpath::{Feed, Fixed, Move, MoveKind, Shiftable};

/// Letters with a meaning of their own in every block.
const FREE: &[u8] = b"NSTDFH";

/// Whether a block has words by which it is not understood. `allowed`: letters that its motion takes.
pub(super) fn has_unread(words: &Gathered, allowed: impl Fn(u8) -> bool) -> bool {
    words.duplicate.is_some()
        || words.unknown.is_some()
        || words.bad_g.is_some()
        || (b'A'..=b'Z').any(|letter| words.has(letter) && !allowed(letter))
}

/// Whether a letter has a meaning in every move: an axis, the feed, the tool.
pub(super) fn is_of_every_move(letter: u8) -> bool {
    FREE.contains(&letter) || AXIS_LETTERS.contains(&letter)
}

impl Interpreter<'_> {
    pub fn is_sinumerik(&self) -> bool {
        self.options.dialect == Dialect::Sinumerik
    }

    /// Opens and ends sections by the names of a block.
    pub fn note_names(&mut self, words: &Gathered) {
        self.closes_section = false;
        for (index, name) in words.named.iter().copied() {
            let harmless =
                matches!(name, Name::Silent | Name::Holds | Name::Label | Name::Turn | Name::Compressor | Name::Absolute);
            if words.optional && !harmless {
                let help = "take the block out, or its slash or condition";
                let what = format!("{} in a block that may not run", self.quoted(index, "this"));
                self.open_section(index, &what, Cause::Lasting, Some(help));
            }
            match name {
                Name::Opens(section) => {
                    let what = self.quoted(index, "this");
                    self.open_section(index, &what, Cause::Named(section), None);
                    self.forget_all();
                }
                Name::Closes(section) => self.close_named(section),
                Name::Untilted => {
                    self.close_named(Section::Swivel);
                    // Whether it deletes a programmed shift is not known.
                    if self.shifts.local != [0.0; 6] {
                        self.open_frame(index);
                    }
                    self.forget_all();
                }
                Name::Spindle => self.modal.spindle_rpm = None,
                Name::ToothFeed => self.feed = FeedWord::Unpredictable { block: self.block },
                Name::AllCorners => self.rounds_corners = self.program.words()[index].number() != Some(0.0),
                Name::Compressor => self.warn_of_compressor(index),
                _ => {}
            }
        }
        for g in &words.g {
            match g.code {
                Code::Opens(section) => {
                    let what = self.quoted(g.index, "this");
                    self.open_section(g.index, &what, Cause::Named(section), None);
                    self.forget_all();
                }
                Code::Closes(section) => self.close_named(section),
                _ => {}
            }
        }
    }

    fn close_named(&mut self, section: Section) {
        if self.sections.close(Cause::Named(section)) {
            self.closes_section = true;
            self.forget_all();
        }
    }

    fn warn_of_compressor(&mut self, index: usize) {
        if !std::mem::replace(&mut self.compressor_noted, true) {
            let message = "the control smooths points within a tolerance from here on, and with them corrections below it";
            self.report.warning(self.span(index), message, Some("state a tolerance below the expected corrections"));
        }
    }

    /// Executes the names that use the axis words themselves. Returns whether there was one.
    pub fn apply_names(&mut self, words: &Gathered) -> bool {
        let mut taken = words.g.iter().any(|g| matches!(g.code, Code::Opens(_)));
        for (index, name) in words.named.iter().copied() {
            match name {
                Name::Translate => self.translate(words, index, false),
                Name::AddTranslate => self.translate(words, index, true),
                Name::Replace | Name::Add => self.transform(words, index, name == Name::Replace),
                // Without a section to close, the words of the block are those of a move: `X20 DIAMOF`, `F1000 FNORM G1 X8`.
                Name::Closes(_) if !self.closes_section => continue,
                Name::Opens(_) | Name::Closes(_) | Name::Untilted => {}
                Name::Cycle => {
                    self.polar.lose();
                    self.forget_all();
                }
                _ => continue,
            }
            taken = true;
        }
        taken
    }

    /// TRANS deletes the programmable frame and moves program zero to these coordinates; ATRANS adds to the frame.
    fn translate(&mut self, words: &Gathered, index: usize, adds: bool) {
        let before = self.shifts.local;
        if !adds {
            self.shifts.local = [0.0; 6];
            self.end_frame();
        }
        for axis in self.named(words) {
            match self.scaled(words, axis) {
                Some(value) => self.shifts.local[axis] += value,
                None => self.open_frame(index),
            }
        }
        if words.geometry().is_some() || words.unknown.is_some() || words.explicit_motion().is_some() {
            self.open_frame(index);
        }
        for (axis, before) in before.into_iter().enumerate() {
            self.unsettled[axis] |= self.shifts.local[axis] != before;
        }
        self.update_shift();
    }

    /// Rotation, scaling, mirroring. Without words the replacing ones delete the programmable frame. What is known is followed.
    fn transform(&mut self, words: &Gathered, index: usize, replaces: bool) {
        let has_words = words.any(b"XYZABCUVW").is_some() || words.unknown.is_some();
        let has_names = words.named.iter().any(|(_, name)| *name == Name::Angle || name.is_coordinate());
        if replaces {
            for axis in 0..6 {
                self.unsettled[axis] |= self.shifts.local[axis] != 0.0;
            }
            self.shifts.local = [0.0; 6];
            self.end_frame();
            self.update_shift();
        }
        if has_words || has_names {
            match self.known_frame(words, index) {
                Some(rotation) => {
                    let is_image = self.program.is_mirror_image(&self.program.words()[index]);
                    self.mirrored |= if is_image { axes(words) } else { 0 };
                    self.turn(Some(rotation));
                }
                None => self.open_frame(index),
            }
        }
    }

    /// The programmable frame is deleted.
    fn end_frame(&mut self) {
        self.turn(None);
        self.mirrored = 0;
        self.close_named(Section::Frame);
    }

    fn open_frame(&mut self, index: usize) {
        self.turn(None);
        self.open_section(index, "this frame", Cause::Named(Section::Frame), Some("TRANS ends it"));
        self.forget_all();
    }

    /// A statement that is not evaluated, or a subprogram that is not found: nothing is known after it.
    pub fn lose_track(&mut self, words: &Gathered) {
        if let Some(index) = words.flow.or(words.unknown) {
            let help = "put the subprogram's file beside the program";
            self.open_section(index, "this statement, or a subprogram that is not found", Cause::Lasting, Some(help));
            self.forget_all();
        }
    }

    /// Absolute words state where an axis is after its frame or its tool changed. Whether an incremental word includes the change depends on
    /// setting data (42440, 42442).
    pub fn settle(&mut self, words: &Gathered, moved: bool) {
        if words.any(b"DT").is_some() || words.has_m(self.program, &[6.0]) {
            self.unsettled = [true; 6];
        }
        if moved {
            for axis in self.named(words) {
                self.unsettled[axis] &= self.distance_of(words, axis) == Distance::Incremental;
            }
        }
    }

    /// Whether an axis word is absolute or incremental.
    pub fn distance_of(&self, words: &Gathered, axis: usize) -> Distance {
        let name = words.index(AXIS_LETTERS[axis]).map_or(Name::None, |index| self.program.words()[index].name);
        match name {
            Name::Absolute => Distance::Absolute,
            Name::Incremental => Distance::Incremental,
            _ => self.modal.distance,
        }
    }

    /// The function that states how the value of a word is meant, such as AC; empty if there is none.
    pub fn dimension(&self, index: usize) -> &[u8] {
        let of = name(self.program.text(self.program.words()[index].value_span()), 0);
        if is_dimension(of) { of } else { b"" }
    }

    /// Whether a coordinate with a name is absolute or incremental: `I1=AC(…)`, `I1=IC(…)`, or neither and as the mode says. `None` for other
    /// functions such as DC( ).
    pub fn distance_of_name(&self, index: usize) -> Option<Distance> {
        match self.dimension(index).to_ascii_uppercase().as_slice() {
            b"AC" => Some(Distance::Absolute),
            b"IC" => Some(Distance::Incremental),
            of if !of.is_empty() => None,
            _ => Some(self.modal.distance),
        }
    }

    /// Why a feed move of this block is left alone, and what is reported; `None` if it is interpreted.
    pub fn reads_not(&self, words: &Gathered, is_arc: bool) -> Option<(Fixed, &'static str)> {
        let [first, second, normal] = self.modal.plane.axes();
        let centre = b"IJK"[normal];
        let allowed = |letter: u8| match letter {
            b'I' | b'J' | b'K' => is_arc && (letter != centre || words.number(self.program, letter) == Some(0.0)),
            b'R' => is_arc,
            _ => is_of_every_move(letter),
        };
        // Full circles of a line are none.
        let turns_line = !is_arc && words.name(Name::Turn).is_some();
        let is_unread = words.geometry().is_some() || turns_line || has_unread(words, allowed);
        let per_turn = self.modal.feed_mode == FeedMode::PerRevolution && self.modal.spindle_rpm.is_none();
        if self.sections.is_open() {
            Some((Fixed::NotUnderstood, ""))
        } else if is_unread {
            Some((Fixed::NotUnderstood, "not understood in a feed move, which is left alone"))
        } else if matches!(self.feed, FeedWord::Unpredictable { .. }) || per_turn {
            Some((Fixed::RunTime, "the feed is known only when the program runs: the move is left alone"))
        } else if is_arc && [first, second].iter().any(|axis| !self.position.knows(*axis)) {
            Some((Fixed::UnknownStart, ""))
        } else {
            None
        }
    }

    /// A feed move that is left alone. Its end is known only if all its words are read.
    pub fn opaque_move(&mut self, words: &Gathered, why: (Fixed, &str), at: usize, explicit_motion: bool) {
        let is_unread = !self.is_sinumerik() && self.motion.is_some_and(|motion| self.is_not_read(words, motion));
        let start = self.position;
        let (fixed, message) = why;
        self.position = self.target(words, 1);
        if !message.is_empty() {
            self.report.warning(self.span(at), message, None);
        }
        // In a section too the end is not that of the axis words alone.
        let is_unread = is_unread || !message.is_empty();
        if (fixed == Fixed::NotUnderstood && is_unread) || words.geometry().is_some() {
            self.forget_all();
        }
        self.keep_code_of_last_arc(words.optional, explicit_motion);
        if words.is_in_machine_frame() || (self.optional_motion && !explicit_motion) {
            self.lose_named(words, start);
        }
        let feed = self.known_feed(words);
        let step = self.step(MoveKind::Line, start, Shiftable::No(fixed));
        self.moves.push(Move { feed, explicit_motion, ..step });
    }

    /// The feed of a move that is left alone, where it is known.
    pub fn known_feed(&self, words: &Gathered) -> Option<Feed> {
        let FeedWord::Value { written, mm } = self.feed else { return None };
        let mm_s = match self.modal.feed_mode {
            FeedMode::InverseTime => {
                return (words.has(b'F') && written > 0.0).then(|| Feed::Duration { seconds: 60.0 / written });
            }
            FeedMode::PerMinute => mm / 60.0,
            FeedMode::PerRevolution => mm * self.modal.spindle_rpm? / 60.0,
        };
        (mm_s > 0.0).then_some(Feed::Linear { mm_s })
    }

    /// A spline or another path that the control computes from its neighbours: the move before keeps its direction.
    /// `is_unread`: whether it has words that are not read.
    pub fn curve(&mut self, words: &Gathered, is_unread: bool, explicit_motion: bool) {
        self.fix_last_move();
        let at = words.explicit_motion().map(|(index, _)| index).or(words.any(&AXIS_LETTERS)).or(words.geometry());
        let at = at.unwrap_or_else(|| self.program.word_range(self.block).start);
        let why = if is_unread { "a path that is not interpreted: it is left alone" } else { "" };
        self.opaque_move(words, (Fixed::NotUnderstood, why), at, explicit_motion);
    }

    /// Whether the axis words of a curve are its end. LinuxCNC's `G5 X Y I J P Q` and `G5.1 X Y I J` end there ("G5 Cubic Spline", "G5.1 Quadratic
    /// Spline"); NURBS blocks (G5.2, G6.2) state control points.
    pub fn knows_end_of_curve(&self, words: &Gathered) -> bool {
        if words.geometry().is_some() || words.unknown.is_some() {
            return false;
        }
        let is_spline = words.g.iter().any(|g| matches!(g.tenths, 50 | 51) && matches!(g.code, Code::Motion(_)));
        let is_plain = !has_unread(words, |letter| is_of_every_move(letter) || b"IJPQ".contains(&letter));
        self.is_sinumerik() || (is_spline && is_plain && self.modal.distance == Distance::Absolute && !words.has(b'Z'))
    }

    /// Whether the control computes a corner at one of the ends of this block's move.
    pub fn joins_corner(&mut self, words: &Gathered) -> bool {
        let has = |wanted: Name| words.named.iter().any(|(_, name)| *name == wanted);
        let radius = words.has(b'R').then(|| words.number(self.program, b'R'));
        let is_rounded =
            self.options.dialect == Dialect::Fanuc && self.motion == Some(Motion::Line) && radius.is_some_and(|r| r != Some(0.0));
        if words.corner
            || is_rounded
            || has(Name::Corner)
            || self.rounds_corners
            || self.lacking_axis(words).or(words.drawing).is_some()
        {
            self.corner_moves = 2;
        }
        let joins = self.corner_moves > 0;
        self.corner_moves = self.corner_moves.saturating_sub(1);
        joins || self.rounds_corners || has(Name::OwnBlock)
    }

    /// RND and its like in a block of their own: whether the corner before or behind the next move is meant depends on the control.
    pub fn note_corner_alone(&mut self, words: &Gathered) {
        let is_corner = words.corner || words.named.iter().any(|(_, name)| *name == Name::Corner);
        if is_corner && words.any(&AXIS_LETTERS).is_none() && words.geometry().is_none() {
            self.fix_last_move();
            self.corner_moves = 2;
        }
    }

    /// The control computes something from the move before: it is left alone.
    pub fn fix_last_move(&mut self) {
        let last = self.moves.iter_mut().rfind(|step| !matches!(step.kind, MoveKind::Dwell { .. }));
        if let Some(last) = last.filter(|last| last.shiftable == Shiftable::Yes) {
            last.shiftable = Shiftable::No(Fixed::Adjoining);
        }
    }
}
