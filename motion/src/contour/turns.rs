//! Turns about a tip that hardly moves: there a place on the path is known by the tool axis, or by the angles of the rotary axes, not by the tip.

use std::ops::Range;

use crate::{AxisKind, DesiredPath, Pose, Trajectory, Vec3};

/// Lever at which a turn of the tool counts as a way of its tip, mm: the depth of cut of a side mill.
pub const LEVER_MM: f64 = 20.0;
/// A tip that moves less than this share of the turn's way hardly moves.
const HARDLY: f64 = 0.2;
/// Share with which the distance of tips counts when the nearest pose is sought: it only tells a turn from the moves before and after it.
const TIP_SHARE: f64 = 0.1;
/// Way of a tip that stands in one place, mm: more than the noise of a run.
const STANDS_MM: f64 = 0.01;
/// Samples over which both ways are taken: in a recorded run the tip is never quite at rest.
const SPAN: usize = 4;
/// Samples without a nearer pose, and their way at the lever, mm, after which the search for it ends; and the samples after which it ends in a rest.
const PATIENCE: (usize, f64) = (8, 0.1);
const PATIENCE_AT_REST: usize = 200;
/// Samples by which a run may be late or early.
const LATE: usize = 100;

/// A place on a path that is known by the tool's tip and by how far something has turned.
pub trait Turning {
    /// Tool tip, mm.
    fn tip(&self) -> Vec3;
    /// Tool axis, or angles, rad.
    fn turned(&self) -> Vec3;
}

/// Turned is the tool.
impl Turning for Pose {
    fn tip(&self) -> Vec3 {
        self.tip
    }

    fn turned(&self) -> Vec3 {
        self.tool
    }
}

/// Tool tip and angles of the rotary axes, rad: a table that turns about the tool's own axis changes the angles alone.
pub(super) struct Turned {
    pub tip: Vec3,
    pub angles: Vec3,
}

impl Turning for Turned {
    fn tip(&self) -> Vec3 {
        self.tip
    }

    fn turned(&self) -> Vec3 {
        self.angles
    }
}

/// The samples of a run with these tips.
pub(super) fn turned(run: &Trajectory, tips: Vec<Vec3>) -> Vec<Turned> {
    let rotary = run.axes().iter().zip(run.columns()).filter(|(axis, _)| axis.kind == AxisKind::Rotary);
    let angles: Vec<&[f64]> = rotary.map(|(_, column)| column.as_slice()).collect();
    let at = |k: usize| Vec3::from_fn(|row, _| angles.get(row).map_or(0.0, |angles| angles[k]));
    tips.into_iter().enumerate().map(|(k, tip)| Turned { tip, angles: at(k) }).collect()
}

/// The samples in which rotary axes turn about a tip that hardly moves, with those before and after them; about the tool's own axis too.
#[must_use]
pub fn axis_turns(desired: &DesiredPath) -> Vec<Range<usize>> {
    turns(&turned(desired.trajectory(), desired.tips()))
}

/// The samples of turns about tips that hardly move, with the samples before and after them.
#[must_use]
pub fn turns(poses: &[impl Turning]) -> Vec<Range<usize>> {
    let mut turns: Vec<Range<usize>> = Vec::new();
    for from in 0..poses.len().saturating_sub(1) {
        let to = (from + SPAN).min(poses.len() - 1);
        let (a, b) = (&poses[from], &poses[to]);
        let way_mm = LEVER_MM * (b.turned() - a.turned()).norm();
        if way_mm > 0.0 && (b.tip() - a.tip()).norm() <= HARDLY * way_mm {
            match turns.last_mut() {
                Some(last) if from < last.end => last.end = to + 1,
                _ => turns.push(from..to + 1),
            }
        }
    }
    turns
}

/// A turn, and the samples before and after it at which the tip stands in the same place: there every pose is that of an end of the turn.
pub(super) struct Turn {
    pub samples: Range<usize>,
    rests: Range<usize>,
}

/// The turns of a path with their rests.
pub(super) fn with_rests(poses: &[Pose]) -> Vec<Turn> {
    let turns = turns(poses);
    let starts = turns.iter().skip(1).map(|next| next.start).chain([poses.len()]);
    let mut before = 0;
    let rests = |(turn, next): (&Range<usize>, usize)| {
        let stays = |at: usize| move |pose: &&Pose| (pose.tip - poses[at].tip).norm() <= STANDS_MM;
        let waits = poses[before..turn.start].iter().rev().take_while(stays(turn.start)).count();
        let stands = poses[turn.end..next.max(turn.end)].iter().take_while(stays(turn.end - 1)).count();
        before = turn.end;
        Turn { samples: turn.clone(), rests: turn.start - waits..turn.end + stands }
    };
    turns.iter().zip(starts).map(rests).collect()
}

/// The turn at a sample, or near it.
pub(super) fn turn_at(turns: &[Turn], sample: usize) -> Option<&Range<usize>> {
    let next = turns.partition_point(|turn| turn.samples.end <= sample);
    let away = |turn: &&Turn| turn.rests.start.saturating_sub(sample).max((sample + 1).saturating_sub(turn.rests.end));
    let near = turns[next.saturating_sub(1)..(next + 1).min(turns.len())].iter().min_by_key(away)?;
    (away(&near) <= LATE).then_some(&near.samples)
}

/// Distance of two places, mm: a share of that of the tips, and that of the turn at the lever.
pub(super) fn apart_mm(a: &impl Turning, b: &impl Turning) -> f64 {
    (TIP_SHARE * (a.tip() - b.tip()).norm()).hypot(LEVER_MM * (a.turned() - b.turned()).norm())
}

/// Nearest place to `place` on the lines between those of a turn, as a sample index with fraction; sought from sample `start` on to either side.
/// `None` where the turn holds no line.
pub(super) fn nearest<T: Turning>(path: &[T], turn: &Range<usize>, start: usize, place: &T) -> Option<f64> {
    let last = turn.end.checked_sub(2).filter(|last| *last >= turn.start)?;
    let on = |k: usize| {
        let weighted = |a: &T, b: &T| (TIP_SHARE * (b.tip() - a.tip()), LEVER_MM * (b.turned() - a.turned()));
        let ((tip, turned), (off, off_turned)) = (weighted(&path[k], &path[k + 1]), weighted(&path[k], place));
        let square = tip.norm_squared() + turned.norm_squared();
        let share = if square > 0.0 { ((off.dot(&tip) + off_turned.dot(&turned)) / square).clamp(0.0, 1.0) } else { 0.0 };
        let apart = (off - tip * share).norm_squared() + (off_turned - turned * share).norm_squared();
        (apart, k as f64 + share)
    };
    let start = start.clamp(turn.start, last);
    let mut best = on(start);
    let mut seek = |segments: &mut dyn Iterator<Item = usize>| {
        let (mut idle, mut idle_mm) = (0, 0.0);
        for segment in segments {
            let found = on(segment);
            if found.0 < best.0 {
                (best, idle, idle_mm) = (found, 0, 0.0);
                continue;
            }
            idle += 1;
            idle_mm += LEVER_MM * (path[segment + 1].turned() - path[segment].turned()).norm();
            if idle > PATIENCE.0 && (idle_mm > PATIENCE.1 || idle > PATIENCE_AT_REST) {
                break;
            }
        }
    };
    seek(&mut (start + 1..=last));
    seek(&mut (turn.start..start).rev());
    Some(best.1)
}
