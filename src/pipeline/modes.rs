//! Modes of a compensated stretch: one feed mode and one path tolerance hold in all of it, and the program's own behind it.

use anyhow::Result;
use gcode::{Dialect, Edits, Move, MoveKind, PathMode, Span, Word, format_number};

use super::{Carrier, Part, RefitSettings};

/// Share of the program's own path tolerance that compensated stretches keep, where that is more than the control's least: rounding takes
/// less time than following every kink.
const OF_ITS_OWN: f64 = 0.1;

/// What the program may state in a stretch is taken out of it where the stretch states another.
pub(super) struct Modes<'a> {
    part: &'a Part,
    /// Codes of feed modes other than the stretch's.
    other_feeds: &'static [f64],
    /// Path tolerance of the stretch, mm, where it has one of its own.
    tolerance_mm: Option<f64>,
    /// The path mode in force.
    path: PathMode,
    /// The first block that has not been looked at.
    next_block: usize,
}

impl<'a> Modes<'a> {
    /// Modes of the stretch that begins with `first`; states the path tolerance before it unless the program's own will do. Feed modes are
    /// stated by the lines.
    pub(super) fn state(part: &'a Part, settings: &RefitSettings, first: &Move, edits: &mut Edits) -> Result<Self> {
        let other_feeds: &[f64] = match settings.carrier {
            Carrier::G93 => &[94.0, 95.0],
            Carrier::G94 => &[93.0, 95.0],
            Carrier::Keep => &[],
        };
        let (modal, block) = (part.toolpath.modal(first), first.block as usize);
        let tolerance_mm = tolerance_mm(part, settings, modal.path);
        let mut path = modal.path;
        if let Some(wanted_mm) = tolerance_mm {
            let will_do =
                matches!(path, PathMode::Continuous { tolerance_mm: Some(own), merge_mm: Some(0.0) } if own <= wanted_mm);
            if !will_do || part.program.block_words(block).iter().any(states_path) {
                // Without merging: a control that merges points of nearly straight lines loses their times.
                path = PathMode::Continuous { tolerance_mm: Some(wanted_mm), merge_mm: Some(0.0) };
                edits.insert_before(&part.program, block, &[stated(path, modal.units.mm())?])?;
            }
        }
        Ok(Self { part, other_feeds, tolerance_mm, path, next_block: block })
    }

    /// Takes other modes out of all blocks up to `block`.
    pub(super) fn hold_to(&mut self, block: usize, edits: &mut Edits) {
        let program = &self.part.program;
        for words in (self.next_block..=block).map(|block| program.block_words(block)) {
            let path = self.tolerance_mm.is_some() && words.iter().any(states_path);
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
        if self.tolerance_mm.is_none() || modal.path == self.path || modal.path == PathMode::Default {
            return Ok(None);
        }
        stated(modal.path, modal.units.mm()).map(Some)
    }
}

/// Path tolerance that stretches of a program state, mm, where they state one.
fn tolerance_mm(part: &Part, settings: &RefitSettings, own: PathMode) -> Option<f64> {
    let least_mm = settings.path_tolerance_mm.filter(|_| part.options.dialect == Dialect::LinuxCnc)?;
    Some(match own {
        PathMode::Continuous { tolerance_mm: Some(own_mm), .. } => least_mm.max(OF_ITS_OWN * own_mm),
        _ => least_mm,
    })
}

/// Whether a control rounds corners less under the tolerance that stretches state than under the program's own.
pub(super) fn rounds_less(part: &Part, settings: &RefitSettings) -> bool {
    let moves = part.toolpath.moves.iter().filter(|step| part.is_shiftable(step));
    moves.map(|step| part.toolpath.modal(step).path).any(|own| match own {
        PathMode::Continuous { tolerance_mm: Some(own_mm), .. } => {
            tolerance_mm(part, settings, own).is_some_and(|stated_mm| stated_mm < own_mm)
        }
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

/// A move after the stretch that relies on a motion code which the stretch no longer leaves behind gets it stated.
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
