//! Places at which a program can be cut, and the windows between them.

use std::collections::BTreeSet;
use std::sync::Arc;

use gcode::{Diagnostic, Feed, Move, MoveKind, Reader, Resume, Toolpath, WorkOffset};
use motion::{Limits, Vec6};

use crate::error::Result;
use crate::part::{MissingAxes, Placement, Section, Whole, coordinates, refused};
use crate::setup::Setup;

/// Estimated time between places at which the program can be cut, s.
const APART_S: f64 = 0.5;
/// Approximate length of a window, s, and its largest number of moves; the last window may be half as long again.
const WINDOW_S: f64 = 30.0;
const WINDOW_MOVES: usize = 20_000;
/// Motion before and after a window, s: memory of a model (up to 0.5 s), braking, and the low-pass of a law.
const BESIDE_S: f64 = 2.0;
/// Length of the approach in the direction of the last motion of every axis, mm: far above presliding distances and backlash.
const APPROACH_MM: f64 = 0.5;
/// Motion below which an axis counts as at rest, mm.
const STILL_MM: f64 = 1e-4;

/// A place at which the program can be cut.
#[derive(Debug)]
struct Cut {
    /// The block behind it.
    block: usize,
    state: Resume,
    /// Estimated time and number of moves before it.
    time_s: f64,
    moves: usize,
    /// Number of feed moves before it.
    feeds: usize,
    /// Start of the next move in program coordinates, and its system.
    at: Vec6,
    system: WorkOffset,
    /// Signs of the last motion of every axis.
    direction: Vec6,
}

/// The cuts of a program.
#[derive(Debug)]
pub(super) struct Cuts {
    cuts: Vec<Cut>,
    /// Indices of the cuts at which windows begin.
    starts: Vec<usize>,
    systems: BTreeSet<WorkOffset>,
    seconds: f64,
    pub(super) warnings: Vec<Diagnostic>,
    blocks: usize,
}

/// Finds the cuts of a program; `None` where it cannot be read in parts.
pub(super) fn scan(whole: &Whole, setup: &Setup) -> Result<Option<Cuts>> {
    let (program, options) = (&whole.program, &whole.options);
    for reader in [Reader::new(program, options), Reader::with_absolute_centres(program, options)].into_iter().flatten() {
        if let Some(cuts) = read_through(reader, whole, setup)? {
            return Ok(Some(cuts));
        }
    }
    Ok(None)
}

/// Reads a program to its end; `None` where its arcs fit no circle.
fn read_through(mut reader: Reader<'_>, whole: &Whole, setup: &Setup) -> Result<Option<Cuts>> {
    let program = &whole.program;
    let mut cuts = vec![Cut {
        block: 0,
        state: reader.state(),
        time_s: 0.0,
        moves: 0,
        feeds: 0,
        at: Vec6::zeros(),
        system: WorkOffset::Standard(1),
        direction: Vec6::zeros(),
    }];
    let mut missing = MissingAxes::of(setup.kinematics.as_ref());
    let (mut time_s, mut moves, mut feeds, mut direction, mut systems) = (0.0, 0, 0, Vec6::zeros(), BTreeSet::new());
    loop {
        let last_s = cuts.last().map_or(0.0, |cut| cut.time_s);
        let state = if time_s >= last_s + APART_S { reader.resume().filter(Resume::is_absolute) } else { None };
        let block = reader.block();
        let Some(part) = reader.read(1) else { break };
        if let (Some(state), Some(next)) = (state, part.moves.first())
            && matches!(next.kind, MoveKind::Line | MoveKind::Rapid)
        {
            let (at, system) = (coordinates(&next.start), part.modal(next).work_offset);
            cuts.push(Cut { block, state, time_s, moves, feeds, at, system, direction });
        }
        for step in &part.moves {
            missing.note(step);
            time_s += estimate_s(step, &setup.limits, whole.settings.piece_time_s);
            moves += 1;
            note_direction(step, &mut direction);
            if step.is_feed() {
                systems.insert(system_of(&part, step));
                feeds += 1;
            }
        }
    }
    let refusal = |error| refused(error, program, &whole.name);
    let Some(mut warnings) = reader.finish().map_err(refusal)? else { return Ok(None) };
    warnings.extend(missing.warnings(program));
    let mut starts = vec![0];
    // Of equal length: a short last one would leave all cores but one without work.
    let window_s = time_s / (time_s / WINDOW_S).round().max(1.0);
    for (index, cut) in cuts.iter().enumerate() {
        let from = &cuts[starts[starts.len() - 1]];
        let is_full = cut.time_s - from.time_s >= window_s || cut.moves - from.moves >= WINDOW_MOVES;
        let (left_s, left) = (time_s - cut.time_s, moves - cut.moves);
        // A window without a feed move has nothing to compensate: rapids and dwells belong to one that has.
        let has_feed = cut.feeds > from.feeds && feeds > cut.feeds;
        if is_full && has_feed && left_s > BESIDE_S && (left_s > 0.5 * WINDOW_S || left > WINDOW_MOVES / 2) {
            starts.push(index);
        }
    }
    Ok(Some(Cuts { cuts, starts, systems, seconds: time_s, warnings, blocks: program.blocks().len() }))
}

