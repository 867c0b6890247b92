//! The fastest speed over arc length that holds the limits.

use rayon::prelude::*;

use super::excess::Excess;
use super::geometry::{Node, Shape, Stretch};
use crate::share::in_parts;
use crate::{Axis, AxisLimits, Limits, SHARE};

/// A part of the profile with constant acceleration.
#[derive(Debug, Clone, Copy)]
pub(super) struct Phase {
    pub duration_s: f64,
    /// Speed at its start, mm/s.
    pub speed: f64,
    /// Acceleration, mm/s².
    pub acceleration: f64,
}

/// Slowest speed that is ever planned between rests, mm/s: keeps a cusp from taking for ever.
const CRAWL_MM_S: f64 = 1e-3;

/// Squared speed caps at the nodes of a stretch.
pub(super) struct SpeedLimit<'a> {
    nodes: &'a [Node],
    /// Way from the node before, mm; zero at the first.
    steps: Vec<f64>,
    /// Least acceleration along the path that is ever planned with, mm/s².
    least_acceleration: f64,
    /// What bounds the acceleration along the path, node after node.
    room: Vec<AccelerationBound>,
    /// Where the bounds of each node begin, and where those of the last one end.
    room_of: Vec<usize>,
    /// Cap on the squared speed at every node, mm²/s².
    cap: Vec<f64>,
    /// Factor, at most 1, on the acceleration in the interval that ends at the node.
    share: Vec<f64>,
    /// The last profile: squared speed at every node.
    squared: Vec<f64>,
}

/// A bound on the acceleration along the path that falls with the squared speed `w`: `most − bend·w`, mm/s².
#[derive(Debug, Clone, Copy)]
struct AccelerationBound {
    most: f64,
    bend: f64,
}

impl AccelerationBound {
    fn at(&self, squared: f64) -> f64 {
        self.most - self.bend * squared
    }

    /// Whether this bound says nothing beside another for squared speeds up to `top`.
    fn follows_from(&self, other: &Self, top: f64) -> bool {
        other.most <= self.most && other.at(top) <= self.at(top)
    }
}

/// Shapes in the parts in which they were laid, none of them empty.
struct Parts<'a> {
    shapes: &'a [Vec<Shape>],
    /// Number of the first node of each part.
    first: Vec<usize>,
}

impl<'a> Parts<'a> {
    fn new(shapes: &'a [Vec<Shape>]) -> Self {
        let first = shapes.iter().scan(0, |next, part| Some(std::mem::replace(next, *next + part.len())));
        Self { shapes, first: first.collect() }
    }

    fn of(&self, part: usize) -> &'a [Shape] {
        &self.shapes[part]
    }

    /// The shape of node `k`, which lies in a part or beside it.
    fn shape(&self, part: usize, k: usize) -> Option<&'a Shape> {
        match k.checked_sub(self.first[part]) {
            None => self.shapes[part.checked_sub(1)?].last(),
            Some(index) => self.shapes[part].get(index).or_else(|| self.shapes.get(part + 1)?.first()),
        }
    }
}

