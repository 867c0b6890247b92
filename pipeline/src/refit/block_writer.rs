//! Lines of a compensated program, in its own units.

use gcode::{FeedMode, Move, Units, append_number, format_number};
use motion::Vec6;

use super::settings::{RefitSettings, TimeEncoding};
use crate::error::{Error, Result};
use crate::part::{Part, coordinates};

/// A point to be written.
pub(super) struct Target {
    /// Program coordinates: mm, rad.
    pub(super) point: Vec6,
    /// When the plan passes it, s.
    pub(super) time_s: f64,
    /// Share of the move's way that has been gone.
    pub(super) way: f64,
}

/// Which of A, B, C a part's machine turns.
fn turning_axes(part: &Part) -> [bool; 3] {
    let kinematics = part.plan.desired.kinematics();
    ["a", "b", "c"].map(|name| kinematics.turns() && kinematics.axes().iter().any(|axis| axis.name == name))
}

/// Most bytes of a usual line.
const LINE: usize = 96;

fn append_feed(text: &mut String, feed: f64) -> Result<()> {
    text.push('F');
    append_number(text, feed, 4)?;
    Ok(())
}

/// Writes lines in the program's own units and modes.
pub(super) struct Writer<'a> {
    part: &'a Part,
    settings: &'a RefitSettings,
    /// Where the written lines have led, program coordinates as rounded: mm, rad.
    written: Vec6,
    /// Which of A, B, C the machine turns.
    turns: [bool; 3],
    mode: FeedMode,
    g1_active: bool,
    /// Feed word in force where feeds are changed.
    feed: Option<f64>,
}

impl<'a> Writer<'a> {
    pub(super) fn new(part: &'a Part, settings: &'a RefitSettings, first: &Move) -> Self {
        let modal = part.toolpath.modal(first);
        Self {
            part,
            settings,
            written: coordinates(&first.start),
            turns: turning_axes(part),
            mode: modal.feed_mode,
            g1_active: false,
            feed: first.feed_word,
        }
    }

    /// The line to `target`, which takes this `share` of its move's way.
    pub(super) fn line(
        &mut self,
        owner: usize,
        first_of_block: bool,
        target: &Target,
        before_s: f64,
        share: f64,
    ) -> Result<String> {
        let (step, factor) = (&self.part.toolpath.moves[owner], self.part.feed_factors[owner]);
        let modal = self.part.toolpath.modal(step);
        let mut text = String::with_capacity(LINE);
        let (wanted, code) = match self.settings.encoding {
            TimeEncoding::G93 => (FeedMode::InverseTime, "G93"),
            TimeEncoding::G94 => (FeedMode::PerMinute, "G94"),
            // The program's own codes stay where they are.
            TimeEncoding::Keep => (modal.feed_mode, ""),
        };
        if wanted != self.mode {
            text.push_str(code);
            (self.mode, self.feed) = (wanted, None);
        }
        if !self.g1_active || (first_of_block && step.explicit_motion) {
            text.push_str("G1");
            self.g1_active = true;
        }
        let before = self.written;
        let mut moves = false;
        let decimals = self.settings.decimals + usize::from(modal.units == Units::Inch);
        for axis in (0..6).filter(|axis| *axis < 3 || self.turns[axis - 3]) {
            let Some(value) = self.part.toolpath.programmed(step, axis, self.written[axis], target.point[axis]) else { continue };
            let before_word = text.len();
            text.push(['X', 'Y', 'Z', 'A', 'B', 'C'][axis]);
            // What a control reads back, so that incremental programs gather no rounding.
            let read = match axis {
                0..3 => append_number(&mut text, value / modal.units.mm(), decimals)? * modal.units.mm(),
                _ => append_number(&mut text, value.to_degrees(), self.settings.decimals)?.to_radians(),
            };
            let reached = self.written[axis]
                + (read - self.part.toolpath.programmed(step, axis, self.written[axis], self.written[axis]).unwrap_or_default());
            // A line needs an axis word, or it is no move.
            let last_chance = !moves && axis == 2;
            if (reached - self.written[axis]).abs() > 0.0
                || (axis == 0 && self.settings.encoding != TimeEncoding::Keep)
                || last_chance
            {
                self.written[axis] = reached;
                moves = true;
            } else {
                text.truncate(before_word);
            }
        }
        let duration = (target.time_s - before_s).max(1e-5);
        match self.settings.encoding {
            TimeEncoding::G93 => append_feed(&mut text, 60.0 / duration)?,
            TimeEncoding::G94 => {
                // F is the speed of the linear axes; where none of them moves, of the rotary ones in degrees.
                let way = self.written - before;
                let length = way.fixed_rows::<3>(0).norm() / modal.units.mm();
                let length = if length > 0.0 { length } else { way.fixed_rows::<3>(3).norm().to_degrees() };
                let feed = length.max(1e-6) / duration * 60.0;
                append_feed(&mut text, feed.max(1e-4))?;
            }
            // Inverse time holds for one line: the parts of a move share its time. One that only the correction moves gets a hundredth.
            TimeEncoding::Keep if self.mode == FeedMode::InverseTime && share < 1.0 => {
                let Some(word) = step.feed_word else { return Err(Error::NoInverseTime { line: step.block as usize + 1 }) };
                append_feed(&mut text, word * factor / share.max(0.01))?;
            }
            TimeEncoding::Keep => {
                let wanted = step.feed_word.map(|feed| feed * factor);
                match step.words(&self.part.program).feed {
                    Some(word) if first_of_block && factor == 1.0 => {
                        let span = self.part.program.words()[word].span;
                        text.push_str(&String::from_utf8_lossy(self.part.program.text(span)));
                    }
                    _ if wanted != self.feed => {
                        if let Some(feed) = wanted {
                            append_feed(&mut text, feed)?;
                        }
                    }
                    _ => {}
                }
                self.feed = wanted;
            }
        }
        Ok(text)
    }

    /// The line after a segment that puts the program's own feed back.
    pub(super) fn restore(&self, last: &Move) -> Result<Option<String>> {
        if self.settings.encoding == TimeEncoding::Keep {
            // Inverse time holds for one line only.
            let changed = self.mode != FeedMode::InverseTime && self.feed != last.feed_word;
            let feed = last.feed_word.filter(|_| changed).map(|feed| format_number(feed, 6)).transpose()?;
            return Ok(feed.map(|feed| format!("F{feed}")));
        }
        let modal = self.part.toolpath.modal(last);
        let mode = match modal.feed_mode {
            FeedMode::InverseTime => "G93",
            FeedMode::PerMinute => "G94",
            FeedMode::PerRevolution => "G95",
        };
        let feed = match (last.feed_word, modal.feed_mode) {
            (Some(word), FeedMode::PerMinute | FeedMode::PerRevolution) => format!("F{}", format_number(word, 6)?),
            _ => String::new(),
        };
        let text = if modal.feed_mode == self.mode { feed } else { format!("{mode}{feed}") };
        Ok((!text.is_empty()).then_some(text))
    }
}
