//! Refit: writes a learned reference back into its program.
//!
//! Points of the original geometry are shifted by the correction at their time: the ends of all moves, and as many
//! points within arcs and long lines as the correction and the shape of the arc need. Everything else in the program is
//! unchanged. [`write_program`] refits and verifies.

mod arc;
mod block_writer;
mod element;
mod mark;
mod modes;
mod notation;
mod refitted;
mod segment;
mod settings;
mod slow_stop;
mod verify;
mod verify_feeds;

use std::collections::HashSet;
use std::ops::Range;

use gcode::{Edits, Language, Program, edit};
use motion::{SHARE, Trajectory, Vec6};
use rayon::prelude::*;

use crate::error::Result;
use crate::part::{Part, PathSegment, Section, stated};

use block_writer::{decimals, stated_axes};
use modes::rounds_less;
use segment::Segment;
use verify_feeds::verify_feeds;

pub use arc::ElementArc;
pub use element::Element;
pub use mark::{Mark, comes_from, marked_line};
pub use refitted::Refitted;
pub use settings::{DECIMALS, RefitSettings, SlowStop, TimeEncoding};
pub use verify::verify;

/// Writes the correction `reference − desired` of `part`'s plan into its program.
///
/// Segments whose correction is zero keep every byte.
///
/// # Errors
/// When a block cannot be split into several lines, or the program cannot have this time encoding.
pub fn refit(part: &Part, reference: &Trajectory, settings: &RefitSettings) -> Result<Refitted> {
    refit_moves(part, reference, settings, &(0..part.toolpath.moves.len()))
}

/// Same as [`refit`], for the moves with these indices; the others keep their bytes.
fn refit_moves(part: &Part, reference: &Trajectory, settings: &RefitSettings, moves: &Range<usize>) -> Result<Refitted> {
    let settings = &settings.suited_to(part)?;
    let named = Vec6::from(part.named_axes().map(|named| f64::from(u8::from(named))));
    let shifts: Vec<Vec6> = shifts(part, reference)?.into_iter().map(|shift| shift.component_mul(&named)).collect();
    let rounded = rounds_less(part, settings).then(|| program_points(part));
    let tips = part.plan.desired.tips_of(reference)?;
    let mut out = Refitted::default();
    let borders = part.borders();
    let within = part.segments().into_iter().filter_map(|run| part.within(run, moves));
    let runs: Vec<PathSegment> = within.filter(|run| is_changed(part, &shifts, run)).collect();
    let rewritten: HashSet<usize> =
        runs.iter().flat_map(|run| run.pieces.clone()).filter_map(|piece| part.owners[piece]).collect();
    let axes = stated_axes(part);
    for run in runs {
        let largest = run.samples.map(|k| (tips[k] - part.plan.desired.poses()[k].tip).norm()).fold(0.0, f64::max);
        out.largest_shift_mm = out.largest_shift_mm.max(largest);
        let segment = Segment {
            part,
            shifts: &shifts,
            rounded: rounded.as_deref(),
            settings,
            axes: &axes,
            borders: &borders,
            rewritten: &rewritten,
        };
        segment.write(&run.pieces.collect::<Vec<usize>>(), &mut out)?;
    }
    Ok(out)
}

/// Whether a run has a correction, or other feeds than the program.
fn is_changed(part: &Part, shifts: &[Vec6], run: &PathSegment) -> bool {
    let refed = |piece: usize| part.owners[piece].is_some_and(|owner| part.feed_factors[owner] != 1.0);
    run.samples.clone().any(|k| shifts[k] != Vec6::zeros()) || run.pieces.clone().any(refed)
}

/// Planned path at every sample in program coordinates, mm and rad.
fn program_points(part: &Part) -> Vec<Vec6> {
    let (path, kinematics) = (part.plan.desired.trajectory(), part.plan.desired.kinematics().as_ref());
    let point = |k: usize| {
        let (words, offset) = part.move_at(k).map_or((part.words, Vec6::zeros()), |index| {
            let of = &part.toolpath.moves[index];
            (part.words_of(of), part.offset_of(of))
        });
        stated(&path.at(k).collect::<Vec<f64>>(), kinematics, words) - offset
    };
    (0..path.len()).map(point).collect()
}

