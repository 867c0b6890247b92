//! Segments: consecutive moves that are compensated together.

use std::collections::HashSet;

use gcode::{Arc, Language, Move, MoveKind};
use motion::Vec6;
use rayon::prelude::*;

use super::arc::{Passage, arc_through, biarc, norm};
use super::block_writer::Writer;
use super::element::{Element, Span, Target};
use super::modes::{Modes, restore_motion_code};
use super::refitted::Refitted;
use super::settings::{RefitSettings, TimeEncoding};
use super::slow_stop::SlowZone;
use crate::error::Result;
use crate::part::{POINT_MM, Part, coordinates};

/// Whether a move is a feed move without motion.
fn leads_nowhere(part: &Part, step: &Move) -> bool {
    let displacement = coordinates(&step.end) - coordinates(&step.start);
    matches!(step.kind, MoveKind::Line) && !step.after_shared && part.is_shiftable(step) && displacement.norm() <= POINT_MM
}

/// Consecutive moves that may be compensated.
pub(super) struct Segment<'a> {
    pub(super) part: &'a Part,
    pub(super) shifts: &'a [Vec6],
    /// Planned path in program coordinates, where the control will round corners less than before and the points
    /// include the rounding.
    pub(super) rounded: Option<&'a [Vec6]>,
    pub(super) settings: &'a RefitSettings,
    /// Axes that lines may state.
    pub(super) axes: &'a [usize],
    /// Whether the correction is zero behind each piece.
    pub(super) borders: &'a [bool],
    /// Moves that this or another segment rewrites.
    pub(super) rewritten: &'a HashSet<usize>,
}

