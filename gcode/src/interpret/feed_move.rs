//! Requirements on a feed move: interpreted words, a path that runs unconditionally, a valid arc, a
//! feed.

use super::codes::{Code, Motion};
use super::gather::Gathered;
use super::state::{FeedWord, Interpreter};
use crate::dialect::Dialect;
use crate::execution::Ran;
use crate::modal::{CutterCompensation, FeedMode, Units};
use crate::position::{AXIS_LETTERS, LARGEST_COORDINATE, Position};
use crate::sinumerik::signs::SINUMERIK_HELP;
use crate::toolpath::Feed;
use crate::word::Span;

/// Letters whose values define a feed move.
const SHAPING: &[u8] = b"XYZABCIJKRF";
/// Letters that have their own meaning in every block.
const FREE: &[u8] = b"NOSTHDF";

/// Whether a code beside a feed move leaves an L to nothing.
fn takes_no_l(code: Code) -> bool {
    !matches!(code, Code::OneShot(_) | Code::Silent)
}

impl Interpreter<'_> {
    /// Checks a feed move and reports every error. Returns whether there is none.
    pub fn check_feed_move(&mut self, words: &Gathered, motion: Motion, at: usize) -> bool {
        let span = self.span(at);
        if !self.check_runs_once(span) {
            return false;
        }
        if let Some((index, what, help)) = self.unread_word(words, motion) {
            self.report.error(self.span(index), what, help);
            return false;
        }
        let is_arc = motion != Motion::Line;
        self.report_run_time(words, motion);
        let too_large = |letter: &u8| words.number(self.program, *letter).is_some_and(|n| n.abs() > LARGEST_COORDINATE);
        if let Some(index) = SHAPING.iter().find(|letter| too_large(letter)).and_then(|letter| words.index(*letter)) {
            self.report.error(self.span(index), "this number is beyond any machine", None);
            return false;
        }
        if let Some(index) = words.index(b'L').filter(|_| words.m.is_empty() && words.g.iter().all(|g| takes_no_l(g.code))) {
            let message = if self.has_repeats(words) {
                "L may repeat this move, which is left alone"
            } else {
                "L has no meaning in this feed move and is left as it is"
            };
            self.report.warning(self.span(index), message, None);
        }
        if let Some(index) = words.index(b'N').filter(|_| !words.has(b'L') && self.has_repeats(words)) {
            let message = "N behind the axis words may repeat this move, which is left alone";
            self.report.warning(self.span(index), message, Some("write block numbers at the start of the line"));
        }
        if let Some(index) = words.index(b'P').filter(|_| is_arc && self.may_turn(words)) {
            let message = "P may be the number of turns of this arc, which is left alone";
            self.report.warning(self.span(index), message, Some("--dialect linuxcnc reads it"));
        }
        if !self.units_stated {
            // One warning is enough. An option that was set explicitly needs none.
            self.units_stated = true;
            let unit = match self.options.units {
                Units::Mm => "mm",
                Units::Inch => "inch",
            };
            let codes = if self.is_sinumerik() { "none of G70, G71, G700, G710" } else { "neither G20 nor G21" };
            let message = format!("{codes} before the first feed move: {unit} is taken");
            self.report.warning(span, message, None);
        }
        true
    }

    /// Whether a feed move is not read: its coordinates are not those of the path, or it has words without a known meaning. LinuxCNC runs no program with
    /// such words.
    pub fn is_not_read(&self, words: &Gathered, motion: Motion) -> bool {
        let is_uncertain = || words.unknown.is_none() && (self.sections.is_open() || self.is_doubtful());
        let may_mean = || self.options.dialect != Dialect::LinuxCnc || is_uncertain();
        self.sections.transforms() || (self.unread_word(words, motion).is_some() && may_mean())
    }

    /// Why a feed move is left alone that is not understood by itself, unless a warning before said it.
    pub fn warn_unread(&mut self, words: &Gathered, motion: Motion) {
        if self.sections.transforms() || self.sections.is_open() || self.is_doubtful() {
            return;
        }
        if let Some((index, what, help)) = self.unread_word(words, motion) {
            self.report.warning(self.span(index), format!("{what}: the move is left alone"), help);
        }
    }

    /// Refuses a statement that may run the moves before it once more.
    pub fn refuse_statement(&mut self, words: &Gathered, index: usize) {
        self.position = self.target(words, 1);
        self.report.error(self.span(index), "not understood in a feed move", Some(SINUMERIK_HELP));
    }

    /// The first word of a feed move without a known meaning: what is said of it, and the remedy.
    fn unread_word(&self, words: &Gathered, motion: Motion) -> Option<(usize, String, Option<&'static str>)> {
        const NAME_IT: &str = "take the word out, or name the control: --dialect";
        if let Some(index) = words.unknown {
            return Some((index, "not understood in a feed move".into(), Some(NAME_IT)));
        }
        if let Some(index) = words.duplicate {
            return Some((index, "this letter stands twice in a feed move".into(), None));
        }
        let index = self.stray(words, motion != Motion::Line)?;
        let letter = char::from(self.program.words()[index].letter);
        let help = match letter {
            'U'..='W' => "state its end with X, Y and Z: increments and parallel axes in U, V and W are not read",
            _ => NAME_IT,
        };
        Some((index, format!("{letter} has no meaning in this feed move"), Some(help)))
    }

    /// Whether a macro may have changed what a feed move needs in order to be read: the plane or the start of an arc, the feed.
    pub fn is_unsure(&self, motion: Motion) -> bool {
        let is_fed = matches!(self.feed, FeedWord::Value { .. }) && self.modal.feed_mode == FeedMode::PerMinute;
        self.is_doubtful() && (motion != Motion::Line || !is_fed)
    }

    /// Every execution of a block would get the same correction. Blocks must also run in the order of the file.
    fn check_runs_once(&mut self, span: Span) -> bool {
        let what = match self.ran {
            Ran::Perhaps => return true,
            Ran::Repeated => "runs several times".to_owned(),
            Ran::Elsewhere => "is in a subprogram of another file".to_owned(),
            Ran::Once if let Some(last) = self.fed_block.filter(|last| self.block <= *last) => {
                format!("does not run in the order of the lines: it follows line {}", last + 1)
            }
            Ran::Once => {
                self.fed_block = Some(self.block);
                return true;
            }
        };
        let help = "give --expand: it writes the program without loops and subprograms";
        self.report.error_from("run", usize::MAX, span, format!("a feed move {what}"), help);
        false
    }

    /// The first word of the geometry of a feed move whose value only the running program knows.
    pub fn geometry_at_run_time(&self, words: &Gathered, motion: Motion) -> Option<usize> {
        let letters = if motion == Motion::Line { &AXIS_LETTERS[..] } else { b"XYZABCIJKRP" };
        words.unknown_value(self.program, letters)
    }

    fn report_run_time(&mut self, words: &Gathered, motion: Motion) {
        if let Some(index) = self.geometry_at_run_time(words, motion) {
            let message = "this value is known only when the program runs: the move is left alone";
            self.report.warning(self.span(index), message, None);
        }
    }

    /// The first word that no code of the block uses.
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
            // An old way to round a corner, which is left alone.
            b'R' => is_arc || self.options.dialect == Dialect::Fanuc,
            b'P' => taken_by_code || is_arc,
            // Repeats of cycles and calls.
            b'L' => taken_by_code || !linux_cnc,
            b'Q' => taken_by_code,
            b'E' => taken_by_code && self.free_exponent(words).is_none(),
            _ => false,
        };
        (b'A'..=b'Z').filter(|letter| !allowed(*letter)).filter_map(|letter| words.index(letter)).min()
    }

    /// The feed of the present block's move.
    pub fn feed_of(&mut self, words: &Gathered, (start, end): (&Position, &Position), motion: Motion, at: usize) -> Option<Feed> {
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
                let message = format!("the feed of line {} is known only when the program runs", block + 1);
                self.report.error_from("feed", block, span, message, "write the feed as a number");
                return None;
            }
        };
        // A linear word that restates the position is no motion, but in an arc.
        let stays = |axis: usize| {
            motion == Motion::Line && start.knows(axis) && end.knows(axis) && start.nominal[axis] == end.nominal[axis]
        };
        let linear = (0..3).any(|axis| words.has(AXIS_LETTERS[axis]) && !stays(axis));
        let rotary_only = !linear && words.any(b"ABC").is_some();
        let per_second = match self.modal.feed_mode {
            FeedMode::InverseTime => {
                if !words.has(b'F') {
                    self.report.error(span, "G93 needs an F word in every feed move", None);
                    return None;
                }
                return Some(Feed::Duration { seconds: 60.0 / raw });
            }
            FeedMode::PerMinute => 1.0 / 60.0,
            FeedMode::PerRevolution => self.modal.spindle_rpm? / 60.0,
        };
        Some(if rotary_only {
            Feed::Angular { rad_s: raw.to_radians() * per_second }
        } else {
            Feed::Linear { mm_s: mm * per_second }
        })
    }
}
