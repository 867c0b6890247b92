//! Which feeds may change, and how far.

use gcode::{Feed, FeedMode};

use crate::error::{Error, Result};
use crate::part::Part;

/// Which feeds may change, and their upper bounds. The limits of the machine hold besides.
#[derive(Debug, Clone, PartialEq)]
pub struct FeedLimits {
    /// Largest feed as a multiple of the programmed one. `None`: the programmed one, and twice of it where time is only to be won back.
    pub highest_factor: Option<f64>,
    /// Largest feed, mm/s.
    pub max_feed_mm_s: f64,
    /// First and last program line, from 1, of moves whose feeds may change; all where empty.
    pub lines: Vec<(usize, usize)>,
    /// Tools with which feeds may change; all where empty.
    pub tools: Vec<u32>,
}

impl Default for FeedLimits {
    fn default() -> Self {
        Self { highest_factor: None, max_feed_mm_s: f64::INFINITY, lines: Vec::new(), tools: Vec::new() }
    }
}

impl FeedLimits {
    /// Whether the feed of a move may change. A move in inverse time has a duration, not a feed.
    pub(super) fn allows(&self, part: &Part, index: usize) -> bool {
        let step = &part.toolpath.moves[index];
        let modal = part.toolpath.modal(step);
        let line = step.block as usize + 1;
        part.is_shiftable(step)
            && step.feed_word.is_some_and(|word| word > 0.0)
            && modal.feed_mode != FeedMode::InverseTime
            && (self.lines.is_empty() || self.lines.iter().any(|(first, last)| (*first..=*last).contains(&line)))
            && (self.tools.is_empty() || modal.tool.is_some_and(|tool| self.tools.contains(&tool)))
    }

    /// Whether only the feeds of some moves may change.
    pub(super) fn names_moves(&self) -> bool {
        !self.lines.is_empty() || !self.tools.is_empty()
    }

    /// Largest factor on the feed of a move, where `usual` holds if no factor is stated.
    pub(super) fn highest(&self, part: &Part, index: usize, usual: f64) -> f64 {
        let stated = self.highest_factor.unwrap_or(usual);
        match part.toolpath.moves[index].feed {
            Some(Feed::Linear { mm_s }) if mm_s > 0.0 => stated.min(self.max_feed_mm_s / mm_s),
            _ => stated,
        }
    }

    /// Refuses limits that leave no feed to change.
    ///
    /// # Errors
    /// [`Error::NoFeedToChange`].
    pub(super) fn check(&self, part: &Part) -> Result<()> {
        if (0..part.toolpath.moves.len()).any(|index| self.allows(part, index)) {
            return Ok(());
        }
        Err(Error::NoFeedToChange { name: part.name.clone(), named: self.names_moves() })
    }
}
