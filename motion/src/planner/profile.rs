//! The fastest speed over arc length within the limits.

use rayon::prelude::*;

use super::excess::Excess;
use super::geometry::{Node, Segment, Shape};
use super::look_ahead::{self, MIN_SPEED_MM_S};
use super::piece::SMOOTH_RAD;
use super::settings::PlanSettings;
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

/// Squared speed caps at the nodes of a segment.
pub(super) struct SpeedLimit<'a> {
    nodes: &'a [Node],
    /// Arc length from the previous node, mm. Zero at the first.
    steps: Vec<f64>,
    /// Lower bound on the planned acceleration along the path, mm/s².
    least_acceleration: f64,
    /// Bounds on the acceleration along the path, in node order.
    bounds: Vec<AccelerationBound>,
    /// Start index of the bounds of each node, and the end index of the last.
    bounds_of: Vec<usize>,
    /// Cap on the squared speed at every node, mm²/s².
    cap: Vec<f64>,
    /// Factor, at most 1, on the acceleration in the interval that ends at the node.
    share: Vec<f64>,
    /// The last profile: squared speed at every node.
    squared: Vec<f64>,
}

/// A bound on the acceleration along the path that falls with the squared speed `w`: `most −
/// bend·w`, mm/s².
#[derive(Debug, Clone, Copy)]
struct AccelerationBound {
    most: f64,
    bend: f64,
}

impl AccelerationBound {
    fn at(&self, squared: f64) -> f64 {
        self.most - self.bend * squared
    }

    /// Whether this bound is implied by another for squared speeds up to `top`.
    fn follows_from(&self, other: &Self, top: f64) -> bool {
        other.most <= self.most && other.at(top) <= self.at(top)
    }
}

/// Shapes in the parts in which they were built, none of them empty.
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

    /// The shape of node `k`, which lies in a part or next to it.
    fn shape(&self, part: usize, k: usize) -> Option<&'a Shape> {
        match k.checked_sub(self.first[part]) {
            None => self.shapes[part.checked_sub(1)?].last(),
            Some(index) => self.shapes[part].get(index).or_else(|| self.shapes.get(part + 1)?.first()),
        }
    }
}