impl<'a> SpeedLimit<'a> {
    pub fn new(stretch: &'a Stretch<'a>, axes: &[Axis], limits: &Limits, period_s: f64) -> Self {
        let nodes = &stretch.nodes;
        let axes: Vec<(usize, AxisLimits)> =
            axes.iter().zip(&limits.axes).filter_map(|(axis, limit)| Some((axis.slot()?, *limit))).collect();
        let steps: Vec<f64> = std::iter::once(0.0).chain(nodes.windows(2).map(|pair| pair[1].s - pair[0].s)).collect();
        let parts = Parts::new(&stretch.shapes);
        let cap_of_part = |part: usize| {
            let shapes = parts.of(part);
            let mut cap: Vec<f64> = Vec::with_capacity(shapes.len());
            for (k, shape) in (parts.first[part]..).zip(shapes) {
                let feed = stretch.feed_mm_s(&nodes[k]).min(limits.path_velocity_mm_s / shape.point[0]);
                let mut most = pointwise(shape, &axes, limits).min(feed * feed);
                // A jump of curvature is a jump of acceleration, to be taken within one period.
                let joint = |k: usize| steps.get(k).is_some_and(|step| *step <= 0.0);
                let before = (k > 0 && joint(k)).then(|| parts.shape(part, k - 1));
                let after = joint(k + 1).then(|| parts.shape(part, k + 1));
                for beyond in before.into_iter().chain(after).flatten() {
                    for (slot, limit) in &axes {
                        let jump = shape.axes[1][*slot] - beyond.axes[1][*slot];
                        most = most.min(limit.jerk * period_s / jump.abs());
                    }
                }
                cap.push(most.max(CRAWL_MM_S * CRAWL_MM_S));
            }
            cap
        };
        let caps: Vec<Vec<f64>> = (0..stretch.shapes.len()).into_par_iter().map(cap_of_part).collect();
        let cap = caps.concat();
        // Room may be exhausted at the fastest places; a hundredth keeps the passes from locking there.
        let least_acceleration = 0.01 * limits.path_acceleration_mm_s2;
        let room_of_part = |part: usize| {
            let shapes = parts.of(part);
            let mut room: Vec<AccelerationBound> = Vec::with_capacity(shapes.len());
            let mut ends = Vec::with_capacity(shapes.len());
            for (k, shape) in (parts.first[part]..).zip(shapes) {
                // The speed at a node is asked for with that of its neighbours.
                let top = cap[k.saturating_sub(1)..nodes.len().min(k + 2)].iter().copied().fold(0.0, f64::max);
                let first = ends.last().copied().unwrap_or(0);
                bounds(shape, stretch.acceleration(&nodes[k]), &axes, limits).for_each(|bound| add(bound, top, first, &mut room));
                ends.push(room.len());
            }
            (room, ends)
        };
        let rooms: Vec<(Vec<AccelerationBound>, Vec<usize>)> =
            (0..stretch.shapes.len()).into_par_iter().map(room_of_part).collect();
        let mut room: Vec<AccelerationBound> = Vec::with_capacity(rooms.iter().map(|(room, _)| room.len()).sum());
        let mut room_of = Vec::with_capacity(nodes.len() + 1);
        room_of.push(0);
        for (part, ends) in rooms {
            room_of.extend(ends.into_iter().map(|end| room.len() + end));
            room.extend(part);
        }
        let share = vec![1.0; nodes.len()];
        Self { nodes, steps, least_acceleration, room, room_of, cap, share, squared: Vec::new() }
    }

    /// The fastest profile from rest to rest, in parts.
    pub fn fastest(&mut self) -> Vec<Vec<Phase>> {
        let squared = self.slowed_for_what_comes(&self.sped_up());
        let phases = in_parts(squared.len(), |part| {
            let mut phases = Vec::with_capacity(part.len());
            for k in part.start.max(1)..part.end {
                let ds = self.steps[k];
                if ds > 0.0 {
                    let (e0, e1) = (squared[k - 1], squared[k]);
                    let needed = (e1 - e0).abs() / (2.0 * ds);
                    let acceleration = self.acceleration(k, k, e0.max(e1)).max(needed);
                    let top = self.cap[k].min(self.cap[k - 1]).max(e0.max(e1));
                    interval(ds, e0, e1, acceleration, top, &mut phases);
                }
            }
            phases
        });
        self.squared = squared;
        phases
    }

    /// Squared speeds that can be reached from the rest at the start, with a rest at the end.
    ///
    /// Every part first takes it that it may begin as fast as its first node allows; then what the part before it comes to is carried on until it
    /// makes no difference.
    fn sped_up(&self) -> Vec<f64> {
        let n = self.cap.len();
        let top = |k: usize| if k == 0 || k + 1 == n { 0.0 } else { self.cap[k] };
        let mut squared = in_parts(n, |part| {
            let mut out: Vec<f64> = Vec::with_capacity(part.len());
            for k in part {
                let reached = out.last().map_or(f64::INFINITY, |before| self.reach(k, k - 1, *before));
                out.push(top(k).min(reached));
            }
            out
        })
        .concat();
        for start in (SHARE..n).step_by(SHARE) {
            for k in start..n {
                let now = top(k).min(self.reach(k, k - 1, squared[k - 1]));
                if now == squared[k] {
                    break;
                }
                squared[k] = now;
            }
        }
        squared
    }

