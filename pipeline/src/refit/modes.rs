//! Modes of a compensated segment: one feed mode and one path tolerance hold in all of it, and the program's own behind it.

use gcode::{Dialect, Edits, Move, MoveKind, PathMode, Span, Word, format_number};

use super::settings::{RefitSettings, TimeEncoding};
use crate::error::Result;
use crate::part::Part;

/// Share of the program's own path tolerance that compensated segments keep, where that is more than the control's least: rounding takes
/// less time than following every kink.
const OF_ITS_OWN: f64 = 0.1;
/// Share of the program's own merging that segments keep which keep its feeds. Merged points lose their corrections, and not merged ones
/// cost time: `3D_Chips` (P and Q 0.1 mm) takes 4.6 % longer on LinuxCNC with none, 3.2 % with a fiftieth, 2.1 % with a twentieth.
const OF_ITS_MERGING: f64 = 0.05;

/// What the program may state in a segment is taken out of it where the segment states another.
pub(super) struct Modes<'a> {
    part: &'a Part,
    /// Codes of feed modes other than the segment's.
    other_feeds: &'static [f64],
    /// Whether the segment has a path mode of its own.
    states_path: bool,
    /// The path mode in force.
    path: PathMode,
    /// The first block that has not been looked at.
    next_block: usize,
}

impl<'a> Modes<'a> {
    /// Modes of the segment that begins with `first`; states the path tolerance before it unless the program's own will do. Feed modes are
    /// stated by the lines.
    pub(super) fn state(part: &'a Part, settings: &RefitSettings, first: &Move, edits: &mut Edits) -> Result<Self> {
        let other_feeds: &[f64] = match settings.encoding {
            TimeEncoding::G93 => &[94.0, 95.0],
            TimeEncoding::G94 => &[93.0, 95.0],
            TimeEncoding::Keep => &[],
        };
        let (modal, block) = (part.toolpath.modal(first), first.block as usize);
        let wanted = path_of_stretch(part, settings, modal.path).filter(|_| !part.stops_exactly(first));
        let mut path = modal.path;
        if let Some(wanted) = wanted
            && (!will_do(modal.path, wanted) || part.program.block_words(block).iter().any(states_path))
        {
            path = wanted;
            edits.insert_before(&part.program, block, &[stated(path, modal.units.mm())?])?;
        }
        Ok(Self { part, other_feeds, states_path: wanted.is_some(), path, next_block: block })
    }

    /// Takes other modes out of all blocks up to `block`.
    pub(super) fn hold_to(&mut self, block: usize, edits: &mut Edits) {
        let program = &self.part.program;
        for words in (self.next_block..=block).map(|block| program.block_words(block)) {
            let path = self.states_path && words.iter().any(states_path);
            let is_other = |word: &&Word| {
                (word.is(b'G') && self.other_feeds.contains(&word.value))
                    || (path && (states_path(word) || word.is(b'P') || word.is(b'Q')))
            };
            for word in words.iter().filter(is_other) {
                let blank = Span { start: word.span.end, end: word.span.end + 1 };
                let end = if program.text(blank) == b" " { blank.end } else { word.span.end };
                edits.replace(Span { start: word.span.start, end }, "");
            }
        }
        self.next_block = self.next_block.max(block + 1);
    }

    /// The line that puts the program's own path mode back after `last`.
    pub(super) fn restore(&self, last: &Move) -> Result<Option<String>> {
        let modal = self.part.toolpath.modal(last);
        if !self.states_path || modal.path == self.path || modal.path == PathMode::Default {
            return Ok(None);
        }
        stated(modal.path, modal.units.mm()).map(Some)
    }
}

/// The path mode that a segment states where the program's is `own`, if it states one.
///
/// A control that merges points of nearly straight lines loses their times and some of their correction: it may do so only where lines keep
/// the program's feeds, and within little of what the program allows.
fn path_of_stretch(part: &Part, settings: &RefitSettings, own: PathMode) -> Option<PathMode> {
    let least_mm = settings.path_tolerance_mm.filter(|_| part.options.dialect == Dialect::LinuxCnc)?;
    let PathMode::Continuous { tolerance_mm: Some(own_mm), merge_mm } = own else {
        return Some(PathMode::Continuous { tolerance_mm: Some(least_mm), merge_mm: Some(0.0) });
    };
    // A tolerance without another for merging is both.
    let merged_mm = OF_ITS_MERGING * merge_mm.unwrap_or(own_mm);
    let merged_mm = if settings.encoding == TimeEncoding::Keep && merged_mm > least_mm { merged_mm } else { 0.0 };
    Some(PathMode::Continuous { tolerance_mm: Some(least_mm.max(OF_ITS_OWN * own_mm)), merge_mm: Some(merged_mm) })
}

/// Whether a segment may run in the mode `own` where `wanted` is asked for: it rounds no more and merges as told.
fn will_do(own: PathMode, wanted: PathMode) -> bool {
    match (own, wanted) {
        (
            PathMode::Continuous { tolerance_mm: Some(own_mm), merge_mm: own_merged },
            PathMode::Continuous { tolerance_mm: Some(wanted_mm), merge_mm: wanted_merged },
        ) => own_mm <= wanted_mm && own_merged == wanted_merged,
        _ => false,
    }
}

/// Whether a control rounds corners less under the tolerance that segments state than under the program's own.
pub(super) fn rounds_less(part: &Part, settings: &RefitSettings) -> bool {
    let moves = part.toolpath.moves.iter().filter(|step| part.is_shiftable(step));
    moves.map(|step| part.toolpath.modal(step).path).any(|own| match own {
        PathMode::Continuous { tolerance_mm: Some(own_mm), .. } if own_mm > 0.0 => match path_of_stretch(part, settings, own) {
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

/// The words of a path mode, lengths in units of `unit_mm`.
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

/// A move after the segment that relies on a motion code which the segment no longer leaves behind gets it stated.
pub(super) fn restore_motion_code(part: &Part, last: usize, edits: &mut Edits) {
    let moves = &part.toolpath.moves;
    let Some(next) = moves.get(last + 1) else { return };
    if next.explicit_motion || part.is_shiftable(next) {
        return;
    }
    let code = match (next.kind, moves[last].kind) {
        (MoveKind::Arc(arc), MoveKind::Arc(_)) if arc.sweep > 0.0 => "G3",
        (MoveKind::Arc(_), MoveKind::Arc(_)) => "G2",
        _ => return,
    };
    let words = part.program.block_words(next.block as usize);
    if let Some(word) = words.iter().find(|word| gcode::is_motion_word(word)) {
        edits.replace(Span { start: word.span.start, end: word.span.start }, code);
    }
}
