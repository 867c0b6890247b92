//! Modal codes and the words F, S, T.

use super::codes::{Code, Motion, OneShot, PathCode};
use super::gather::Gathered;
use super::sinumerik_codes::{feed_mode_of_speed, feed_units};
use super::state::{FeedWord, Interpreter};
use crate::decimal_point::has_point;
use crate::dialect::{DecimalPoint, Dialect};
use crate::modal::{CutterCompensation, FeedMode, PathMode, ToolLength, Units, WorkOffset};
use crate::position::AXIS_LETTERS;

impl Interpreter<'_> {
    /// Applies the modal words of the block in the order of a control, before any motion.
    pub fn apply_settings(&mut self, words: &Gathered) {
        // Units and feed mode come before F, whatever their order in the block.
        for g in &words.g {
            match g.code {
                Code::Units(units) => {
                    self.modal.units = units;
                    let of_feeds = if self.is_sinumerik() { feed_units(g.tenths, self.options.units) } else { units };
                    self.modal.feed_unit_mm = of_feeds.mm();
                    self.units_stated = true;
                }
                Code::FeedMode(mode) => self.set_feed_mode(mode),
                Code::SurfaceSpeed(on) => {
                    self.set_surface_speed(on);
                    if let Some(mode) = feed_mode_of_speed(g.tenths).filter(|_| self.is_sinumerik()) {
                        self.set_feed_mode(mode);
                    }
                }
                _ => {}
            }
        }
        // The F and S of a dwell and of a limit are not modal.
        let own = |code: Code| matches!(code, Code::OneShot(OneShot::Dwell | OneShot::Data | OneShot::Pole(_)));
        if !words.g.iter().any(|g| own(g.code)) {
            self.read_feed(words);
            self.read_spindle_and_tool(words);
        } else if !self.is_sinumerik() {
            self.read_beside_dwell(words);
        }
        for g in &words.g {
            self.apply_setting(words, g.code, g.tenths);
        }
    }

    fn set_feed_mode(&mut self, mode: FeedMode) {
        if mode != self.modal.feed_mode {
            self.modal.feed_mode = mode;
            self.feed = FeedWord::Unset;
        }
    }

    fn set_surface_speed(&mut self, on: bool) {
        if on {
            self.modal.spindle_rpm = None;
        }
    }

    /// F and S beside G4. LinuxCNC reads them as in any block. On other controls they may be the time of the dwell.
    fn read_beside_dwell(&mut self, words: &Gathered) {
        if self.options.dialect == Dialect::LinuxCnc && words.has(b'P') {
            self.read_feed(words);
            self.read_spindle_and_tool(words);
            return;
        }
        if let Some(index) = words.index(b'F') {
            let message =
                "F beside a dwell: whether it is the feed is not known; the moves after it are left alone up to the next F";
            self.report.warning(self.span(index), message, Some("--dialect sinumerik reads it as the time of the dwell"));
            self.unclear_feed = true;
        }
        if words.any(b"PXU").is_some() || !words.has(b'S') {
            self.read_spindle_and_tool(words);
        } else {
            self.modal.spindle_rpm = None;
        }
    }

    fn read_feed(&mut self, words: &Gathered) {
        let Some(index) = words.index(b'F') else { return };
        self.unclear_feed = false;
        self.feed = match self.program.words()[index].number().map(|written| written * self.feed_increment(index)) {
            Some(written) if self.modal.feed_mode == FeedMode::InverseTime => FeedWord::Value { written, mm: written },
            Some(written) => FeedWord::Value { written, mm: written * self.modal.feed_unit_mm },
            None => FeedWord::Unpredictable { block: self.block },
        };
    }

    /// Unit of an F without a decimal point: 1 mm/min, 0.01 in/min, 0.01 mm/rev, 0.0001 in/rev where
    /// numbers count increments (Fanuc 0i-F Operator's Manual, "Feed Functions").
    fn feed_increment(&self, index: usize) -> f64 {
        let counts = self.options.decimal_point == DecimalPoint::LeastIncrement;
        match (self.modal.feed_mode, self.modal.units) {
            _ if !counts || has_point(self.program, &self.program.words()[index]) => 1.0,
            (FeedMode::PerMinute, Units::Mm) | (FeedMode::InverseTime, _) => 1.0,
            (FeedMode::PerMinute, Units::Inch) | (FeedMode::PerRevolution, Units::Mm) => 0.01,
            (FeedMode::PerRevolution, Units::Inch) => 0.0001,
        }
    }

    fn read_spindle_and_tool(&mut self, words: &Gathered) {
        if words.has(b'S') {
            let surface_speed = words.g.iter().any(|g| g.code == Code::SurfaceSpeed(true));
            self.modal.spindle_rpm = if surface_speed { None } else { words.number(self.program, b'S') };
        }
        if words.has(b'T') {
            let number = words.number(self.program, b'T');
            self.modal.tool = number.filter(|n| (0.0..=f64::from(u32::MAX)).contains(n)).map(|n| n as u32);
        }
    }

    fn apply_setting(&mut self, words: &Gathered, code: Code, tenths: u16) {
        match code {
            Code::Distance(distance) => self.modal.distance = distance,
            Code::ArcDistance(distance) => {
                self.modal.arc_distance = distance;
                self.arc_distance_stated = true;
            }
            Code::Plane(plane) => self.modal.plane = plane,
            Code::Cutter(cutter) => self.set_cutter(words, cutter),
            Code::ReturnLevel(level) => self.modal.return_level = level,
            Code::ToolLength(length) => self.set_tool_length(length),
            Code::OneShot(OneShot::ToolOffset) => {
                self.modal.tool_length = ToolLength::On;
                self.tool_offset_stated = true;
            }
            Code::WorkOffset(_) if self.selects_further_offset(words) => self.set_work_offset(WorkOffset::Unpredictable),
            Code::WorkOffset(offset) => self.set_work_offset(offset),
            Code::ExtendedWorkOffset => {
                let takes_p = |code: Code| matches!(code, Code::Path(_) | Code::OneShot(_) | Code::ModalMacroOn | Code::Silent);
                // The P of G54 may belong to another code of the block; what it does beside G55 to G59 is not known.
                let is_own = matches!(tenths, 541 | 1540)
                    || (tenths == 540 && words.m.is_empty() && !words.g.iter().any(|g| takes_p(g.code)));
                let number = words.number(self.program, b'P').filter(|_| is_own);
                let number = number.filter(|n| (1.0..=999.0).contains(n) && n.fract() == 0.0);
                self.set_work_offset(number.map_or(WorkOffset::Unpredictable, |n| WorkOffset::Extended(n as u16)));
            }
            Code::Path(path) => self.set_path(words, path),
            Code::CancelCycle => {
                self.cycle = None;
                if self.options.dialect == Dialect::LinuxCnc {
                    self.motion = None;
                }
            }
            _ => {}
        }
    }

    /// After G40 the tool is beside the contour by its radius. LinuxCNC takes the axes of the plane from
    /// there ("Cutter Compensation", G40). On Fanuc controls the next move in the plane takes the radius
    /// back, that of the block with G40 if it has one (0i-F Operator's Manual, "Offset Mode Cancel").
    fn set_cutter(&mut self, words: &Gathered, cutter: CutterCompensation) {
        let plane = &self.modal.plane.axes()[..2];
        let leaves = cutter == CutterCompensation::Off && self.modal.cutter != CutterCompensation::Off;
        let taken_back = self.options.dialect != Dialect::LinuxCnc && plane.iter().any(|axis| words.has(AXIS_LETTERS[*axis]));
        if leaves && !taken_back {
            plane.iter().for_each(|axis| self.position.forget(*axis));
        }
        self.modal.cutter = cutter;
    }

    fn set_tool_length(&mut self, length: ToolLength) {
        let first = !std::mem::replace(&mut self.stated.tool_length, true);
        let unchanged = !first && length == ToolLength::Off && self.modal.tool_length == ToolLength::Off;
        let tip = ToolLength::TipControl;
        // Between axis and tip programming the same position has different coordinates.
        if (length == tip) != (self.modal.tool_length == tip) {
            (0..3).for_each(|axis| self.position.forget(axis));
        }
        self.modal.tool_length = length;
        // The same position has another Z. LinuxCNC counts by it at once, other controls from the next Z word on.
        if !unchanged {
            self.position.forget(2);
            // G43.1 and G43.2 may have stated offsets of any axis.
            if std::mem::take(&mut self.tool_offset_stated) {
                self.forget_all();
            }
        }
    }

    /// Tool and pallet changes move axes to places of the machine builder's (Haas Mill Operator's Manual, M06: Z goes home), and another tool
    /// has other offsets: the position is unknown until it is stated.
    pub fn forget_by_tool(&mut self, words: &Gathered) {
        let edge = if self.is_sinumerik() { words.any(b"DT").is_some() } else { words.has(b'H') };
        if self.changes_tool(words) || edge && self.is_sinumerik() || self.selects_length_by_d(words) {
            self.forget_all();
        } else if edge {
            self.position.forget(2);
        }
    }

    /// Whether the block changes the tool or the pallet.
    pub fn changes_tool(&self, words: &Gathered) -> bool {
        let changes = if self.options.dialect == Dialect::Fanuc { &[6.0, 50.0, 60.0][..] } else { &[6.0, 60.0] };
        words.has_m(self.program, changes)
    }

    /// Whether D may select a tool's length, as on SINUMERIK, NUM and Fagor, in a program that may be of one of them: it is no radius of G41 or G42, and
    /// no G43 states a length.
    fn selects_length_by_d(&self, words: &Gathered) -> bool {
        let is_radius = self.modal.cutter != CutterCompensation::Off || words.g.iter().any(|g| matches!(g.code, Code::Cutter(_)));
        let takes_d =
            |code: Code| matches!(code, Code::OneShot(_) | Code::Cycle(_) | Code::ModalMacroOn | Code::Silent | Code::Unknown);
        self.options.dialect == Dialect::Fanuc
            && words.has(b'D')
            && self.whole.is_guessed
            && !self.whole.states_tool_length
            && !is_radius
            && !words.g.iter().any(|g| takes_d(g.code))
    }

    /// Whether another word of the block may select a further work offset, as J and H do beside G54 on some controls, and no code of it takes
    /// that word.
    fn selects_further_offset(&self, words: &Gathered) -> bool {
        let takes_words = |code: Code| {
            matches!(
                code,
                Code::Motion(_)
                    | Code::Cycle(_)
                    | Code::Path(_)
                    | Code::OneShot(_)
                    | Code::ModalMacroOn
                    | Code::Silent
                    | Code::Unknown
            )
        };
        let is_arc = matches!(self.motion, Some(Motion::ArcClockwise | Motion::ArcCounterClockwise));
        let letters: &[u8] = if is_arc && words.any(&AXIS_LETTERS).is_some() { b"ELQ" } else { b"EIJKLQR" };
        self.options.dialect == Dialect::Fanuc
            && words.any(letters).is_some()
            && words.m.is_empty()
            && !words.g.iter().any(|g| takes_words(g.code))
    }

    fn set_work_offset(&mut self, offset: WorkOffset) {
        let first = !std::mem::replace(&mut self.stated.work_offset, true);
        if first || offset != self.modal.work_offset || offset == WorkOffset::Unpredictable {
            self.modal.work_offset = offset;
            self.forget_all();
        }
    }

    fn set_path(&mut self, words: &Gathered, path: PathCode) {
        let length = |letter| words.number(self.program, letter).map(|value| value * self.modal.units.mm());
        self.modal.path = match path {
            PathCode::ExactPath => PathMode::ExactPath,
            PathCode::ExactStop => PathMode::ExactStop,
            PathCode::Continuous => PathMode::Continuous { tolerance_mm: length(b'P'), merge_mm: length(b'Q') },
        };
    }
}
