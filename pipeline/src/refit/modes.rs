//! Modes of a compensated segment: one feed mode and one path tolerance within it, the program's own after it.

use gcode::{Edits, Move, PathMode, Span, Word, format_number};

use super::settings::{RefitSettings, TimeEncoding};
use crate::error::Result;
use crate::part::Part;

/// Share of the program's own path tolerance that compensated segments use, where it exceeds the least tolerance of the
/// control. Rounding takes less time than following every kink.
const TOLERANCE_SHARE: f64 = 0.1;
/// Share of the program's own merging tolerance in segments that keep its feeds. Merged points lose their corrections,
/// unmerged points cost time: `3D_Chips` (P and Q 0.1 mm) takes 4.6 % longer on LinuxCNC without merging, 3.2 % with a
/// fiftieth, 2.1 % with a twentieth.
const MERGING_SHARE: f64 = 0.05;

/// Motion codes of feed moves.
const FEED_MOTIONS: [f64; 3] = [1.0, 2.0, 3.0];

/// Modes of a segment. Codes of other modes are removed from its blocks.
pub(super) struct Modes<'a> {
    part: &'a Part,
    /// Codes of feed modes other than the segment's.
    other_feeds: &'static [f64],
    /// Whether lines are in inverse time.
    is_timed: bool,
    /// Whether the segment has a path mode of its own.
    states_path: bool,
    /// The path mode in force.
    path: PathMode,
    /// First block that has not been processed.
    next_block: usize,
}

impl<'a> Modes<'a> {
    /// Modes of the segment that begins with `first`. States the path tolerance before the segment unless the program's
    /// own is sufficient. Lines state the feed mode.
    pub(super) fn state(part: &'a Part, settings: &RefitSettings, first: &Move, edits: &mut Edits) -> Result<Self> {
        let other_feeds: &[f64] = match settings.encoding {
            TimeEncoding::G93 => &[94.0, 95.0],
            TimeEncoding::G94 => &[93.0, 95.0],
            TimeEncoding::Keep => &[],
        };
        let (modal, block) = (part.toolpath.modal(first), first.block as usize);
        let wanted = path_of_segment(part, settings, modal.path).filter(|_| !part.stops_exactly(first));
        let mut path = modal.path;
        if let Some(wanted) = wanted
            && (!is_sufficient(modal.path, wanted) || part.program.block_words(block).iter().any(states_path))
        {
            path = wanted;
            edits.insert_before(&part.program, block, &[stated(path, modal.units.mm())?])?;
        }
        let is_timed = settings.encoding == TimeEncoding::G93;
        Ok(Self { part, other_feeds, is_timed, states_path: wanted.is_some(), path, next_block: block })
    }

    /// Removes codes of other modes from all blocks up to `block`.
    pub(super) fn remove_others(&mut self, block: usize, edits: &mut Edits) {
        let program = &self.part.program;
        let own = (self.next_block..=block).filter(|block| program.runs_once(*block));
        for words in own.map(|block| program.block_words(block)) {
            let path = self.states_path && words.iter().any(states_path);
            // An M code of the block may take P and Q, unless it is one of stops, spindle and coolant.
            let taken = words.iter().any(|word| word.is(b'M') && !(0.0..10.0).contains(&word.value));
            // In inverse time LinuxCNC wants a feed in every block with a motion code, also without motion.
            let idle = self.is_timed && !words.iter().any(|word| word.is(b'F') || b"XYZABCIJK".contains(&word.letter));
            let is_other = |word: &&Word| {
                (word.is(b'G') && self.other_feeds.contains(&word.value))
                    || (idle && word.is(b'G') && FEED_MOTIONS.contains(&word.value))
                    || (path && (states_path(word) || !taken && (word.is(b'P') || word.is(b'Q'))))
            };
            for word in words.iter().filter(is_other) {
                let blank = Span { start: word.span.end, end: word.span.end + 1 };
                let end = if program.text(blank) == b" " { blank.end } else { word.span.end };
                edits.replace(Span { start: word.span.start, end }, "");
            }
        }
        self.next_block = self.next_block.max(block + 1);
    }