impl<'a> SpeedLimit<'a> {
    pub fn new(segment: &'a Segment<'a>, axes: &[Axis], limits: &Limits, settings: &PlanSettings) -> Self {
        let PlanSettings { corners, period_s, .. } = *settings;
        let nodes = &segment.nodes;
        let axes: Vec<(usize, AxisLimits)> =
            axes.iter().zip(&limits.axes).filter_map(|(axis, limit)| Some((axis.slot()?, *limit))).collect();
        let steps: Vec<f64> = std::iter::once(0.0).chain(nodes.windows(2).map(|pair| pair[1].s - pair[0].s)).collect();
        let parts = Parts::new(&segment.shapes);
        let is_alone = nodes.first().zip(nodes.last()).is_some_and(|(first, last)| first.piece == last.piece);
        let arcs = ArcLimits { axes: &axes, limits, most_mm_s2: settings.arc_acceleration_mm_s2, is_alone };
        let cap_of_part = |part: usize| {
            let shapes = parts.of(part);
            let mut cap: Vec<f64> = Vec::with_capacity(shapes.len());
            for (k, shape) in (parts.first[part]..).zip(shapes) {
                let feed = segment.feed_mm_s(&nodes[k]).min(limits.path_velocity_mm_s / shape.point[0]);
                let mut most = pointwise(shape, &axes, arcs.across(shape)).min(feed * feed);
                // A jump of curvature is a jump of acceleration, which must fit into one period.
                let joint = |k: usize| steps.get(k).is_some_and(|step| *step <= 0.0);
                let before = (k > 0 && joint(k)).then(|| parts.shape(part, k - 1));
                let after = joint(k + 1).then(|| parts.shape(part, k + 1));
                for beyond in before.into_iter().chain(after).flatten() {
                    for (slot, limit) in &axes {
                        let jump = shape.axes[1][*slot] - beyond.axes[1][*slot];
                        most = most.min(limit.jerk * period_s / jump.abs());
                    }
                    let (turn_rad, jump) = shape.turn_to(beyond);
                    if turn_rad > SMOOTH_RAD {
                        most = most.min(corners.squared_speed(turn_rad, jump, limits.path_acceleration_mm_s2));
                    }
                }
                cap.push(most.max(MIN_SPEED_MM_S * MIN_SPEED_MM_S));
            }
            cap
        };
        let caps: Vec<Vec<f64>> = (0..segment.shapes.len()).into_par_iter().map(cap_of_part).collect();
        let mut cap = caps.concat();
        let pieces = look_ahead::pieces(segment);
        look_ahead::keep_piece_time(&mut cap, nodes, &pieces, settings.piece_time_s);
        // At the highest speeds no acceleration may remain. One percent keeps the passes from
        // locking there.
        let least_acceleration = 0.01 * limits.path_acceleration_mm_s2;
        let bounds_of_part = |part: usize| {
            let shapes = parts.of(part);
            let mut bounds: Vec<AccelerationBound> = Vec::with_capacity(shapes.len());
            let mut ends = Vec::with_capacity(shapes.len());
            for (k, shape) in (parts.first[part]..).zip(shapes) {
                // The speed of a node is read together with that of its neighbours.
                let top = cap[k.saturating_sub(1)..nodes.len().min(k + 2)].iter().copied().fold(0.0, f64::max);
                let first = ends.last().copied().unwrap_or(0);
                let along = arcs.along(shape, segment.is_arc(&nodes[k]));
                acceleration_bounds(shape, segment.acceleration(&nodes[k]), along, &axes, limits)
                    .for_each(|bound| add(bound, top, first, &mut bounds));
                ends.push(bounds.len());
            }
            (bounds, ends)
        };
        let bounds_of_parts: Vec<(Vec<AccelerationBound>, Vec<usize>)> =
            (0..segment.shapes.len()).into_par_iter().map(bounds_of_part).collect();
        let mut bounds: Vec<AccelerationBound> = Vec::with_capacity(bounds_of_parts.iter().map(|(bounds, _)| bounds.len()).sum());
        let mut bounds_of = Vec::with_capacity(nodes.len() + 1);
        bounds_of.push(0);
        for (part, ends) in bounds_of_parts {
            bounds_of.extend(ends.into_iter().map(|end| bounds.len() + end));
            bounds.extend(part);
        }
        let share = vec![1.0; nodes.len()];
        let mut speed = Self { nodes, steps, least_acceleration, bounds, bounds_of, cap, share, squared: Vec::new() };
        if let Some(ahead) = settings.look_ahead {
            speed.cap = look_ahead::caps(&speed.cap, &pieces, ahead, |k, squared| speed.reach(k, k, squared));
        }
        speed
    }

    /// The fastest profile from standstill to standstill, in parts.
    pub fn fastest(&mut self) -> Vec<Vec<Phase>> {
        let squared = self.decelerated(&self.accelerated());
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

    /// Squared speeds reachable from standstill at the start, with standstill at the end.
    ///
    /// Every part first assumes that it may begin at the cap of its first node. Then the result of
    /// the part before it is propagated until it makes no difference.
    fn accelerated(&self) -> Vec<f64> {
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

    /// Those of `tops` from which braking to the later ones is possible. By parts, as in
    /// [`Self::accelerated`].
    fn decelerated(&self, tops: &[f64]) -> Vec<f64> {
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

    /// Acceleration along the path that the axis limits leave at node `at`, mm/s².
    fn acceleration(&self, k: usize, at: usize, squared: f64) -> f64 {
        let bounds = &self.bounds[self.bounds_of[at]..self.bounds_of[at + 1]];
        let most = bounds.iter().fold(f64::INFINITY, |most, bound| most.min(bound.at(squared)));
        most.max(self.least_acceleration) * self.share[k]
    }

    /// Lowers speed and acceleration around samples of `motion` that exceed a limit.
    ///
    /// Smoothing mixes positions over `spread_s`, so this time around a sample counts. `keep` is
    /// a factor on the squared speed that the limit allows.
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
                let now = self.squared[k].max(MIN_SPEED_MM_S * MIN_SPEED_MM_S);
                self.cap[k] = self.cap[k].min(now * factor).max(MIN_SPEED_MM_S * MIN_SPEED_MM_S);
                self.share[k] *= factor.sqrt();
            }
        }
    }
}