    /// Those of `tops` from which what comes can be slowed down for; by parts, as in [`Self::sped_up`].
    fn slowed_for_what_comes(&self, tops: &[f64]) -> Vec<f64> {
        let n = tops.len();
        let mut squared = in_parts(n, |part| {
            let mut out = tops[part.clone()].to_vec();
            for k in (part.start + 1..part.end).rev() {
                out[k - 1 - part.start] = tops[k - 1].min(self.reach(k, k, out[k - part.start]));
            }
            out
        })
        .concat();
        for end in (SHARE..n).step_by(SHARE).rev() {
            for k in (1..=end).rev() {
                let now = tops[k - 1].min(self.reach(k, k, squared[k]));
                if now == squared[k - 1] {
                    break;
                }
                squared[k - 1] = now;
            }
        }
        squared
    }

    /// Squared speed that can be reached over the interval ending at `k`, from `squared` at node `at`.
    fn reach(&self, k: usize, at: usize, squared: f64) -> f64 {
        squared + 2.0 * self.acceleration(k, at, squared) * self.steps[k]
    }

    /// Acceleration along the path that the axes leave room for at node `at`, mm/s².
    fn acceleration(&self, k: usize, at: usize, squared: f64) -> f64 {
        let room = &self.room[self.room_of[at]..self.room_of[at + 1]];
        let most = room.iter().fold(f64::INFINITY, |most, room| most.min(room.at(squared)));
        most.max(self.least_acceleration) * self.share[k]
    }

    /// Lowers speed and acceleration where samples of `motion` exceed a limit.
    ///
    /// Smoothing mixes positions over `spread_s`, so that far around a sample counts. `keep` is the share of the squared speed that is kept beyond
    /// what the limit asks for.
    pub fn lower(&mut self, motion: &[f64], excess: &[Excess], spread_s: f64, period_s: f64, keep: f64) {
        let reach = (0.5 * spread_s / period_s).ceil() as usize + 3;
        let mut factor = vec![1.0_f64; self.nodes.len()];
        for Excess { sample, order, ratio, .. } in excess {
            let from = motion[sample.saturating_sub(reach)];
            let to = motion[(sample + reach).min(motion.len() - 1)];
            let first = self.nodes.partition_point(|node| node.s < from).saturating_sub(1);
            let last = self.nodes.partition_point(|node| node.s <= to).min(self.nodes.len() - 1);
            let wanted = ratio.min(4.0).powf(-2.0 / *order as f64) * keep;
            for value in &mut factor[first..=last] {
                *value = value.min(wanted);
            }
        }
        for (k, factor) in factor.iter().enumerate() {
            if *factor < 1.0 {
                let now = self.squared[k].max(CRAWL_MM_S * CRAWL_MM_S);
                self.cap[k] = self.cap[k].min(now * factor).max(CRAWL_MM_S * CRAWL_MM_S);
                self.share[k] *= factor.sqrt();
            }
        }
    }
}

/// Adds a bound to those of a node, which begin at `first`, unless it follows from one of them; drops those that follow from it.
fn add(bound: AccelerationBound, top: f64, first: usize, room: &mut Vec<AccelerationBound>) {
    if room[first..].iter().any(|other| bound.follows_from(other, top)) {
        return;
    }
    let mut kept = first;
    for k in first..room.len() {
        if !room[k].follows_from(&bound, top) {
            room[kept] = room[k];
            kept += 1;
        }
    }
    room.truncate(kept);
    room.push(bound);
}

/// What bounds the acceleration along the path at one place: the path itself, of whose acceleration `part` may be used, and every axis.
fn bounds(shape: &Shape, part: f64, axes: &[(usize, AxisLimits)], limits: &Limits) -> impl Iterator<Item = AccelerationBound> {
    let [tangent, normal, _] = shape.axes;
    // Along a turn on the spot the path has no acceleration of its own.
    let path = AccelerationBound { most: part * limits.path_acceleration_mm_s2 / shape.point[0].max(1e-3), bend: 0.0 };
    let of_axis = move |(slot, limit): &(usize, AxisLimits)| match tangent[*slot].abs() {
        share if share > 1e-9 => AccelerationBound { most: limit.acceleration / share, bend: normal[*slot].abs() / share },
        _ => AccelerationBound { most: f64::INFINITY, bend: 0.0 },
    };
    std::iter::once(path).chain(axes.iter().map(of_axis))
}

