//! What a feed move must fulfil: words that are understood, a path that is sure to run, an arc that exists, a feed.

use crate::arc::{Arc, ArcFault, ArcTolerance};
use crate::codes::{Code, Motion, written};
use crate::dialect::Dialect;
use crate::gather::Gathered;
use crate::interpret::{FeedWord, Interpreter};
use crate::modal::{CutterCompensation, Distance, FeedMode, Units};
use crate::position::{AXIS_LETTERS, LARGEST_COORDINATE, Position};
use crate::toolpath::Feed;

/// Letters whose values shape a feed move.
const SHAPING: &[u8] = b"XYZABCIJKRF";
/// Letters with a meaning of their own in any block.
const FREE: &[u8] = b"NOSTHDF";

impl Interpreter<'_> {
    /// Reports what makes a feed move unfit; returns whether nothing does.
    pub fn check_feed_move(&mut self, words: &Gathered, motion: Motion, at: usize) -> bool {
        let span = self.span(at);
        if let Some((cause, how)) = self.flow.fault() {
            let message = format!("a feed move {how} on line {} cannot be predicted", cause + 1);
            self.report.error_from("flow", cause, span, message, "unroll the program before it is compensated");
            return false;
        }
        if let Some(&(cause, tenths)) = self.transforms.first() {
            let message = format!("a feed move under {} of line {} is not interpreted", written(tenths), cause + 1);
            let help = "rotation, scaling, mirroring, polar and diameter modes must be off in feed moves";
            self.report.error_from("transform", cause, span, message, help);
            return false;
        }
        if let Some(cause) = self.modal_macro {
            let message = format!("a feed move under the modal macro of line {} calls a subprogram", cause + 1);
            self.report.error_from("macro", cause, span, message, "cancel it with G67");
            return false;
        }
        if let Some(index) = words.duplicate {
            self.report.error(self.span(index), "this letter stands twice in a feed move", None);
            return false;
        }
        let is_arc = motion != Motion::Line;
        let shaping = words.expression(self.program, SHAPING);
        if let Some(index) = shaping.or_else(|| if is_arc { words.expression(self.program, b"P") } else { None }) {
            let help = "only numbers can be compensated: replace the parameter by its value";
            self.report.error(self.span(index), "a feed move depends on a parameter", Some(help));
            return false;
        }
        let too_large = |letter: &u8| words.number(self.program, *letter).is_some_and(|n| n.abs() > LARGEST_COORDINATE);
        if let Some(index) = SHAPING.iter().find(|letter| too_large(letter)).and_then(|letter| words.index(*letter)) {
            self.report.error(self.span(index), "this number is beyond any machine", None);
            return false;
        }
        if let Some(index) = self.stray(words, is_arc) {
            let letter = char::from(self.program.words()[index].letter);
            self.report.error(self.span(index), format!("{letter} has no meaning in this feed move"), None);
            return false;
        }
        if !self.units_stated {
            // Once is enough, and an option that was set on purpose deserves no more.
            self.units_stated = true;
            let unit = match self.options.units {
                Units::Mm => "mm",
                Units::Inch => "inch",
            };
            let message = format!("neither G20 nor G21 before the first feed move: {unit} is taken");
            self.report.warning(span, message, None);
        }
        true
    }

    /// Refuses a feed move for a word that is not understood.
    pub fn refuse_unknown(&mut self, words: &Gathered, index: usize) {
        self.fed = true;
        self.position = self.target(words, 1);
        self.report.error(self.span(index), "not understood in a feed move", None);
    }

    /// The first word that no code of the block takes.
    fn stray(&self, words: &Gathered, is_arc: bool) -> Option<usize> {
        let linux_cnc = self.options.dialect == Dialect::LinuxCnc;
        let taken_by_code = !words.m.is_empty()
            || words.g.iter().any(|g| {
                matches!(g.code, Code::Path(_) | Code::ExtendedWorkOffset | Code::Silent | Code::OneShot(_) | Code::ToolLength(_))
            });
        let compensating = self.modal.cutter != CutterCompensation::Off;
        let allowed = |letter: u8| match letter {
            _ if FREE.contains(&letter) || AXIS_LETTERS.contains(&letter) => true,
            b'I' | b'J' | b'K' => is_arc || compensating,
            b'R' => is_arc,
            b'P' => taken_by_code || (is_arc && linux_cnc),
            b'Q' | b'E' | b'L' => taken_by_code,
            _ => false,
        };
        (b'A'..=b'Z').filter(|letter| !allowed(*letter)).filter_map(|letter| words.index(letter)).min()
    }

    /// The feed of the present block's move.
    pub fn feed_of(&mut self, words: &Gathered, at: usize) -> Option<Feed> {
        let span = self.span(at);
        let (raw, mm) = match self.feed {
            FeedWord::Value { written, mm } if written > 0.0 => (written, mm),
            FeedWord::Value { .. } => {
                self.report.error_from("feed", usize::MAX, span, "the feed is not positive", "F must be above zero");
                return None;
            }
            FeedWord::Unset => {
                self.report.error_from("feed", usize::MAX, span, "no feed was given before this feed move", "write an F word");
                return None;
            }
            FeedWord::Unpredictable { block } => {
                let message = format!("the feed comes from a parameter on line {}", block + 1);
                self.report.error_from("feed", block, span, message, "replace the parameter by its value");
                return None;
            }
        };
        let rotary_only = !words.has(b'X') && !words.has(b'Y') && !words.has(b'Z') && words.any(b"ABC").is_some();
        let per_second = match self.modal.feed_mode {
            FeedMode::InverseTime => {
                if !words.has(b'F') {
                    self.report.error(span, "G93 needs an F word in every feed move", None);
                    return None;
                }
                return Some(Feed::Duration { seconds: 60.0 / raw });
            }
            FeedMode::PerMinute => 1.0 / 60.0,
            FeedMode::PerRevolution => match self.modal.spindle_rpm {
                Some(rpm) if rpm > 0.0 => rpm / 60.0,
                _ => {
                    self.report.error(span, "G95 needs a spindle speed in rev/min", Some("write an S word under G97"));
                    return None;
                }
            },
        };
        Some(if rotary_only {
            Feed::Angular { rad_s: raw.to_radians() * per_second }
        } else {
            Feed::Linear { mm_s: mm * per_second }
        })
    }

    /// Builds the arc of the present block; reports why there is none.
    pub fn arc(&mut self, words: &Gathered, counter_clockwise: bool, end: Position, at: usize) -> Option<Arc> {
        let plane = self.modal.plane;
        let [first, second, normal] = plane.axes();
        let offset_letters = [b'I', b'J', b'K'];
        let in_plane = [offset_letters[first], offset_letters[second]];
        let unit = self.modal.units.mm();
        if let Some(index) = words.index(offset_letters[normal]) {
            self.report.error(self.span(index), "this centre word is not in the plane of the arc", Some("check G17, G18, G19"));
            return None;
        }
        let centre_word = words.any(&in_plane);
        let absolute_centre = self.modal.arc_distance == Distance::Absolute;
        for axis in [first, second] {
            let given = words.has(AXIS_LETTERS[axis]) && self.modal.distance == Distance::Absolute;
            if !self.position.knows(axis) && (given || (absolute_centre && centre_word.is_some())) {
                let help = "give all axes in an absolute move first; G28, a new work offset and G53 leave the place unknown";
                self.report.error(self.span(at), "the start of this arc is not known", Some(help));
                return None;
            }
        }
        let turns = match words.number(self.program, b'P') {
            Some(p) if self.options.dialect == Dialect::LinuxCnc && words.m.is_empty() => {
                if p.fract() != 0.0 || !(1.0..=1e6).contains(&p) {
                    self.report.error(self.span(at), "P must be a whole number of turns", None);
                    return None;
                }
                p as u32
            }
            _ => 1,
        };
        let start = [self.position.nominal[first], self.position.nominal[second]];
        let stop = [end.nominal[first], end.nominal[second]];
        let tolerance = self.options.arc_tolerance.unwrap_or_else(|| ArcTolerance::for_units(self.modal.units));
        match (words.index(b'R'), centre_word) {
            (Some(index), Some(_)) => {
                self.report.error(self.span(index), "an arc with both a radius and a centre", None);
                None
            }
            (Some(index), None) => {
                let radius = words.number(self.program, b'R').unwrap_or(0.0) * unit;
                let arc = Arc::with_radius(plane, start, stop, radius, counter_clockwise, turns, tolerance);
                arc.map_err(|fault| self.report_arc(fault, index, None)).ok()
            }
            (None, None) => {
                self.report.error(self.span(at), "an arc without centre or radius", Some("give I, J, K or R"));
                None
            }
            (None, Some(index)) => {
                let offset = in_plane.map(|letter| words.number(self.program, letter).map(|value| value * unit));
                let shift = [self.modal.shift[first], self.modal.shift[second]];
                let incremental = [0, 1].map(|k| start[k] + offset[k].unwrap_or(0.0));
                let absolute = [0, 1].map(|k| shift[k] + offset[k].unwrap_or(0.0));
                let complete = offset.iter().all(Option::is_some);
                if absolute_centre && !complete {
                    self.arc_faults += 1;
                    self.report.error(self.span(index), "an absolute arc centre needs both its words", None);
                    return None;
                }
                let (centre, other) = if absolute_centre { (absolute, incremental) } else { (incremental, absolute) };
                let about = |centre| Arc::about(plane, start, stop, centre, counter_clockwise, turns, tolerance);
                let fits_otherwise = complete && about(other).is_ok();
                about(centre).map_err(|fault| self.report_arc(fault, index, fits_otherwise.then_some(absolute_centre))).ok()
            }
        }
    }

    fn report_arc(&mut self, fault: ArcFault, index: usize, fits_other_than_absolute: Option<bool>) {
        let message = match fault {
            ArcFault::RadiiDiffer { start_mm, end_mm } => {
                format!("no circle: its radius is {start_mm:.4} mm at the start and {end_mm:.4} mm at the end")
            }
            ArcFault::ZeroRadius => "an arc of radius zero".to_owned(),
            ArcFault::RadiusTooSmall { radius_mm, half_chord_mm } => {
                format!("no circle: its radius is {radius_mm:.4} mm, half its chord {half_chord_mm:.4} mm")
            }
            ArcFault::RadiusWithoutChord => "a radius makes no circle from a point to itself: give I, J, K".to_owned(),
        };
        let help = match fits_other_than_absolute {
            Some(false) => Some("the centre fits if it is absolute (G90.1)"),
            Some(true) => Some("the centre fits if it is a distance from the start (G91.1)"),
            None => None,
        };
        if matches!(fault, ArcFault::RadiiDiffer { .. } | ArcFault::ZeroRadius) {
            self.arc_faults += 1;
        }
        self.report.error(self.span(index), message, help);
    }
}
