//! The learned reference, written back into the program.
//!
//! Points of the original geometry are moved by the correction that holds at their time: the ends of all moves, and within arcs and
//! long lines as many more as the correction and the arc's shape need. Nothing else of the program changes.

use anyhow::Result;
use gcode::{Edits, Move, MoveKind};
use machine::MachineSpec;
use motion::{SHARE, Trajectory, Vec6};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::Part;
use super::lines::Writer;
use super::modes::{self, Modes, restore_motion_code};
use super::tool_path::{POINT_MM, coordinates, stated};
use crate::cli::CarrierArgs;

/// How the points of a compensated program carry their time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Carrier {
    /// Inverse time: `F` is one over the line's duration in minutes.
    G93,
    /// Units a minute, an `F` on every line.
    G94,
    /// The program's own feed words, unchanged.
    Keep,
}

impl Carrier {
    /// Its name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::G93 => "g93",
            Self::G94 => "g94",
            Self::Keep => "keep",
        }
    }
}

/// How a program is written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RefitSettings {
    /// How points carry their time.
    pub carrier: Carrier,
    /// Decimals of a coordinate in mm; inch coordinates get one more.
    pub decimals: usize,
    /// Least time between points within one move, s.
    pub spacing_s: f64,
    /// Largest distance of a line between points from the corrected curve, mm.
    pub chord_tolerance_mm: f64,
    /// Path tolerance that a stretch states, mm, where the control knows one; `None` keeps the program's own.
    pub path_tolerance_mm: Option<f64>,
}

/// Largest distance of a written line from the corrected curve between its ends, mm.
const CHORD_TOLERANCE_MM: f64 = 2e-4;
/// Decimals of coordinates in mm, and time between points, ms, where neither the user nor the machine's profile says: what LinuxCNC needs.
pub(super) const DECIMALS: usize = 6;
const SPACING_MS: f64 = 4.0;

impl RefitSettings {
    /// What `wanted` says, else the profile of the control.
    #[must_use]
    pub fn of(carrier: Carrier, wanted: &CarrierArgs, spec: &MachineSpec) -> Self {
        let profile = spec.controller;
        Self {
            carrier,
            decimals: wanted.decimals.unwrap_or(profile.map_or(DECIMALS, |profile| usize::from(profile.decimals))),
            spacing_s: wanted.spacing.unwrap_or(profile.map_or(SPACING_MS, |profile| profile.point_spacing_ms)) * 1e-3,
            chord_tolerance_mm: CHORD_TOLERANCE_MM,
            path_tolerance_mm: profile.and_then(|profile| profile.path_tolerance_mm),
        }
    }
}

/// A program with its points moved.
#[derive(Debug)]
pub struct Refitted {
    /// The patches.
    pub edits: Edits,
    /// For every move that was rewritten its index and the ends of the lines in its place, program coordinates: mm, rad.
    pub targets: Vec<(usize, Vec<Vec6>)>,
    /// Largest correction of the tool tip, mm.
    pub largest_shift_mm: f64,
}

/// Writes the correction `reference − desired` of `part`'s plan into its program.
///
/// Stretches whose correction is zero keep every byte.
///
/// # Errors
/// When a block cannot be split into several lines.
pub fn refit(part: &Part, reference: &Trajectory, settings: &RefitSettings) -> Result<Refitted> {
    let shifts = shifts(part, reference)?;
    let rounded = modes::rounds_less(part, settings).then(|| places(part));
    let tips = part.plan.desired.tips_of(reference)?;
    let mut out = Refitted { edits: Edits::new(), targets: Vec::new(), largest_shift_mm: 0.0 };
    let pieces: Vec<usize> = (0..part.owners.len()).collect();
    let runs = pieces.chunk_by(|a, b| {
        let exact = |piece: usize| part.owners[piece].is_some_and(|owner| part.stops_exactly(&part.toolpath.moves[owner]));
        shiftable(part, *a) && shiftable(part, *b) && exact(*a) == exact(*b)
    });
    let mut from = 0;
    for run in runs {
        let samples = from..from + part.plan.samples[from..].partition_point(|sample| sample.piece <= run[run.len() - 1]);
        from = samples.end;
        let refed = |piece: &usize| part.owners[*piece].is_some_and(|owner| part.feed_factors[owner] != 1.0);
        if shiftable(part, run[0]) && (samples.clone().any(|k| shifts[k] != Vec6::zeros()) || run.iter().any(refed)) {
            let largest = samples.clone().map(|k| (tips[k] - part.plan.desired.poses()[k].tip).norm()).fold(0.0, f64::max);
            out.largest_shift_mm = out.largest_shift_mm.max(largest);
            Stretch { part, shifts: &shifts, rounded: rounded.as_deref(), settings }.write(run, &mut out)?;
        }
    }
    Ok(out)
}