/// Cap on the squared speed at one place: feed aside, everything that does not depend on acceleration along the path.
fn pointwise(shape: &Shape, axes: &[(usize, AxisLimits)], limits: &Limits) -> f64 {
    let [tangent, normal, third] = &shape.axes;
    let (mut speed, mut squared, mut cubed) = (f64::INFINITY, limits.centripetal_mm_s2 / shape.point[1], f64::INFINITY);
    for (slot, limit) in axes {
        speed = speed.min(limit.velocity / tangent[*slot].abs());
        squared = squared.min(limit.acceleration / normal[*slot].abs());
        cubed = cubed.min(limit.jerk / third[*slot].abs());
    }
    squared.min(speed * speed).min(cubed.cbrt().powi(2))
}

/// Phases over one interval: up to the top, along it, down.
fn interval(ds: f64, e0: f64, e1: f64, acceleration: f64, top: f64, phases: &mut Vec<Phase>) {
    let peak = top.min(0.5 * (e0 + e1) + acceleration * ds).max(e0).max(e1);
    let (v0, v1, vp) = (e0.sqrt(), e1.sqrt(), peak.sqrt());
    let mut push = |duration_s: f64, speed: f64, acceleration: f64| {
        if duration_s > 0.0 {
            phases.push(Phase { duration_s, speed, acceleration });
        }
    };
    let up = (peak - e0) / (2.0 * acceleration);
    let down = (peak - e1) / (2.0 * acceleration);
    push((vp - v0) / acceleration, v0, acceleration);
    if vp > 0.0 {
        push((ds - up - down).max(0.0) / vp, vp, 0.0);
    }
    push((vp - v1) / acceleration, vp, -acceleration);
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::piece::{AxisSlots, Piece};
    use super::*;
    use crate::curves::Line;
    use crate::{Cartesian, Vec3};

    #[test]
    fn parts_come_to_the_same_bits_as_the_whole() {
        let machine = Cartesian::new(Axis::xyz());
        let machine = AxisSlots::of(&machine);
        // Fast lines of 1 mm, five nodes each, with slow ones just before and after every part's end: the ramps reach from one part into the other.
        let nodes = 5;
        let piece = |k: usize| {
            let (start, end) = (Vec3::new(k as f64, 0.0, 0.0), Vec3::new(k as f64 + 1.0, 0.0, 0.0));
            let slow = [10, SHARE - 30].iter().any(|place| (k * nodes + SHARE - place) % SHARE < nodes);
            Piece::whole(Arc::new(Line { start, end }), if slow { 5.0 + k as f64 * 1e-3 } else { 300.0 })
        };
        let pieces: Vec<Piece> = (0..2500).map(piece).collect();
        let index: Vec<usize> = (0..pieces.len()).collect();
        let stretch = Stretch::new(&pieces, &index, &machine, &[0.0; 3]).unwrap().unwrap();
        let limits = Limits::uniform(3, 1000.0, 500.0, 0.02);
        let speed = SpeedLimit::new(&stretch, machine.kinematics.axes(), &limits, 0.002);
        let n = speed.cap.len();
        assert_eq!(n, nodes * pieces.len());

        let mut whole = speed.cap.clone();
        (whole[0], whole[n - 1]) = (0.0, 0.0);
        for k in 1..n {
            whole[k] = whole[k].min(speed.reach(k, k - 1, whole[k - 1]));
        }
        let tops = speed.sped_up();
        assert_eq!(tops, whole);
        for k in (1..n).rev() {
            whole[k - 1] = whole[k - 1].min(speed.reach(k, k, whole[k]));
        }
        assert_eq!(speed.slowed_for_what_comes(&tops), whole);
        // Both kinds of ramps lie across ends of parts.
        let ends = || (SHARE..n).step_by(SHARE);
        assert!(ends().any(|k| tops[k - 1] < tops[k] && tops[k] < speed.cap[k]));
        assert!(ends().any(|k| whole[k] < whole[k - 1] && whole[k - 1] < tops[k - 1]));
    }
}
