//! Turns of the tool about a tip that hardly moves: there a place on the path is known by the tool axis, not by the tip.

use std::ops::Range;

use crate::Pose;

/// Lever at which a turn counts as a way, mm: the depth of cut of a side mill.
const LEVER_MM: f64 = 20.0;
/// A tip that moves less than this share of the turn's way hardly moves.
const HARDLY: f64 = 0.2;
/// Share with which the distance of tips counts when the nearest pose is sought: it only tells a turn from the moves before and after it.
const TIP_SHARE: f64 = 0.1;
/// Way of a tip that stands in one place, mm: more than the noise of a run.
const STANDS_MM: f64 = 0.01;
/// Samples over which both ways are taken: in a recorded run the tip is never quite at rest.
const SPAN: usize = 4;
/// Samples without a nearer pose after which the search for it ends.
const PATIENCE: usize = 8;
/// Distances that differ by less are the same, mm.
const SAME_MM: f64 = 1e-9;
/// Samples by which a run may be late or early.
const LATE: usize = 100;

/// The samples of turns about tips that hardly move, with the samples before and after them.
#[must_use]
pub fn turns(poses: &[Pose]) -> Vec<Range<usize>> {
    let mut turns: Vec<Range<usize>> = Vec::new();
    for from in 0..poses.len().saturating_sub(1) {
        let to = (from + SPAN).min(poses.len() - 1);
        let (a, b) = (&poses[from], &poses[to]);
        let way_mm = LEVER_MM * (b.tool - a.tool).norm();
        if way_mm > 0.0 && (b.tip - a.tip).norm() <= HARDLY * way_mm {
            match turns.last_mut() {
                Some(last) if from < last.end => last.end = to + 1,
                _ => turns.push(from..to + 1),
            }
        }
    }
    turns
}

/// The turns with the samples before and after them at which the tip stands in the same place.
pub(super) fn with_rests(turns: &[Range<usize>], poses: &[Pose]) -> Vec<Range<usize>> {
    let stays = |at: usize| move |pose: &&Pose| (pose.tip - poses[at].tip).norm() <= STANDS_MM;
    let mut out: Vec<Range<usize>> = Vec::with_capacity(turns.len());
    for turn in turns {
        // What is already known to be one place is not looked at again.
        let known = out.last().map_or(0, |last| last.end);
        let from = known.min(turn.start);
        let before = poses[from..turn.start].iter().rev().take_while(stays(turn.start)).count();
        let end = turn.end.max(known);
        let after = poses[end..].iter().take_while(stays(turn.end - 1)).count();
        match out.last_mut() {
            Some(last) if turn.start - before <= last.end => last.end = end + after,
            _ => out.push(turn.start - before..end + after),
        }
    }
    out
}

/// The turn at a sample, or near it.
pub(super) fn turn_at(turns: &[Range<usize>], sample: usize) -> Option<&Range<usize>> {
    let next = turns.partition_point(|turn| turn.end <= sample);
    let away = |turn: &&Range<usize>| turn.start.saturating_sub(sample).max((sample + 1).saturating_sub(turn.end));
    turns[next.saturating_sub(1)..(next + 1).min(turns.len())].iter().min_by_key(away).filter(|turn| away(turn) <= LATE)
}

/// Distance of two poses, mm: a share of that of the tips, and that of the tool axes at the lever.
pub(super) fn apart_mm(a: &Pose, b: &Pose) -> f64 {
    (TIP_SHARE * (a.tip - b.tip).norm()).hypot(LEVER_MM * (a.tool - b.tool).norm())
}

/// Nearest pose to `pose` on the lines between those of a turn, and its position as a sample index with fraction; sought from sample `start` on to either side.
/// `None` where the turn holds no line.
pub(super) fn nearest(path: &[Pose], turn: &Range<usize>, start: usize, pose: &Pose) -> Option<(Pose, f64)> {
    let last = turn.end.checked_sub(2).filter(|last| *last >= turn.start)?;
    let on = |k: usize| {
        let (from, to) = (&path[k], &path[k + 1]);
        let weighted = |a: &Pose, b: &Pose| (TIP_SHARE * (b.tip - a.tip), LEVER_MM * (b.tool - a.tool));
        let ((tip, tool), (off, turned)) = (weighted(from, to), weighted(from, pose));
        let square = tip.norm_squared() + tool.norm_squared();
        let share = if square > 0.0 { ((off.dot(&tip) + turned.dot(&tool)) / square).clamp(0.0, 1.0) } else { 0.0 };
        let tool = from.tool.lerp(&to.tool, share).try_normalize(0.0).unwrap_or(from.tool);
        (Pose { tip: from.tip.lerp(&to.tip, share), tool }, k as f64 + share)
    };
    let start = start.clamp(turn.start, last);
    let mut best = on(start);
    let mut seek = |segments: &mut dyn Iterator<Item = usize>| {
        let mut idle = 0;
        for found in segments.map(on) {
            // Over a rest all are as near.
            let [found_mm, best_mm] = [&found, &best].map(|of| apart_mm(pose, &of.0));
            if found_mm < best_mm {
                best = found;
            }
            idle = if found_mm <= best_mm + SAME_MM { 0 } else { idle + 1 };
            if idle > PATIENCE {
                break;
            }
        }
    };
    seek(&mut (start + 1..=last));
    seek(&mut (turn.start..start).rev());
    Some(best)
}