/// Adds a bound to those of a node, which begin at `first`, unless one of them implies it. Drops
/// those that it implies.
fn add(bound: AccelerationBound, top: f64, first: usize, bounds: &mut Vec<AccelerationBound>) {
    if bounds[first..].iter().any(|other| bound.follows_from(other, top)) {
        return;
    }
    let mut kept = first;
    for k in first..bounds.len() {
        if !bounds[k].follows_from(&bound, top) {
            bounds[kept] = bounds[k];
            kept += 1;
        }
    }
    bounds.truncate(kept);
    bounds.push(bound);
}

/// Curvature up to which a path is straight, 1/mm.
const STRAIGHT_PER_MM: f64 = 1e-12;

/// What a control with an acceleration of its own in arcs allows there. In a plane in which the axes allow less in some direction, that holds
/// in every direction.
struct ArcLimits<'a> {
    axes: &'a [(usize, AxisLimits)],
    limits: &'a Limits,
    /// Largest acceleration in arcs, along and across together, mm/s²; infinite for none.
    most_mm_s2: f64,
    /// Whether the segment is one piece from standstill to standstill.
    is_alone: bool,
}

impl ArcLimits<'_> {
    /// Largest acceleration across the path, mm/s².
    fn across(&self, shape: &Shape) -> f64 {
        let centripetal = self.limits.centripetal_mm_s2;
        if self.most_mm_s2.is_finite() { centripetal * self.together(shape).0 / self.most_mm_s2 } else { centripetal }
    }

    /// Largest acceleration along the path, mm/s²: in arcs what their fastest passage leaves, or the largest acceleration across, where the arc
    /// is alone.
    fn along(&self, shape: &Shape, is_arc: bool) -> f64 {
        if self.most_mm_s2.is_infinite() {
            return f64::INFINITY;
        }
        let (together, velocity) = self.together(shape);
        if !is_arc {
            return if shape.point[1] > STRAIGHT_PER_MM { together } else { f64::INFINITY };
        }
        let fastest = if self.is_alone { f64::INFINITY } else { velocity.powi(2) * shape.point[1] };
        let across = self.across(shape).min(fastest);
        (together.powi(2) - across.powi(2)).max(0.0).sqrt()
    }

    /// Acceleration and velocity that are allowed in every direction of the plane of the path, mm/s² and mm/s.
    fn together(&self, shape: &Shape) -> (f64, f64) {
        let unit = |vector: [f64; 3]| {
            let length = vector.iter().fold(0.0, |sum: f64, by| sum.hypot(*by));
            vector.map(|by| if length > STRAIGHT_PER_MM { by / length } else { 0.0 })
        };
        let [along, bend] = [0, 1].map(|order| [0, 1, 2].map(|slot| shape.axes[order][slot]));
        let tangent = unit(along);
        let share: f64 = bend.iter().zip(tangent).map(|(bend, tangent)| bend * tangent).sum();
        let normal = unit([0, 1, 2].map(|slot| bend[slot] - share * tangent[slot]));
        let mut most = (self.most_mm_s2, self.limits.path_velocity_mm_s);
        for (slot, limit) in self.axes.iter().filter(|(slot, _)| *slot < 3) {
            // Length of the axis's direction in the plane.
            let within = tangent[*slot].hypot(normal[*slot]);
            most = (most.0.min(limit.acceleration / within), most.1.min(limit.velocity / within));
        }
        most
    }
}