    /// Line that restores the program's own path mode after `last`.
    pub(super) fn restore(&self, last: &Move) -> Result<Option<String>> {
        let modal = self.part.toolpath.modal(last);
        if !self.states_path || modal.path == self.path || modal.path == PathMode::Default {
            return Ok(None);
        }
        stated(modal.path, modal.units.mm()).map(Some)
    }
}

/// Path mode of a segment where that of the program is `own`; `None` where the segment states none.
///
/// A control that merges points of nearly straight lines loses their times and part of their correction. Merging is
/// therefore allowed only where lines keep the program's feeds, and within a small share of the program's tolerance.
fn path_of_segment(part: &Part, settings: &RefitSettings, own: PathMode) -> Option<PathMode> {
    let least_mm = settings.path_tolerance_mm.filter(|_| part.has_path_tolerance())?;
    let PathMode::Continuous { tolerance_mm: Some(own_mm), merge_mm } = own else {
        return Some(PathMode::Continuous { tolerance_mm: Some(least_mm), merge_mm: Some(0.0) });
    };
    // A tolerance without a merging tolerance stands for both.
    let merged_mm = MERGING_SHARE * merge_mm.unwrap_or(own_mm);
    let merged_mm = if settings.encoding == TimeEncoding::Keep && merged_mm > least_mm { merged_mm } else { 0.0 };
    Some(PathMode::Continuous { tolerance_mm: Some(least_mm.max(TOLERANCE_SHARE * own_mm)), merge_mm: Some(merged_mm) })
}

/// Whether a segment may run in the mode `own` instead of `wanted`: it rounds no more, and merges the same.
fn is_sufficient(own: PathMode, wanted: PathMode) -> bool {
    match (own, wanted) {
        (
            PathMode::Continuous { tolerance_mm: Some(own_mm), merge_mm: own_merged },
            PathMode::Continuous { tolerance_mm: Some(wanted_mm), merge_mm: wanted_merged },
        ) => own_mm <= wanted_mm && own_merged == wanted_merged,
        _ => false,
    }
}

/// Whether the tolerance of segments is smaller than the program's own for any move, so that the control rounds corners
/// less.
pub(super) fn rounds_less(part: &Part, settings: &RefitSettings) -> bool {
    let moves = part.toolpath.moves.iter().filter(|step| part.is_shiftable(step));
    moves.map(|step| part.toolpath.modal(step).path).any(|own| match own {
        PathMode::Continuous { tolerance_mm: Some(own_mm), .. } if own_mm > 0.0 => match path_of_segment(part, settings, own) {
            Some(PathMode::Continuous { tolerance_mm: Some(stated_mm), .. }) => stated_mm < own_mm,
            _ => false,
        },
        _ => false,
    })
}

/// Whether a word is G61, G61.1 or G64.
fn states_path(word: &Word) -> bool {
    word.is(b'G') && [61.0, 61.1, 64.0].contains(&word.value)
}

/// Words of a path mode, lengths in units of `unit_mm`.
fn stated(path: PathMode, unit_mm: f64) -> Result<String> {
    Ok(match path {
        PathMode::Default => String::new(),
        PathMode::ExactPath => "G61".to_owned(),
        PathMode::ExactStop => "G61.1".to_owned(),
        PathMode::Continuous { tolerance_mm, merge_mm } => {
            let mut words = "G64".to_owned();
            for (letter, length_mm) in [('P', tolerance_mm), ('Q', merge_mm)] {
                if let Some(length_mm) = length_mm {
                    words.push_str(&format!("{letter}{}", format_number(length_mm / unit_mm, 6)?));
                }
            }
            words
        }
    })
}

/// States the motion code of `next`, the move after the segment, which is not rewritten, where that move relied on a code other than
/// `active`, which the segment leaves active.
pub(super) fn restore_motion_code(part: &Part, next: &Move, active: Option<&str>, edits: &mut Edits) {
    // An arc whose coordinates are not known is a line in the list of moves.
    let code = match next.motion_code {
        Some(1) => "G1",
        Some(2) => "G2",
        Some(3) => "G3",
        _ => return,
    };
    if next.explicit_motion || !next.is_feed() {
        return;
    }
    if active == Some(code) {
        return;
    }
    let words = part.program.block_words(next.block as usize);
    if let Some(word) = words.iter().find(|word| gcode::is_motion_word(word)) {
        edits.replace(Span { start: word.span.start, end: word.span.start }, code);
    }
}