/// The planned path at every sample, in the program's coordinates: mm, rad.
fn places(part: &Part) -> Vec<Vec6> {
    let (path, kinematics) = (part.plan.desired.trajectory(), part.plan.desired.kinematics().as_ref());
    let place = |k: usize| {
        let (words, offset) = part.move_at(k).map_or((part.words, Vec6::zeros()), |index| {
            let of = &part.toolpath.moves[index];
            (part.words_of(of), part.offset_of(of))
        });
        stated(&path.at(k).collect::<Vec<f64>>(), kinematics, words) - offset
    };
    (0..path.len()).map(place).collect()
}

/// The correction of every sample, in the coordinates of the words of its move: mm, rad.
fn shifts(part: &Part, reference: &Trajectory) -> Result<Vec<Vec6>> {
    let desired = &part.plan.desired;
    let kinematics = desired.kinematics().as_ref();
    if !kinematics.turns() {
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

fn shiftable(part: &Part, piece: usize) -> bool {
    part.owners[piece].is_some_and(|owner| part.is_shiftable(&part.toolpath.moves[owner]))
}

/// Whether a move is a feed move to where the tool is already.
fn leads_nowhere(part: &Part, step: &Move) -> bool {
    let way = coordinates(&step.end) - coordinates(&step.start);
    matches!(step.kind, MoveKind::Line) && part.is_shiftable(step) && way.norm() <= POINT_MM
}

/// Consecutive moves that may be compensated.
struct Stretch<'a> {
    part: &'a Part,
    shifts: &'a [Vec6],
    /// The planned path, where the control is no longer to round the program's corners as far as it did: the points do.
    rounded: Option<&'a [Vec6]>,
    settings: &'a RefitSettings,
}

/// A point to be written.
pub(super) struct Target {
    /// Program coordinates: mm, rad.
    pub(super) point: Vec6,
    /// When the plan passes it, s.
    pub(super) time_s: f64,
    /// Share of the move's way that has been gone.
    pub(super) way: f64,
}

impl Stretch<'_> {
    fn write(&self, run: &[usize], out: &mut Refitted) -> Result<()> {
        let part = self.part;
        let moves = &part.toolpath.moves;
        let mut last = self.owner(run[0]);
        let mut writer = Writer::new(part, self.settings, &moves[last]);
        let mut modes = Modes::state(part, self.settings, &moves[last], &mut out.edits)?;
        let targets: Vec<Vec<Target>> = run.par_iter().with_min_len(PIECES).map(|piece| self.targets(*piece)).collect();
        for (piece, targets) in run.iter().zip(targets) {
            let owner = self.owner(*piece);
            let step = &moves[owner];
            let mut before_s = self.departure(self.start_of(*piece));
            let mut lines = Vec::with_capacity(targets.len());
            let mut way = 0.0;
            for target in &targets {
                lines.push(writer.line(owner, lines.is_empty(), target, before_s, target.way - way)?);
                (before_s, way) = (target.time_s, target.way);
            }
            out.edits.replace_motion(&part.program, step.block as usize, &lines)?;
            out.targets.push((owner, targets.iter().map(|target| target.point).collect()));
            last = owner;
            // A line that leads nowhere has no piece of the path; left as it is, it would lead back to the point as programmed.
            if let Some(end) = targets.last() {
                while let Some(still) =
                    Some(last + 1).filter(|next| moves.get(*next).is_some_and(|step| leads_nowhere(part, step)))
                {
                    let line = writer.line(still, true, end, before_s, 1.0)?;
                    out.edits.replace_motion(&part.program, moves[still].block as usize, &[line])?;
                    out.targets.push((still, vec![end.point]));
                    last = still;
                }
            }
            modes.hold_to(moves[last].block as usize, &mut out.edits);
        }
        let after: Vec<String> = writer.restore(&moves[last])?.into_iter().chain(modes.restore(&moves[last])?).collect();
        out.edits.insert_after(&part.program, moves[last].block as usize, &after)?;
        restore_motion_code(part, last, &mut out.edits);
        Ok(())
    }

    fn owner(&self, piece: usize) -> usize {
        // Checked by `shiftable` for every piece of a run.
        self.part.owners[piece].unwrap_or_default()
    }

    /// Arc length at which a piece begins, mm.
    fn start_of(&self, piece: usize) -> f64 {
        piece.checked_sub(1).map_or(0.0, |before| self.part.plan.piece_ends_mm[before])
    }

    /// Time at which the plan passes an arc length, s.
    fn time_at(&self, position_mm: f64) -> f64 {
        let samples = &self.part.plan.samples;
        let period = self.part.plan.desired.trajectory().period_s();
        let after = samples.partition_point(|sample| sample.position_mm < position_mm);
        let Some(before) = after.checked_sub(1) else { return 0.0 };
        let Some(next) = samples.get(after) else { return before as f64 * period };
        let share = (position_mm - samples[before].position_mm) / (next.position_mm - samples[before].position_mm);
        (before as f64 + share) * period
    }

    /// Time at which the plan leaves an arc length, s: the end of the rest where it rests there.
    fn departure(&self, position_mm: f64) -> f64 {
        let still = self.part.plan.samples.partition_point(|sample| sample.position_mm <= position_mm + POINT_MM);
        let period = self.part.plan.desired.trajectory().period_s();
        self.time_at(position_mm).max(still.saturating_sub(1) as f64 * period)
    }

    /// The correction at a time, mm and rad.
    fn shift_at(&self, time_s: f64) -> Vec6 {
        self.between(self.shifts, time_s)
    }

    /// The value at a time of what is known at every sample.
    fn between(&self, values: &[Vec6], time_s: f64) -> Vec6 {
        let index = time_s / self.part.plan.desired.trajectory().period_s();
        let last = values.len() - 1;
        let before = (index.floor() as usize).min(last);
        let after = (before + 1).min(last);
        values[before].lerp(&values[after], index - before as f64)
    }

    /// Ends of the lines that replace a move.
    fn targets(&self, piece: usize) -> Vec<Target> {
        let (plan, step) = (&self.part.plan, &self.part.toolpath.moves[self.owner(piece)]);
        let period = plan.desired.trajectory().period_s();
        let exact = self.part.stops_exactly(step);
        let (from_mm, to_mm) = (self.start_of(piece), plan.piece_ends_mm[piece]);
        let (from_s, to_s) = (self.departure(from_mm), self.time_at(to_mm));
        let length = (to_mm - from_mm).max(1e-12);
        // Points of the original geometry, at the share of its length that the plan has passed.
        let way_at = |time_s: f64| {
            let index = (time_s / period) as usize;
            let samples = &plan.samples;
            let (a, b) = (samples[index.min(samples.len() - 1)], samples[(index + 1).min(samples.len() - 1)]);
            let position = a.position_mm + (b.position_mm - a.position_mm) * (time_s / period - index as f64);
            ((position - from_mm) / length).clamp(0.0, 1.0)
        };
        let place = |time_s: f64, share: f64| {
            if let Some(rounded) = self.rounded {
                return self.between(rounded, time_s);
            }
            let [x, y, z] = step.point_mm(share);
            let turned = coordinates(&step.start).lerp(&coordinates(&step.end), share);
            Vec6::new(x, y, z, turned[3], turned[4], turned[5])
        };
        let corrected = |time_s: f64| place(time_s, way_at(time_s)) + self.shift_at(time_s);
        let end = Target { point: place(to_s, 1.0) + self.shift_at(to_s), time_s: to_s, way: 1.0 };
        let mut targets = Vec::new();
        let mut start = (from_s, place(from_s, 0.0) + self.shift_at(from_s));
        let steps = if exact { 0 } else { ((to_s - from_s) / self.settings.spacing_s).floor() as usize };
        let mut held = 0;
        for i in 1..steps {
            // The line so far reaches to point `i`; if it leaves the curve in between, the last good point is written.
            let at = |i: usize| from_s + (to_s - from_s) * i as f64 / steps as f64;
            let next_s = at(i + 1).min(to_s);
            let candidate = corrected(next_s);
            // Where lines carry times the speed on one is even: a line over a change of speed would be late or early in between.
            let even = |time_s: f64| {
                let share = (time_s - start.0) / (next_s - start.0);
                let way = way_at(start.0) + (way_at(next_s) - way_at(start.0)) * share;
                self.settings.carrier == Carrier::Keep || (way_at(time_s) - way).abs() * length <= ALONG_MM
            };
            let fits = (held + 1..=i)
                .all(|j| even(at(j)) && off_line(corrected(at(j)), start.1, candidate) <= self.settings.chord_tolerance_mm)
                && i - held < MOST_POINTS;
            if !fits {
                let point = corrected(at(i));
                targets.push(Target { point, time_s: at(i), way: way_at(at(i)) });
                start = (at(i), point);
                held = i;
            }
        }
        targets.push(end);
        targets
    }
}

/// Distance along the path by which a point of a line that carries its time may be passed early or late, mm.
const ALONG_MM: f64 = 0.02;

/// Samples over which one line may reach: bounds the work of checking it.
const MOST_POINTS: usize = 64;

/// Fewest moves whose points are worth a core of their own.
const PIECES: usize = 256;

/// Lever at which a rotary axis's distance from a line counts, mm.
const LEVER_MM: f64 = 100.0;

/// Distance of a point from the line between two others, mm.
fn off_line(point: Vec6, start: Vec6, end: Vec6) -> f64 {
    let at_lever = Vec6::new(1.0, 1.0, 1.0, LEVER_MM, LEVER_MM, LEVER_MM);
    let (chord, off) = ((end - start).component_mul(&at_lever), (point - start).component_mul(&at_lever));
    let length_squared = chord.norm_squared();
    if length_squared < 1e-24 { off.norm() } else { (off - chord * (off.dot(&chord) / length_squared)).norm() }
}
