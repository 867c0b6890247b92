//! Motion blocks: rapids, feed moves and canned cycles.

use super::codes::{Code, Motion};
use super::gather::Gathered;
use super::state::{FeedWord, Interpreter};
use crate::acting::{acts_alike, takes_p};
use crate::cycle::{Cycle, CycleState};
use crate::dialect::Dialect;
use crate::execution::Ran;
use crate::modal::{CutterCompensation, Distance, FeedMode};
use crate::position::{AXIS_LETTERS, LARGEST_COORDINATE, Position};
use crate::sinumerik::signs::is_likely;
use crate::split::{is_split_before, is_splittable};
use crate::toolpath::{Feed, Fixed, Move, MoveKind, Shiftable};

/// So many moves a program may have before it states a motion code.
const MOST_BEFORE_A_CODE: usize = 8;

/// The slowest feed of a cut, mm/s, and the longest move below it, s.
const SLOWEST_MM_S: f64 = 1.0 / 60.0;
const LONGEST_S: f64 = 600.0;

impl Interpreter<'_> {
    /// Notes the motion code that the block states.
    pub fn state_motion(&mut self, words: &Gathered) {
        match words.explicit_motion() {
            Some((_, Code::Motion(motion))) => {
                self.motion = Some(motion);
                self.cycle = None;
            }
            Some((_, Code::Cycle(code))) => {
                self.open_cycle(code);
                // LinuxCNC has one motion group: no code is active after G80.
                if self.options.dialect == Dialect::LinuxCnc {
                    self.motion = None;
                }
            }
            _ => {}
        }
    }

    /// Executes the motion that the axis words of the block command.
    pub fn apply_motion(&mut self, words: &Gathered) {
        self.state_motion(words);
        let explicit = words.explicit_motion();
        let machine = words.g.iter().find(|g| g.code == Code::MachineCoordinates).map(|g| g.index);
        let is_arc = matches!(self.motion, Some(Motion::ArcClockwise | Motion::ArcCounterClockwise));
        let axes = words.any(&AXIS_LETTERS).or_else(|| if is_arc { words.any(b"IJK") } else { None });
        let axes = axes.or_else(|| words.geometry());
        let unknown = words.unknown.filter(|index| self.may_be_geometry(*index) || axes.is_some() || self.may_jump());
        let feeds = matches!(self.motion, Some(Motion::Line | Motion::ArcClockwise | Motion::ArcCounterClockwise));
        // A feed move is left alone there, also where no word of it is read: `X=5`.
        let is_unread_feed = unknown.is_some() && feeds && self.cycle.is_none() && !self.is_sinumerik();
        match unknown {
            Some(index) if is_unread_feed && self.may_jump() && !self.sections.transforms() => {
                return self.refuse_statement(words, index);
            }
            Some(_) if !is_unread_feed => self.forget_all(),
            _ => {}
        }
        let axes = axes.or(unknown.filter(|_| is_unread_feed));
        if let Some(cycle) = self.cycle {
            match machine {
                Some(index) => self.report.error(self.span(index), "G53 cannot go with a canned cycle", None),
                None => self.run_cycle(words, cycle, explicit.is_some()),
            }
            return;
        }
        let Some(first) = axes else {
            // Alone it takes the tool length off on Okuma, and the offsets until G54 on NUM.
            if machine.is_some() {
                self.forget_all();
            }
            return;
        };
        // G1 is the reset state of most SINUMERIK controls, but machine data decide.
        let Some(motion) = self.motion.or(self.is_sinumerik().then_some(Motion::Curve)) else {
            return self.move_without_code(words, first, machine.is_some());
        };
        if let (Some(index), true, false) = (machine, is_arc, self.is_sinumerik()) {
            self.report.error(self.span(index), "G53 goes with G0 and G1 only", None);
            return;
        }
        let explicit_motion = explicit.is_some();
        self.in_corner = self.joins_corner(words);
        if self.polar_move(words, motion, explicit_motion) {
            return;
        }
        match motion {
            Motion::Rapid => self.travel(words, MoveKind::Rapid, Fixed::Rapid, machine.is_some(), explicit_motion),
            Motion::Probe => self.travel(words, MoveKind::Probe, Fixed::Probing, true, explicit_motion),
            Motion::CircleThroughPoint => self.circle_through_point(words, explicit_motion),
            Motion::TangentialCircle => self.tangential_circle(words, explicit_motion),
            Motion::Curve => {
                let is_unread = !self.knows_end_of_curve(words);
                self.curve(words, is_unread, explicit_motion);
                // A spline leads into the move behind it with that one's direction.
                self.corner_moves = self.corner_moves.max(u8::from(self.is_sinumerik()));
            }
            Motion::Thread => self.travel(words, MoveKind::Thread, Fixed::Threading, false, explicit_motion),
            // A rigid tap returns to its start.
            Motion::RigidTap => self.push_fixed(MoveKind::Thread, self.position, Fixed::Threading, explicit_motion),
            Motion::Line | Motion::ArcClockwise | Motion::ArcCounterClockwise => {
                let at = explicit.map_or(first, |(index, _)| index);
                self.feed_move(words, motion, at, machine.is_some(), explicit_motion);
            }
        }
    }

    /// Axis words while no motion code is known to be active.
    fn move_without_code(&mut self, words: &Gathered, first: usize, machine: bool) {
        let (straight, help) = (words.any(b"IJKR").is_none(), "write G0, G1, G2 or G3 in this block or before it");
        if self.optional_motion {
            // A block that may not run stated another one, perhaps a cycle.
            let start = self.position;
            self.lose_named(words, start);
            self.forget_all();
            self.keep_code_of_last_arc(words.optional, false);
            self.push_fixed(MoveKind::Rapid, start, Fixed::RunTime, false);
        } else if self.moves.len() < MOST_BEFORE_A_CODE
            && straight
            && self.options.dialect != Dialect::LinuxCnc
            && self.states_motion()
        {
            // G0 or G1, by a setting of the control: both end there (Fanuc's parameter 3402; Haas: G0).
            let message = "no motion code is active yet: G0 or G1, as the control is set; the move is left alone";
            self.report.warning(self.span(first), message, Some(help));
            self.in_corner = self.joins_corner(words);
            self.travel(words, MoveKind::Rapid, Fixed::Rapid, machine, false);
        } else {
            self.report.error(self.span(first), "axis words, but no motion code is active", Some(help));
        }
    }

    /// Whether any block states how it moves: a table of positions does not.
    fn states_motion(&self) -> bool {
        self.program.words().iter().any(|word| word.is(b'G') && word.number().is_some_and(|code| (0.0..4.0).contains(&code)))
    }

    /// Whether the block may repeat blocks before it, as statements of SINUMERIK do.
    fn may_jump(&self) -> bool {
        is_likely(self.program.text(self.span_of_block()))
    }

    /// Whether an unknown word may be a coordinate, such as `X=5`. A name of three letters is none, nor is a variable such as Okuma's `VC1`.
    fn may_be_geometry(&self, index: usize) -> bool {
        let text = self.program.text(self.span(index));
        let first = text.first().map(u8::to_ascii_uppercase);
        let letters = text.iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
        let is_name = letters > 2 || (letters > 1 && first.is_some_and(|letter| b"UVW".contains(&letter)));
        !is_name && first.is_some_and(|letter| b"XYZABCIJKRUVW,".contains(&letter))
    }

    /// A move that is never compensated. `end_unknown`: its end is not in the program frame.
    fn travel(&mut self, words: &Gathered, kind: MoveKind, why: Fixed, end_unknown: bool, explicit_motion: bool) {
        let start = self.position;
        self.position = self.target(words, 1);
        if end_unknown || (self.optional_motion && !explicit_motion) {
            self.lose_named(words, start);
        }
        let unread = words.duplicate.is_some() || words.geometry().is_some();
        if self.sections.transforms() || unread {
            self.forget_all();
        }
        self.keep_code_of_last_arc(words.optional, explicit_motion);
        let fixed = if kind == MoveKind::Rapid && end_unknown { Fixed::MachineCoordinates } else { why };
        self.push_fixed(kind, start, fixed, explicit_motion);
    }

    /// The named axes move to a position that is unknown in the program frame.
    pub fn lose_named(&mut self, words: &Gathered, start: Position) {
        for axis in (0..6).filter(|axis| words.has(AXIS_LETTERS[*axis])) {
            self.position.nominal[axis] = start.nominal[axis];
            self.position.forget(axis);
        }
    }

    fn feed_move(&mut self, words: &Gathered, motion: Motion, at: usize, machine: bool, explicit_motion: bool) {
        let why = match self.options.dialect {
            Dialect::Sinumerik => self.reads_not(words, motion != Motion::Line),
            _ => (self.is_not_read(words, motion) || self.is_unsure(motion)).then_some((Fixed::NotUnderstood, "")),
        };
        if let Some(why) = why {
            if !self.is_sinumerik() {
                self.warn_unread(words, motion);
            }
            return self.opaque_move(words, why, at, explicit_motion);
        }
        let start = self.position;
        let end = self.target(words, 1);
        let sound = self.check_feed_move(words, motion, at);
        let turns = self.modal.spindle_rpm.is_some_and(|rpm| rpm > 0.0);
        if sound && self.modal.feed_mode == FeedMode::PerRevolution && !turns {
            let why = "the feed follows a spindle speed that the program does not state: the move is left alone";
            return self.opaque_move(words, (Fixed::RunTime, why), at, explicit_motion);
        }
        let decided = self.ran != Ran::Perhaps && self.geometry_at_run_time(words, motion).is_none();
        let no_circle = self.arc_without_path(words, motion, end, at);
        let goes_nowhere = no_circle == Some(Fixed::NotUnderstood);
        // Under a motion code that a switch may skip the move may be another, even a probing move.
        let is_lost = machine
            || (self.optional_motion && !explicit_motion)
            || self.has_repeats(words)
            || (goes_nowhere && end.nominal != start.nominal);
        let kind = match motion {
            _ if !sound => None,
            // The path of an arc with unknown words or an unknown end is taken as the line to its end.
            _ if !decided || no_circle.is_some() || is_lost => Some(MoveKind::Line),
            Motion::Line => Some(MoveKind::Line),
            _ => self.arc(words, motion == Motion::ArcCounterClockwise, end, at).map(MoveKind::Arc),
        };
        let feed = if sound { self.feed_of(words, (&start, &end), motion, at) } else { None };
        self.position = end;
        if is_lost {
            self.lose_named(words, start);
        }
        let (Some(kind), Some(feed)) = (kind, feed) else { return };
        if self.takes_forever(start, end, feed) {
            let message =
                "at this feed a minute the move takes more than ten minutes: it may be a feed a turn, or of other units";
            let help = "check the feed: state G95 and the speed of the spindle if it is one a turn, else at least 1 mm/min";
            self.report.error_from("slow", usize::MAX, self.span(at), message, help);
            return;
        }
        let feed_word = match self.feed {
            FeedWord::Value { written, .. } => Some(written),
            _ => None,
        };
        self.keep_code_of_last_arc(words.optional, explicit_motion);
        let shiftable = match self.shiftable(words, start, machine) {
            _ if !decided => Shiftable::No(Fixed::RunTime),
            _ if goes_nowhere => Shiftable::No(Fixed::NotUnderstood),
            Shiftable::Yes if self.in_corner => Shiftable::No(Fixed::Adjoining),
            shiftable => shiftable,
        };
        let step = self.step(kind, start, shiftable);
        self.moves.push(Move { feed: Some(feed), feed_word, explicit_motion, ..step });
    }

    /// Whether the move is slower than any cut, and so long that its plan would be longer than most programs.
    fn takes_forever(&self, start: Position, end: Position, feed: Feed) -> bool {
        let (Feed::Linear { mm_s }, Some(start), Some(end)) = (feed, start.xyz_mm(), end.xyz_mm()) else { return false };
        let length_mm = start.iter().zip(end).map(|(from, to)| (to - from).powi(2)).sum::<f64>().sqrt();
        self.modal.feed_mode == FeedMode::PerMinute && mm_s < SLOWEST_MM_S && length_mm > LONGEST_S * mm_s
    }

    pub fn shiftable(&self, words: &Gathered, start: Position, machine: bool) -> Shiftable {
        let rotary_known = (3..6).all(|axis| !words.has(AXIS_LETTERS[axis]) || start.knows(axis));
        let compensated = [self.cutter_before, self.modal.cutter].iter().any(|cutter| *cutter != CutterCompensation::Off);
        if machine {
            Shiftable::No(Fixed::MachineCoordinates)
        } else if self.is_in_section() || self.has_repeats(words) || self.may_turn(words) {
            Shiftable::No(Fixed::NotUnderstood)
        } else if compensated {
            Shiftable::No(Fixed::CutterCompensation)
        } else if words.has_m(self.program, &[6.0]) || self.changes_offset(words) {
            Shiftable::No(Fixed::ToolChange)
        } else if !self.is_splittable() || self.has_unclear_turns(words) || self.whole.named_blocks.hold(self.block) {
            Shiftable::No(Fixed::Unsplittable)
        } else if words.optional || self.optional_feed || self.optional_motion {
            Shiftable::No(Fixed::OptionalBlock)
        } else if start.xyz_mm().is_none() || !rotary_known {
            Shiftable::No(Fixed::UnknownStart)
        } else {
            Shiftable::Yes
        }
    }

    /// Whether codes or macros before may have changed what the move depends on.
    pub fn is_in_section(&self) -> bool {
        self.sections.is_open() || self.is_doubtful() || self.unclear_feed
    }

    /// Whether an L may repeat the motion, as it does for arcs and canned cycles of some controls, or an N behind its words (Fagor 8055).
    pub fn has_repeats(&self, words: &Gathered) -> bool {
        let is_incremental = self.modal.distance == Distance::Incremental;
        let is_arc = matches!(self.motion, Some(Motion::ArcClockwise | Motion::ArcCounterClockwise));
        let is_behind = || words.index(b'N').zip(words.any(&AXIS_LETTERS)).is_some_and(|(number, axis)| number > axis);
        let counts = words.has(b'L') || self.whole.is_guessed && is_behind();
        self.options.dialect == Dialect::Fanuc && (is_arc || is_incremental) && counts
    }

    /// Leaves the last arc alone where a move relies on its motion code, and blocks between them may be skipped: lines in place of the arc
    /// would change that code, and no block between can restore it.
    pub fn keep_code_of_last_arc(&mut self, optional: bool, explicit_motion: bool) {
        if optional {
            self.optional_since_code = true;
            return;
        }
        if std::mem::take(&mut self.optional_since_code) && !explicit_motion {
            let certain = self.last_certain;
            let last = self.moves.iter_mut().rfind(|step| step.block as usize == certain);
            if let Some(arc) = last.filter(|step| step.shiftable == Shiftable::Yes && matches!(step.kind, MoveKind::Arc(_))) {
                arc.shiftable = Shiftable::No(Fixed::OptionalBlock);
            }
        }
        self.last_certain = self.block;
    }

    /// Whether the dialect is neither stated nor shown by the program, so that what Fanuc's controls and LinuxCNC do otherwise is not known.
    pub fn is_dialect_open(&self) -> bool {
        self.whole.is_guessed && !self.options.is_dialect_stated
    }

    /// Whether lines may replace the motion of the block. Where the dialect is a guess, no word may act at a time that depends on it. A jump to the block skips lines before it, and a subprogram that the block calls
    /// would run in the modes of these lines.
    fn is_splittable(&self) -> bool {
        let words = self.program.block_words(self.block);
        let is_target = self.program.execution().is_some_and(|execution| execution.targets.contains(&self.block));
        let calls = words.iter().any(|word| word.is(b'M') && [97.0, 98.0, 198.0].contains(&word.value));
        let dialect = self.options.dialect;
        let before = is_target && is_split_before(self.program, self.block, dialect);
        let is_timed_alike = !self.whole.is_guessed || words.iter().all(|word| acts_alike(self.program, self.block, word));
        is_splittable(self.program, self.block, dialect) && !calls && !before && is_timed_alike
    }

    /// Whether P may be the turns of an arc on another control than the one taken, which leaves it out. One turn is the arc itself.
    pub fn may_turn(&self, words: &Gathered) -> bool {
        let is_arc = matches!(self.motion, Some(Motion::ArcClockwise | Motion::ArcCounterClockwise));
        let is_free = words.has(b'P') && !takes_p(self.program.block_words(self.block));
        self.options.dialect == Dialect::Fanuc && is_arc && is_free && words.number(self.program, b'P') != Some(1.0)
    }

    /// Whether P may be the turns of an arc or belong to another code of the block.
    fn has_unclear_turns(&self, words: &Gathered) -> bool {
        let is_arc = matches!(self.motion, Some(Motion::ArcClockwise | Motion::ArcCounterClockwise));
        is_arc && words.has(b'P') && takes_p(self.program.block_words(self.block))
    }

    /// Whether the block may change a tool offset, and with it the end of its motion: on Fanuc controls
    /// by H, D, G43, G44 or G49, on lathes also by T (Fanuc 0i-F Operator's Manual, "Tool Function" and
    /// "Tool Length Offset").
    fn changes_offset(&self, words: &Gathered) -> bool {
        let code = |code: &Code| matches!(code, Code::ToolLength(_));
        match self.options.dialect {
            Dialect::Fanuc => words.any(b"DHT").is_some() || words.g.iter().any(|g| code(&g.code)),
            Dialect::LinuxCnc => false,
            Dialect::Sinumerik => words.any(b"DT").is_some(),
        }
    }

    fn open_cycle(&mut self, code: u16) {
        let normal = self.modal.plane.axes()[2];
        let here = self.position.knows(normal).then(|| self.position.nominal[normal]);
        self.cycle = Some(match self.cycle {
            Some(running) => CycleState { code, ..running },
            None => CycleState { code, initial_mm: here, retract_mm: None, bottom_mm: None },
        });
    }

    fn run_cycle(&mut self, words: &Gathered, mut cycle: CycleState, explicit_motion: bool) {
        let normal = self.modal.plane.axes()[2];
        let unit = self.modal.units.mm();
        let incremental = self.modal.distance == Distance::Incremental;
        let shift = self.modal.shift[normal];
        let level = |letter: u8, base: Option<f64>, old: Option<f64>| match words.index(letter) {
            None => old,
            Some(_) => {
                let value = self.coordinate(words, letter).filter(|n| n.abs() <= LARGEST_COORDINATE)? * unit;
                if incremental { Some(base? + value) } else { Some(value + shift) }
            }
        };
        cycle.retract_mm = level(b'R', cycle.initial_mm, cycle.retract_mm);
        cycle.bottom_mm = level(AXIS_LETTERS[normal], cycle.retract_mm, cycle.bottom_mm);
        self.cycle = Some(cycle);
        if words.any(&AXIS_LETTERS).is_none() && !words.has(b'R') {
            return;
        }
        let count_letter = match self.options.dialect {
            Dialect::LinuxCnc => b'L',
            Dialect::Fanuc if words.has(b'K') => b'K',
            Dialect::Fanuc | Dialect::Sinumerik => b'L',
        };
        let count = words.number(self.program, count_letter);
        let repeats = if words.has(count_letter) { count.unwrap_or(1.0).clamp(0.0, 1e6) as u32 } else { 1 };
        if repeats == 0 {
            // Whether the tool moves over the hole differs among controls.
            if self.options.dialect != Dialect::LinuxCnc {
                self.forget_all();
            }
            return;
        }
        let start = self.position;
        self.position = self.target(words, repeats);
        self.position.nominal[normal] = start.nominal[normal];
        let level = |dialect| cycle.end_level(self.modal.return_level, dialect);
        // Where the dialect is a guess, another control may stay at the other level.
        let is_alike = !self.is_dialect_open() || level(Dialect::Fanuc) == level(Dialect::LinuxCnc);
        match level(self.options.dialect).filter(|_| is_alike) {
            Some(height) => self.position.set(normal, height),
            None => self.position.forget(normal),
        }
        let unsure = self.sections.transforms() || words.duplicate.is_some();
        let threading = self.options.dialect == Dialect::LinuxCnc && cycle.code == 76;
        if unsure || threading || (words.has(count_letter) && count.is_none()) {
            self.forget_all();
        }
        let kind = MoveKind::Cycle(Cycle { code: cycle.code, bottom_mm: cycle.bottom_mm, retract_mm: cycle.retract_mm, repeats });
        self.push_fixed(kind, start, if threading { Fixed::Threading } else { Fixed::Cycle }, explicit_motion);
    }
}