impl Segment<'_> {
    pub(super) fn write(&self, run: &[usize], out: &mut Refitted) -> Result<()> {
        let part = self.part;
        let moves = &part.toolpath.moves;
        let mut last = self.owner(run[0]);
        let mut writer = Writer::new(part, self.settings, self.axes, &moves[last]);
        let mut modes = Modes::state(part, self.settings, &moves[last], &mut out.edits)?;
        let zone = self.slow_zone(run);
        let targets = run.par_iter().with_min_len(MOVES_PER_TASK).map(|piece| self.targets(*piece, zone));
        let targets: Vec<Vec<Target>> = targets.collect();
        for (piece, targets) in run.iter().zip(targets) {
            let owner = self.owner(*piece);
            let step = &moves[owner];
            let mut before_s = self.departure(self.start_of(*piece));
            writer.pass_blocks(last, owner);
            let targets = writer.merged(owner, targets);
            let mut lines = Vec::with_capacity(targets.len());
            for (target, share) in targets.iter().zip(writer.shares(&targets)) {
                lines.push(writer.line(owner, lines.is_empty(), target, before_s, share)?);
                before_s = target.time_s;
            }
            out.edits.replace_motion(&part.program, step.block as usize, part.options.dialect, &lines)?;
            out.targets.push((owner, targets.iter().map(|target| target.element).collect()));
            let slow = targets.iter().filter(|target| target.slow_s.is_some()).count();
            if slow > 0 {
                out.slow.insert(owner, slow);
            }
            last = owner;
            // A line without motion has no path piece. Unchanged, it would lead back to the programmed point.
            if let Some(end) = targets.last().filter(|_| !self.borders[*piece]) {
                while let Some(still) =
                    Some(last + 1).filter(|next| moves.get(*next).is_some_and(|step| leads_nowhere(part, step)))
                {
                    writer.pass_blocks(last, still);
                    let end = Target { element: Element { arc: None, ..end.element }, ..*end };
                    let line = writer.line(still, true, &end, before_s, 1.0)?;
                    out.edits.replace_motion(&part.program, moves[still].block as usize, part.options.dialect, &[line])?;
                    out.targets.push((still, vec![end.element]));
                    last = still;
                }
            }
            modes.remove_others(moves[last].block as usize, &mut out.edits);
        }
        let after: Vec<String> = writer.restore(&moves[last])?.into_iter().chain(modes.restore(&moves[last])?).collect();
        out.edits.insert_after(&part.program, moves[last].block as usize, &after)?;
        // A dwell needs no motion code.
        let next = (last + 1..moves.len()).find(|next| !matches!(moves[*next].kind, MoveKind::Dwell { .. }));
        if let Some(next) = next.filter(|next| !self.rewritten.contains(next)) {
            restore_motion_code(part, &moves[next], writer.code(), &mut out.edits);
        }
        Ok(())
    }

    /// The slow zone at the end of consecutive pieces.
    fn slow_zone(&self, run: &[usize]) -> Option<SlowZone> {
        let last = *run.last().filter(|last| self.borders[**last])?;
        let ends_mm = [self.start_of(run[0]), self.part.plan.piece_ends_mm[last]];
        SlowZone::before_stop(self.part, self.settings, self.owner(last), ends_mm)
    }

    fn owner(&self, piece: usize) -> usize {
        // Every piece of a segment has a move.
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

    /// Time at which the plan leaves an arc length, s: the end of a standstill there.
    fn departure(&self, position_mm: f64) -> f64 {
        let still = self.part.plan.samples.partition_point(|sample| sample.position_mm <= position_mm + POINT_MM);
        let period = self.part.plan.desired.trajectory().period_s();
        self.time_at(position_mm).max(still.saturating_sub(1) as f64 * period)
    }

    /// Correction at a time, mm and rad.
    fn shift_at(&self, time_s: f64) -> Vec6 {
        self.between(self.shifts, time_s)
    }

    /// Linear interpolation of per-sample values at a time.
    fn between(&self, values: &[Vec6], time_s: f64) -> Vec6 {
        let index = time_s / self.part.plan.desired.trajectory().period_s();
        let last = values.len() - 1;
        let before = (index.floor() as usize).min(last);
        let after = (before + 1).min(last);
        values[before].lerp(&values[after], index - before as f64)
    }

    /// Ends of the lines that replace a move. A slow zone in it is one line of its own.
    fn targets(&self, piece: usize, zone: Option<SlowZone>) -> Vec<Target> {
        let (plan, step) = (&self.part.plan, &self.part.toolpath.moves[self.owner(piece)]);
        let period = plan.desired.trajectory().period_s();
        let exact = self.part.stops_exactly(step);
        let (from_mm, to_mm) = (self.start_of(piece), plan.piece_ends_mm[piece]);
        let (arrival_s, from_s, to_s) = (self.time_at(from_mm), self.departure(from_mm), self.time_at(to_mm));
        let slow = zone.filter(|zone| zone.from_mm < to_mm);
        let until_s = slow.map_or(to_s, |slow| if slow.from_mm > from_mm { self.time_at(slow.from_mm) } else { to_s });
        let length = (to_mm - from_mm).max(1e-12);
        // Points of the original geometry at the share of its length that the plan has passed.
        let share_at = |time_s: f64| {
            let index = (time_s / period) as usize;
            let samples = &plan.samples;
            let (a, b) = (samples[index.min(samples.len() - 1)], samples[(index + 1).min(samples.len() - 1)]);
            let position = a.position_mm + (b.position_mm - a.position_mm) * (time_s / period - index as f64);
            ((position - from_mm) / length).clamp(0.0, 1.0)
        };
        let point_at = |time_s: f64, share: f64| {
            let turned = coordinates(&step.start).lerp(&coordinates(&step.end), share);
            if let Some(rounded) = self.rounded {
                let mut point = self.between(rounded, time_s);
                // The plan has no rotary axes where the machine has none.
                if !plan.desired.kinematics().has_rotary_axes() {
                    point.fixed_rows_mut::<3>(3).copy_from(&turned.fixed_rows::<3>(3));
                }
                return point;
            }
            let [x, y, z] = step.point_mm(share);
            Vec6::new(x, y, z, turned[3], turned[4], turned[5])
        };
        let corrected = |time_s: f64| point_at(time_s, share_at(time_s)) + self.shift_at(time_s);
        let arc = self.arc_of(step);
        // Up to two arcs lead from point to point.
        let apart_s = self.settings.spacing_s * if arc.is_some() { 2.0 } else { 1.0 };
        let by_time = ((until_s - from_s) / apart_s).floor() as usize;
        let is_slow = slow.is_some() && until_s == to_s;
        let steps = if exact { 1 } else { (if is_slow { 1 } else { by_time }).max(self.least_steps(step)) };
        let at = |i: usize| from_s + (until_s - from_s) * i as f64 / steps as f64;
        // Beside a border the tool is where the program states it.
        let end = if self.borders[piece] { coordinates(&step.end) } else { point_at(to_s, 1.0) + self.shift_at(to_s) };
        let after_border = piece.checked_sub(1).is_none_or(|before| self.borders[before]);
        let point = |i: usize| match i {
            0 if after_border => coordinates(&step.start),
            // The end of the piece before, which a dwell does not move.
            0 => point_at(arrival_s, 0.0) + self.shift_at(arrival_s),
            _ if i == steps && until_s == to_s => end,
            _ => corrected(at(i)),
        };
        // The speed along a timed line is constant: a line over a change of speed would pass points late or early.
        let even = |from: usize, to: usize| {
            let (start_s, end_s) = (at(from), at(to));
            let uniform =
                |time_s: f64| share_at(start_s) + (share_at(end_s) - share_at(start_s)) * (time_s - start_s) / (end_s - start_s);
            self.settings.encoding == TimeEncoding::Keep
                || (from + 1..to).map(at).all(|time_s| (share_at(time_s) - uniform(time_s)).abs() * length <= ALONG_PATH_MM)
        };
        let span = |from: usize, to: usize| {
            let (start, end) = (point(from), point(to));
            let single = |arc| Span { joint: None, end: Element { point: end, arc } };
            let Some(arc) = arc else { return single(None) };
            let between = corrected(0.5 * (at(from) + at(to)));
            let [leaving, arriving] = [from, to].map(|i| self.direction(arc, share_at(at(i)), at(i)));
            let through = arc_through(arc.plane, &start, &between, &end);
            if through.is_some_and(|through| through.follows(leaving, arriving)) {
                return single(through);
            }
            let [leaves, arrives] = [(start, leaving), (end, arriving)].map(|(point, direction)| Passage { point, direction });
            let (joint, last) = biarc(arc.plane, &leaves, &arrives).unwrap_or_default();
            let span = Span { joint: joint.map(|(point, arc)| Element { point, arc }), end: Element { point: end, arc: last } };
            if to > from + 1 || span.off(start, between) <= self.settings.chord_tolerance_mm.max(WITHIN_STEP_MM) {
                return span;
            }
            // Where the correction changes within a step, the directions at its ends do not say where it leads.
            single(through)
        };
        let fits = |from: usize, to: usize| {
            let (start, span) = (point(from), span(from, to));
            let near = |i: usize| span.off(start, point(i)) <= self.settings.chord_tolerance_mm;
            to == from + 1 || ((from + 1..to).all(near) && even(from, to))
        };
        let mut targets = Vec::new();
        let mut from = 0;
        while from < steps {
            let to = furthest(from, steps, &fits);
            let (span, end_s) = (span(from, to), if to == steps { until_s } else { at(to) });
            let joint_s = at(from) + (end_s - at(from)) * span.share_at_joint(point(from));
            let joint = span.joint.map(|element| Target { element, time_s: joint_s, slow_s: None });
            targets.extend(joint.into_iter().chain([Target { element: span.end, time_s: end_s, slow_s: None }]));
            from = to;
        }
        let Some(slow) = slow else { return targets };
        if !is_slow {
            let slow_s = Some((to_mm - slow.from_mm) / slow.speed_mm_s);
            targets.push(Target { element: Element { point: end, arc: None }, time_s: to_s, slow_s });
            return targets;
        }
        let slow_s = Some(length / slow.speed_mm_s / targets.len() as f64);
        targets.into_iter().map(|target| Target { slow_s, ..target }).collect()
    }

    /// Least number of points in a move, whatever the time between them: those that the shape of an arc needs.
    fn least_steps(&self, step: &Move) -> usize {
        let MoveKind::Arc(arc) = step.kind else { return 1 };
        let of_line = 2.0 * (1.0 - SAGITTA_MM / arc.radius_start_mm.max(SAGITTA_MM)).acos();
        let angle = if self.writes_arcs() { MOST_ANGLE } else { of_line.min(MOST_ANGLE) };
        (arc.sweep.abs() / angle).ceil() as usize
    }

    /// Whether arcs are written as arcs. LinuxCNC, where segments state their path mode, accelerates less in short arcs after a corner than its
    /// arcs elsewhere: the circle of `tests/linuxcnc/story.sh` had 0.56 µm RMS as 169 lines and arcs, and 0.30 µm as 664 lines.
    fn writes_arcs(&self) -> bool {
        let is_dialogue = self.part.program.language() == Language::Dialogue;
        let is_rounded = self.settings.decimals < LEAST_ARC_DECIMALS;
        let is_timed = self.settings.encoding == TimeEncoding::G93 && self.part.counts_by_radius();
        !is_timed
            && !is_rounded
            && !is_dialogue
            && !self.part.states_path
            && !self.part.plan.desired.kinematics().has_rotary_axes()
    }

    /// The arc of a move that is written as arcs.
    fn arc_of<'b>(&self, step: &'b Move) -> Option<&'b Arc> {
        match &step.kind {
            MoveKind::Arc(arc) if self.writes_arcs() => Some(arc),
            _ => None,
        }
    }

    /// Direction of the corrected path in the plane of an arc, of length 1, at a share of the arc and the time of it.
    fn direction(&self, arc: &Arc, share: f64, time_s: f64) -> [f64; 2] {
        let [first, second, _] = arc.plane.axes();
        let (sin, cos) = (arc.start_angle + arc.sweep * share).sin_cos();
        let growth = arc.radius_end_mm - arc.radius_start_mm;
        // By the share of the arc, whose radius changes with the rounding of the program.
        let turn = (arc.radius_start_mm + growth * share) * arc.sweep;
        let mut direction = [growth * cos - turn * sin, growth * sin + turn * cos];
        let length = norm(direction);
        direction = direction.map(|by| by / length);
        let samples = &self.part.plan.samples;
        let period = self.part.plan.desired.trajectory().period_s();
        let at = ((time_s / period).round() as usize).min(samples.len() - 1);
        let (before, after) = (at.saturating_sub(1), (at + 1).min(samples.len() - 1));
        let passed_mm = samples[after].position_mm - samples[before].position_mm;
        // Near a standstill the correction has no defined slope.
        if passed_mm > LEAST_PASSED_MM {
            let by = |values: &[Vec6]| (values[after] - values[before]) / passed_mm;
            let slope = by(self.shifts);
            direction = match self.rounded.map(by) {
                Some(path) => [path[first] + slope[first], path[second] + slope[second]],
                None => [direction[0] + slope[first], direction[1] + slope[second]],
            };
        }
        let length = norm(direction);
        direction.map(|by| by / length)
    }
}

