//! The fastest speed over arc length that holds the limits.

use super::Excess;
use super::geometry::{Node, Stretch};
use crate::{Axis, AxisLimits, Limits};

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
    limits: &'a Limits,
    /// Limits of the axes that have a place among X, Y, Z, A, B, C, with that place.
    axes: Vec<(usize, AxisLimits)>,
    /// Cap on the squared speed at every node, mm²/s².
    cap: Vec<f64>,
    /// Factor, at most 1, on the acceleration in the interval that ends at the node.
    share: Vec<f64>,
    /// The last profile: squared speed at every node.
    squared: Vec<f64>,
}

impl<'a> SpeedLimit<'a> {
    pub fn new(stretch: &'a Stretch<'a>, axes: &[Axis], limits: &'a Limits, period_s: f64) -> Self {
        let nodes = &stretch.nodes;
        let axes: Vec<(usize, AxisLimits)> =
            axes.iter().zip(&limits.axes).filter_map(|(axis, limit)| Some((axis.slot()?, *limit))).collect();
        let mut cap: Vec<f64> = nodes
            .iter()
            .map(|node| {
                let feed = stretch.feed_mm_s(node).min(limits.path_velocity_mm_s / node.point[0].norm());
                pointwise(node, &axes, limits).min(feed * feed).max(CRAWL_MM_S * CRAWL_MM_S)
            })
            .collect();
        // A jump of curvature is a jump of acceleration, to be taken within one period.
        for k in 1..nodes.len() {
            if nodes[k].s - nodes[k - 1].s <= 0.0 {
                for (slot, limit) in &axes {
                    let jump = nodes[k].axes[1][*slot] - nodes[k - 1].axes[1][*slot];
                    let most = limit.jerk * period_s / jump.abs();
                    for node in [k - 1, k] {
                        cap[node] = cap[node].min(most.max(CRAWL_MM_S * CRAWL_MM_S));
                    }
                }
            }
        }
        Self { nodes, limits, axes, share: vec![1.0; cap.len()], squared: Vec::new(), cap }
    }

    /// The fastest profile from rest to rest.
    pub fn fastest(&mut self) -> Vec<Phase> {
        let n = self.nodes.len();
        let mut squared = self.cap.clone();
        squared[0] = 0.0;
        squared[n - 1] = 0.0;
        for k in 1..n {
            squared[k] = squared[k].min(self.reach(k, k - 1, squared[k - 1]));
        }
        for k in (1..n).rev() {
            squared[k - 1] = squared[k - 1].min(self.reach(k, k, squared[k]));
        }
        let mut phases = Vec::new();
        for k in 1..n {
            let ds = self.nodes[k].s - self.nodes[k - 1].s;
            if ds > 0.0 {
                let (e0, e1) = (squared[k - 1], squared[k]);
                let needed = (e1 - e0).abs() / (2.0 * ds);
                let acceleration = self.acceleration(k, k, e0.max(e1)).max(needed);
                let top = self.cap[k].min(self.cap[k - 1]).max(e0.max(e1));
                interval(ds, e0, e1, acceleration, top, &mut phases);
            }
        }
        self.squared = squared;
        phases
    }

    /// Squared speed that can be reached over the interval ending at `k`, from `squared` at node `at`.
    fn reach(&self, k: usize, at: usize, squared: f64) -> f64 {
        let ds = self.nodes[k].s - self.nodes[k - 1].s;
        squared + 2.0 * self.acceleration(k, at, squared) * ds
    }

    /// Acceleration along the path that the axes leave room for at node `at`, mm/s².
    fn acceleration(&self, k: usize, at: usize, squared: f64) -> f64 {
        let Node { point, axes: [tangent, normal, _], .. } = &self.nodes[at];
        // Along a turn on the spot the path has no acceleration of its own.
        let mut most = self.limits.path_acceleration_mm_s2 / point[0].norm().max(1e-3);
        for (slot, limit) in &self.axes {
            let share = tangent[*slot].abs();
            if share > 1e-9 {
                most = most.min((limit.acceleration - normal[*slot].abs() * squared).max(0.0) / share);
            }
        }
        // Room may be exhausted at the fastest places; a hundredth keeps the passes from locking there.
        most.max(0.01 * self.limits.path_acceleration_mm_s2) * self.share[k]
    }

    /// Lowers speed and acceleration where samples of `motion` exceed a limit.
    ///
    /// Smoothing mixes positions over `spread_s`, so that far around a sample counts.
    pub fn lower(&mut self, motion: &[f64], excess: &[Excess], spread_s: f64, period_s: f64) {
        let reach = (0.5 * spread_s / period_s).ceil() as usize + 3;
        let mut factor = vec![1.0_f64; self.nodes.len()];
        for Excess { sample, order, ratio, .. } in excess {
            let from = motion[sample.saturating_sub(reach)];
            let to = motion[(sample + reach).min(motion.len() - 1)];
            let first = self.nodes.partition_point(|node| node.s < from).saturating_sub(1);
            let last = self.nodes.partition_point(|node| node.s <= to).min(self.nodes.len() - 1);
            let wanted = ratio.min(4.0).powf(-2.0 / *order as f64) * 0.998;
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

/// Cap on the squared speed at one place: feed aside, everything that does not depend on acceleration along the path.
fn pointwise(node: &Node, axes: &[(usize, AxisLimits)], limits: &Limits) -> f64 {
    let [tangent, normal, third] = &node.axes;
    let mut most = limits.centripetal_mm_s2 / node.point[1].norm();
    for (slot, limit) in axes {
        most = most
            .min((limit.velocity / tangent[*slot].abs()).powi(2))
            .min(limit.acceleration / normal[*slot].abs())
            .min((limit.jerk / third[*slot].abs()).powf(2.0 / 3.0));
    }
    most
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