/// Bounds on the acceleration along the path at one node, of which `part` may be used: of the path itself, where no more than `along_mm_s2`
/// is allowed, and of every axis.
fn acceleration_bounds(
    shape: &Shape,
    part: f64,
    along_mm_s2: f64,
    axes: &[(usize, AxisLimits)],
    limits: &Limits,
) -> impl Iterator<Item = AccelerationBound> {
    let [tangent, normal, _] = shape.axes;
    // During a rotation without tip motion the path has no acceleration of its own.
    let along_mm_s2 = along_mm_s2.min(limits.path_acceleration_mm_s2);
    let path = AccelerationBound { most: part * along_mm_s2 / shape.point[0].max(1e-3), bend: 0.0 };
    let of_axis = move |(slot, limit): &(usize, AxisLimits)| match tangent[*slot].abs() {
        share if share > 1e-9 => {
            AccelerationBound { most: part * limit.acceleration / share, bend: part * normal[*slot].abs() / share }
        }
        _ => AccelerationBound { most: f64::INFINITY, bend: 0.0 },
    };
    std::iter::once(path).chain(axes.iter().map(of_axis))
}

/// Cap on the squared speed at one node by all limits that do not depend on acceleration along the
/// path, feed excluded.
fn pointwise(shape: &Shape, axes: &[(usize, AxisLimits)], across_mm_s2: f64) -> f64 {
    let [tangent, normal, third] = &shape.axes;
    let (mut speed, mut squared, mut cubed) = (f64::INFINITY, across_mm_s2 / shape.point[1], f64::INFINITY);
    for (slot, limit) in axes {
        speed = speed.min(limit.velocity / tangent[*slot].abs());
        squared = squared.min(limit.acceleration / normal[*slot].abs());
        cubed = cubed.min(limit.jerk / third[*slot].abs());
    }
    squared.min(speed * speed).min(cubed.cbrt().powi(2))
}

/// Phases over one interval: acceleration, constant speed, deceleration.
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
    fn parallel_parts_equal_the_whole_bit_for_bit() {
        let machine = Cartesian::new(Axis::xyz());
        let machine = AxisSlots::of(&machine);
        // Fast lines of 1 mm, five nodes each, with slow ones just before and after the end of
        // every part: the ramps extend from one part into the other.
        let nodes = 5;
        let piece = |k: usize| {
            let (start, end) = (Vec3::new(k as f64, 0.0, 0.0), Vec3::new(k as f64 + 1.0, 0.0, 0.0));
            let slow = [10, SHARE - 30].iter().any(|place| (k * nodes + SHARE - place) % SHARE < nodes);
            Piece::whole(Arc::new(Line { start, end }), if slow { 5.0 + k as f64 * 1e-3 } else { 300.0 })
        };
        let pieces: Vec<Piece> = (0..2500).map(piece).collect();
        let index: Vec<usize> = (0..pieces.len()).collect();
        let segment = Segment::new(&pieces, &index, &machine, &[0.0; 3]).unwrap().unwrap();
        let limits = Limits::uniform(3, 1000.0, 500.0, 0.02);
        let speed = SpeedLimit::new(&segment, machine.kinematics.axes(), &limits, &PlanSettings::default());
        let n = speed.cap.len();
        assert_eq!(n, nodes * pieces.len());

        let mut whole = speed.cap.clone();
        (whole[0], whole[n - 1]) = (0.0, 0.0);
        for k in 1..n {
            whole[k] = whole[k].min(speed.reach(k, k - 1, whole[k - 1]));
        }
        let tops = speed.accelerated();
        assert_eq!(tops, whole);
        for k in (1..n).rev() {
            whole[k - 1] = whole[k - 1].min(speed.reach(k, k, whole[k]));
        }
        assert_eq!(speed.decelerated(&tops), whole);
        // Both kinds of ramps cross ends of parts.
        let ends = || (SHARE..n).step_by(SHARE);
        assert!(ends().any(|k| tops[k - 1] < tops[k] && tops[k] < speed.cap[k]));
        assert!(ends().any(|k| whole[k] < whole[k - 1] && whole[k - 1] < tops[k - 1]));
    }
}