/// Correction of every sample in the coordinates of its move's words, mm and rad.
fn shifts(part: &Part, reference: &Trajectory) -> Result<Vec<Vec6>> {
    let desired = &part.plan.desired;
    let kinematics = desired.kinematics().as_ref();
    if !kinematics.has_rotary_axes() {
        let tips = desired.tips_of(reference)?;
        let moved = tips.iter().zip(desired.poses()).map(|(tip, pose)| tip - pose.tip);
        return Ok(moved.map(|d| Vec6::new(d.x, d.y, d.z, 0.0, 0.0, 0.0)).collect());
    }
    reference.check_matches(desired.trajectory())?;
    let shift = |joints: &mut Vec<f64>, k: usize| {
        let words = part.move_at(k).map_or(part.words, |index| part.words_of(&part.toolpath.moves[index]));
        let mut stated = |of: &Trajectory| {
            joints.clear();
            joints.extend(of.at(k));
            stated(joints, kinematics, words)
        };
        stated(reference) - stated(desired.trajectory())
    };
    Ok((0..reference.len()).into_par_iter().with_min_len(SHARE).map_init(Vec::new, shift).collect())
}

/// Program `part` with the points of `reference` and, where anything changed, the comment `mark`; read back and verified. Also returns the
/// largest correction of a point, mm.
///
/// # Errors
/// When the program cannot be written, or fails verification.
pub fn write_program(
    part: &Part,
    reference: &Trajectory,
    settings: &RefitSettings,
    max_shift_mm: f64,
    mark: Option<&Mark>,
) -> Result<(Vec<u8>, f64)> {
    let settings = &settings.suited_to(part)?;
    let mut refitted = refit(part, reference, settings)?;
    if let Some(mark) = mark.filter(|_| !refitted.edits.is_empty()) {
        mark.write(&part.program, refitted.largest_shift_mm, &mut refitted.edits)?;
    }
    let mut bytes = edit(&part.program, &refitted.edits)?;
    if part.program.language() == Language::Dialogue && !refitted.edits.is_empty() {
        bytes = gcode::renumber(&gcode::parse(bytes))?;
    }
    let mut written = gcode::parse(bytes.clone());
    gcode::evaluate(&mut written, &part.options, &|name| part.subprogram(name))?;
    let toolpath = gcode::interpret(&written, &part.options)?;
    let moves = 0..part.toolpath.moves.len();
    verify(part, &moves, &refitted, &toolpath, max_shift_mm, decimals(part, settings))?;
    if settings.encoding == TimeEncoding::Keep && changes_feeds(part, &moves, &refitted) {
        verify_feeds(part, &moves, &refitted, &toolpath)?;
    }
    Ok((bytes, refitted.largest_shift_mm))
}

/// Whether moves have other feeds than the program.
fn changes_feeds(part: &Part, moves: &Range<usize>, refitted: &Refitted) -> bool {
    !refitted.slow.is_empty() || part.feed_factors[moves.clone()].iter().any(|factor| *factor != 1.0)
}

/// The first blocks of a program with `edits` and the comment `mark`.
///
/// # Errors
/// As [`gcode::edit_blocks`].
pub fn write_head(
    program: &Program,
    blocks: Range<usize>,
    mut edits: Edits,
    mark: &Mark,
    largest_shift_mm: f64,
) -> Result<Vec<u8>> {
    mark.write(program, largest_shift_mm, &mut edits)?;
    Ok(gcode::edit_blocks(program, blocks, &edits)?)
}

/// The written core of a section.
#[derive(Debug)]
pub struct WrittenSection {
    /// Its bytes.
    pub bytes: Vec<u8>,
    /// The edits of the program that lead to them.
    pub edits: Edits,
    /// Largest correction of a point, mm.
    pub largest_shift_mm: f64,
}

/// The core of a section with the points of `reference`, or as it is without one; read back and verified.
///
/// # Errors
/// When it cannot be written, or fails verification.
pub fn write_section(
    part: &Part,
    section: &Section,
    reference: Option<&Trajectory>,
    settings: &RefitSettings,
    max_shift_mm: f64,
) -> Result<WrittenSection> {
    let settings = &settings.suited_to(part)?;
    let moves = section.core_moves(part);
    let refitted = match reference {
        Some(reference) => refit_moves(part, reference, settings, &moves)?,
        None => Refitted::default(),
    };
    let bytes = gcode::edit_blocks(&part.program, section.core.clone(), &refitted.edits)?;
    let toolpath = section.read_core(part, bytes.clone())?;
    verify(part, &moves, &refitted, &toolpath, max_shift_mm, decimals(part, settings))?;
    if settings.encoding == TimeEncoding::Keep && changes_feeds(part, &moves, &refitted) {
        verify_feeds(part, &moves, &refitted, &toolpath)?;
    }
    let Refitted { edits, largest_shift_mm, .. } = refitted;
    Ok(WrittenSection { bytes, edits, largest_shift_mm })
}
