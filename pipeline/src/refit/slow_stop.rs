//! The slow zone before a stop.

use gcode::{Feed, FeedMode, Move, WordKind};

use super::block_writer::decimals;
use super::settings::{RefitSettings, TimeEncoding};
use crate::part::Part;

/// Letters of the words that a block with a slow zone may have: whatever else acts in it may act at its end, at the slow feed.
const LETTERS: &[u8] = b"NGXYZABCIJKRF";
/// M codes that may stand between a stop and the next move: stops, ends and coolant. A spindle that reverses taps a thread, and one that stops may be a
/// laser: neither must wait at the end of its cut.
const NEUTRAL_M: [f64; 7] = [0.0, 1.0, 2.0, 7.0, 8.0, 9.0, 30.0];
/// Least length of a zone, as a multiple of the increment of written coordinates.
const LEAST_INCREMENTS: f64 = 10.0;
/// Least ratio of the feed of a move to that of a slow zone in it.
const LEAST_RATIO: f64 = 2.0;
/// Least length of the moves before a stop, as a multiple of that of the zone.
const LEAST_LENGTHS: f64 = 2.0;
/// Distance from the end of a move up to which a sample lies on it, mm: the plan has a sample where it stops.
const AT_END_MM: f64 = 1e-7;

/// The end of a path at which the control stops, from this arc length on.
#[derive(Debug, Clone, Copy)]
pub(super) struct SlowZone {
    pub(super) from_mm: f64,
    pub(super) speed_mm_s: f64,
}

impl SlowZone {
    /// The zone at the end of moves that lead from one arc length to another without a border between them, `index` being the last of them, where
    /// the settings ask for one, the control stops there, and the last block can state a feed of its own.
    pub(super) fn before_stop(part: &Part, settings: &RefitSettings, index: usize, [from_mm, to_mm]: [f64; 2]) -> Option<Self> {
        let slow = settings.slow_stop?;
        let last = &part.toolpath.moves[index];
        let increment_mm = 0.1_f64.powi(i32::try_from(decimals(part, settings)).unwrap_or(i32::MAX));
        let is_long = to_mm - from_mm >= LEAST_LENGTHS * slow.length_mm && slow.length_mm >= LEAST_INCREMENTS * increment_mm;
        let own_feed = part.toolpath.modal(last).feed_mode == FeedMode::PerMinute && last.feed_word.is_some();
        let states_feed = (own_feed || settings.encoding != TimeEncoding::Keep) && moves_only(part, last);
        let stops = stops_at(part, to_mm) && !part.stops_exactly(last);
        let is_slower = matches!(last.feed, Some(Feed::Linear { mm_s }) if mm_s >= LEAST_RATIO * slow.speed_mm_s());
        let zone = Self { from_mm: to_mm - slow.length_mm, speed_mm_s: slow.speed_mm_s() };
        (is_long && states_feed && stops && is_slower && keeps_spindle(part, index)).then_some(zone)
    }
}

/// Whether the plan stops at an arc length.
fn stops_at(part: &Part, position_mm: f64) -> bool {
    let samples = &part.plan.samples;
    let at = samples.partition_point(|sample| sample.position_mm < position_mm - AT_END_MM);
    samples.get(at).is_none_or(|sample| sample.position_mm <= position_mm + AT_END_MM)
}

/// Whether nothing from a move up to the next one may act on a spindle, or on what stands in its place.
fn keeps_spindle(part: &Part, index: usize) -> bool {
    let block = |index: usize| part.toolpath.moves.get(index).map(|step| step.block as usize + 1);
    let from = block(index).unwrap_or_default();
    let until = block(index + 1).unwrap_or(part.program.blocks().len());
    let mut words = (from..until).flat_map(|block| part.program.block_words(block));
    words.all(|word| !word.is(b'S') && (!word.is(b'M') || NEUTRAL_M.contains(&word.value)))
}

/// Whether the block of a move states nothing that acts at its end.
fn moves_only(part: &Part, step: &Move) -> bool {
    let words = part.program.block_words(step.block as usize);
    let is_motion = |word: &gcode::Word| match word.kind {
        WordKind::Comment | WordKind::Motion => true,
        WordKind::Number | WordKind::Expression => LETTERS.contains(&word.letter),
        _ => false,
    };
    words.iter().all(is_motion)
}