/// The furthest index from `from` up to `last` that fits: doubled while it fits, then halved.
fn furthest(from: usize, last: usize, fits: &impl Fn(usize, usize) -> bool) -> usize {
    let most = last.min(from + MOST_POINTS);
    let (mut good, mut reach) = (from + 1, 2);
    while good < most && fits(from, (from + reach).min(most)) {
        good = (from + reach).min(most);
        reach *= 2;
    }
    let mut bad = (from + reach).min(most + 1);
    while bad > good + 1 {
        let between = good.midpoint(bad);
        if fits(from, between) { good = between } else { bad = between }
    }
    good
}

/// Largest error along the path at points of a timed line, mm.
const ALONG_PATH_MM: f64 = 0.02;

/// Largest number of possible points within one line or arc; it bounds the time of the check.
const MOST_POINTS: usize = 1024;

/// Least decimals of coordinates in mm for arcs. With fewer, rounding makes the radii at both ends differ by more than the 5 µm that LinuxCNC accepts.
const LEAST_ARC_DECIMALS: usize = 3;

/// Least distance that the plan passes in two periods for a slope of the correction there, mm.
const LEAST_PASSED_MM: f64 = 1e-3;

/// Distance from the corrected curve within a step up to which no kink is taken instead, mm.
const WITHIN_STEP_MM: f64 = 2e-3;

/// Largest angle of an arc between points, rad. Fewer points would not show its shape.
const MOST_ANGLE: f64 = 0.25;

/// Largest distance of a line from its arc where arcs are not written as arcs, mm, whatever the time between points. At 5 m/s² it is that
/// of lines of 1.8 ms.
const SAGITTA_MM: f64 = 2e-3;

/// Least number of moves for each parallel task.
const MOVES_PER_TASK: usize = 256;