fn system_of(part: &Toolpath, step: &Move) -> WorkOffset {
    part.modal(step).work_offset
}

/// Time of a move at its feed, s, without acceleration; the control needs at least `least_s` for it.
fn estimate_s(step: &Move, limits: &Limits, least_s: f64) -> f64 {
    let length_mm = step.length_mm().unwrap_or(0.0);
    let least_s = if length_mm > 0.0 { least_s } else { 0.0 };
    let at_most = |mm_s: f64| (length_mm / mm_s.min(limits.path_velocity_mm_s).max(1e-3)).max(least_s);
    match (step.kind, step.feed) {
        (MoveKind::Dwell { seconds }, _) => seconds.unwrap_or(0.0).max(0.0),
        (_, Some(Feed::Duration { seconds })) => seconds.max(0.0),
        (_, Some(Feed::Linear { mm_s })) => at_most(mm_s),
        _ => at_most(f64::INFINITY),
    }
}

/// Signs of the motion of every axis at the end of a move; those of axes that it leaves at rest stay.
fn note_direction(step: &Move, direction: &mut Vec6) {
    let [before, end] = [0.95, 1.0].map(|share| step.point_mm(share));
    let start = step.start.nominal_mm();
    for axis in 0..3 {
        let (whole, last) = (end[axis] - start[axis], end[axis] - before[axis]);
        let by = if last.abs() > 0.05 * STILL_MM { last } else { whole };
        if by.abs() > STILL_MM {
            direction[axis] = by.signum();
        }
    }
}

impl Cuts {
    pub(super) fn seconds(&self) -> f64 {
        self.seconds
    }

    pub(super) fn windows(&self) -> usize {
        self.starts.len()
    }

    /// Coordinate systems of feed moves.
    pub(super) fn systems(&self) -> &BTreeSet<WorkOffset> {
        &self.systems
    }

    /// Number of places at which the program can be cut, its start included.
    #[cfg(test)]
    pub(super) fn places(&self) -> usize {
        self.cuts.len()
    }

    /// Lets windows begin at these of the places, the first of which is 0.
    #[cfg(test)]
    pub(super) fn begin_at(&mut self, places: Vec<usize>) {
        self.starts = places;
    }

    /// The windows, with their surroundings.
    pub(super) fn sections(&self, whole: &Arc<Whole>, placement: &Placement, setup: &Setup) -> Vec<Section> {
        let section = |window: usize| {
            let core = self.starts[window];
            let end = self.starts.get(window + 1).copied();
            let first = self.cuts[..=core].iter().rposition(|cut| cut.time_s <= self.cuts[core].time_s - BESIDE_S).unwrap_or(0);
            let last = end.and_then(|end| {
                let beyond = |cut: &Cut| cut.time_s >= self.cuts[end].time_s + BESIDE_S;
                self.cuts[end..].iter().find(|cut| beyond(cut))
            });
            let block_of = |cut: Option<&Cut>| cut.map_or(self.blocks, |cut| cut.block);
            let (core, end, first) = (&self.cuts[core], end.map(|end| &self.cuts[end]), &self.cuts[first]);
            let offset = placement.of(first.system);
            let mut before = first.at + Vec6::new(offset.x, offset.y, offset.z, 0.0, 0.0, 0.0) - first.direction * APPROACH_MM;
            // A part beside the end of the travel is approached from the end.
            for (axis, travel) in setup.kinematics.axes().iter().zip(&setup.travel) {
                if let (Some(slot), Some([low, high]), true) = (axis.slot(), travel, placement.known()) {
                    before[slot] = before[slot].clamp(*low, *high);
                }
            }
            Section {
                whole: Arc::clone(whole),
                blocks: first.block..block_of(last),
                start: first.state.clone(),
                core: core.block..block_of(end),
                core_start: core.state.clone(),
                before: (first.block > 0).then_some(before),
            }
        };
        (0..self.starts.len()).map(section).collect()
    }
}
