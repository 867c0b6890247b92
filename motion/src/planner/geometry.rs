//! Geometry of a path segment over its arc length.

use rayon::prelude::*;

use super::piece::{AxisSlots, MM_PER_RAD, PathVector, Piece, SMOOTH_RAD, Turning};
use crate::{AxisKind, MotionError, Vec3};

/// Longest step between grid nodes, mm.
const STEP_MM: f64 = 0.25;
/// Step of the first subdivision of a curve, before refinement, mm.
const COARSE_MM: f64 = 1.0;
/// Largest direction change between grid nodes, rad.
const STEP_RAD: f64 = 0.04;
/// Pieces per parallel task when the grid is built.
const PART: usize = 2048;
/// Samples per parallel task.
const SAMPLES: usize = 4096;
/// Maximum bisections of an interval to satisfy both steps.
const DEPTH: u32 = 14;

/// A grid node on the path.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    /// Arc length from the start of the segment, mm.
    pub s: f64,
    u: f64,
    /// `du/ds`, `d²u/ds²`.
    du: [f64; 2],
    /// Index into the pieces of the segment.
    pub piece: usize,
}

/// Derivatives of the path with respect to arc length, at a node.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shape {
    /// `|r′|, |r″|` of the point X, Y, Z with respect to arc length.
    pub point: [f64; 2],
    /// `q′, q″, q‴` of the axes X, Y, Z, A, B, C, mm or rad, with respect to arc length.
    pub axes: [[f64; 6]; 3],
}

impl Shape {
    /// Angle to the direction of another shape, rad, and the largest change of an axis's share of the speed.
    pub fn turn_to(&self, other: &Self) -> (f64, f64) {
        let direction =
            |shape: &Self| PathVector::from_fn(|slot, _| shape.axes[0][slot] * if slot < 3 { 1.0 } else { MM_PER_RAD });
        let (own, other) = (direction(self), direction(other));
        (angle(&own, &other), (own - other).amax())
    }
}

/// Nodes that are tested one by one before a binary search.
const LOOK_AHEAD: usize = 16;

/// Samples of a motion along a segment.
pub(super) struct Followed {
    /// Positions, one column per axis.
    pub columns: Vec<Vec<f64>>,
    /// Index in the whole path of the piece of every sample.
    pub pieces: Vec<usize>,
}

/// A point of the segment.
#[derive(Debug, Clone, Copy)]
struct CurvePoint {
    /// Index into the pieces of the segment.
    piece: usize,
    /// Parameter of the curve.
    u: f64,
}

/// A segment between two stops, on an arc length grid. A degree of a rotary axis counts as a
/// millimetre.
pub(super) struct Segment<'a> {
    pub pieces: &'a [Piece],
    index: &'a [usize],
    pub nodes: Vec<Node>,
    /// One per node, in the parts in which they were built: they are many, large and read once.
    pub shapes: Vec<Vec<Shape>>,
    /// Whether axis positions are non-linear in the path coordinates.
    is_nonlinear: bool,
}

impl<'a> Segment<'a> {
    /// Builds the grid. At every joint of pieces there are two nodes, so that jumps of curvature
    /// are kept. `None` if the pieces have no length. `near` are the axis positions before the
    /// segment.
    pub fn new(pieces: &'a [Piece], index: &'a [usize], machine: &AxisSlots, near: &[f64]) -> Result<Option<Self>, MotionError> {
        // The parts, and with them the sums, do not depend on the number of threads.
        let parts = pieces.par_chunks(PART).enumerate().map(|(part, pieces)| build_nodes(pieces, part * PART, machine));
        let parts: Vec<(Vec<Node>, Vec<Shape>)> = parts.collect();
        let mut nodes: Vec<Node> = Vec::with_capacity(parts.iter().map(|(nodes, _)| nodes.len()).sum());
        let mut shapes = Vec::with_capacity(parts.len());
        for (part, shapes_of_part) in parts {
            let from = nodes.last().map_or(0.0, |node| node.s);
            nodes.extend(part.into_iter().map(|node| Node { s: from + node.s, ..node }));
            shapes.push(shapes_of_part);
        }
        if nodes.last().is_none_or(|node| node.s <= 0.0) {
            return Ok(None);
        }
        let mut segment =
            Self { pieces, index, nodes, shapes, is_nonlinear: pieces.iter().any(|piece| is_nonlinear(piece, machine)) };
        segment.differentiate_axes(machine, near)?;
        Ok(Some(segment))
    }

    /// Length of the segment, mm.
    pub fn length_mm(&self) -> f64 {
        self.nodes.last().map_or(0.0, |node| node.s)
    }

    /// Index in the whole path and end position (mm) of every piece, in order. The last entry of an
    /// index counts.
    pub fn piece_ends(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.nodes.iter().map(|node| (self.index[node.piece], node.s))
    }

    /// Index in the whole path of a piece of the segment.
    pub fn index_of(&self, piece: usize) -> usize {
        self.index[piece]
    }

    /// Programmed feed at a node, mm/s.
    pub fn feed_mm_s(&self, node: &Node) -> f64 {
        self.pieces[node.piece].feed_mm_s
    }

    /// Fraction of the acceleration that may be used at a node.
    pub fn acceleration(&self, node: &Node) -> f64 {
        self.pieces[node.piece].acceleration
    }

    /// Whether an arc lies at a node.
    pub fn is_arc(&self, node: &Node) -> bool {
        self.pieces[node.piece].degree().is_none()
    }

    /// The piece at the arc length `s`, clamped to the segment.
    pub fn piece_at(&self, s: f64) -> usize {
        self.nodes[self.node_after(s, 1)].piece
    }

    /// Arc lengths of the corners that are passed without a blend, mm.
    pub fn sharp_corners(&self) -> Vec<f64> {
        let mut shapes = self.shapes.iter().flatten();
        let mut before: Option<(&Node, &Shape)> = None;
        let mut corners = Vec::new();
        for (node, shape) in self.nodes.iter().zip(&mut shapes) {
            if before.is_some_and(|(last, of_last)| last.s >= node.s && of_last.turn_to(shape).0 > SMOOTH_RAD) {
                corners.push(node.s);
            }
            before = Some((node, shape));
        }
        corners
    }

    /// The first node from `from` on with arc length at least `s`, at least 1 and at most the last.
    fn node_after(&self, s: f64, from: usize) -> usize {
        // Successive samples are close: test the next nodes first, then search the remaining ones.
        let near = self.nodes.len().min(from + LOOK_AHEAD);
        let after = match self.nodes[from..near].iter().position(|node| node.s >= s) {
            Some(ahead) => from + ahead,
            None => near + self.nodes[near..].partition_point(|node| node.s < s),
        };
        after.clamp(1, self.nodes.len() - 1)
    }

    /// The point at the arc length `s`, where `after` is the node after it.
    fn point_at(&self, s: f64, after: usize) -> CurvePoint {
        let (a, b) = (&self.nodes[after - 1], &self.nodes[after]);
        let u = if a.piece == b.piece { hermite(a, b, s.clamp(a.s, b.s)) } else { b.u };
        CurvePoint { piece: b.piece, u }
    }

    /// Axis positions and piece of every sample of `motion`, which must not decrease, starting from
    /// `near`.
    pub fn follow(&self, motion: &[f64], machine: &AxisSlots, near: &[f64]) -> Result<Followed, MotionError> {
        // Of several solutions the one nearest to the previous sample is taken. If there is only
        // one, parts run in parallel.
        let part = if self.is_nonlinear { motion.len() } else { SAMPLES };
        let parts = motion.par_chunks(part).map(|motion| self.follow_part(motion, machine, near));
        let column_buffer = || Vec::with_capacity(motion.len());
        let mut whole =
            Followed { columns: near.iter().map(|_| column_buffer()).collect(), pieces: Vec::with_capacity(motion.len()) };
        for part in parts.collect::<Vec<_>>() {
            let part = part?;
            whole.columns.iter_mut().zip(part.columns).for_each(|(column, positions)| column.extend(positions));
            whole.pieces.extend(part.pieces);
        }
        Ok(whole)
    }

    fn follow_part(&self, motion: &[f64], machine: &AxisSlots, near: &[f64]) -> Result<Followed, MotionError> {
        let mut joints = near.to_vec();
        let mut columns = vec![Vec::with_capacity(motion.len()); near.len()];
        let mut pieces = Vec::with_capacity(motion.len());
        let mut after = 1;
        for &s in motion {
            after = self.node_after(s, after);
            let point = self.point_at(s, after);
            self.pieces[point.piece]
                .joints(point.u, machine, &mut joints)
                .map_err(|error| error.on_piece(self.index[point.piece], s))?;
            for (column, position) in columns.iter_mut().zip(&joints) {
                column.push(*position);
            }
            pieces.push(self.index[point.piece]);
        }
        Ok(Followed { columns, pieces })
    }

    /// Derivatives of axes that are non-linear in the path coordinates: differences over the curve
    /// parameter.
    fn differentiate_axes(&mut self, machine: &AxisSlots, near: &[f64]) -> Result<(), MotionError> {
        let mut near = near.to_vec();
        let mut before: Option<(f64, Vec<f64>)> = None;
        for (node, shape) in self.nodes.iter().zip(self.shapes.iter_mut().flatten()) {
            let piece = &self.pieces[node.piece];
            if !is_nonlinear(piece, machine) {
                before = None;
                continue;
            }
            let index = self.index[node.piece];
            // A few micrometres of arc length: far above rounding, far below any feature.
            let (first, last) = piece.curve.domain();
            let h = 5e-3 * (0.5 * (last - first)).min(node.du[0]);
            let at = |u: f64, near: &[f64]| {
                let mut joints = near.to_vec();
                piece.joints(u, machine, &mut joints).map_err(|error| error.on_piece(index, node.s))?;
                Ok::<_, MotionError>(joints)
            };
            // One-sided at the ends of the curve, where the parameter is clamped.
            let middle = node.u.clamp(first + h, last - h);
            near = at(node.u, &near)?;
            let [a, b, c] = [middle - h, middle, middle + h].map(|u| at(u, &near));
            let (a, b, c) = (a?, b?, c?);
            for (axis, joint) in machine.kinematics.axes().iter().enumerate() {
                let Some(slot) = joint.slot() else { continue };
                let first = (c[axis] - a[axis]) / (2.0 * h);
                let second = (c[axis] - 2.0 * b[axis] + a[axis]) / (h * h);
                shape.axes[0][slot] = first * node.du[0];
                shape.axes[1][slot] = second * node.du[0] * node.du[0] + first * node.du[1];
                shape.axes[2][slot] = 0.0;
                let jump = before.as_ref().map_or(0.0, |(_, before)| (near[axis] - before[axis]).abs());
                if joint.kind == AxisKind::Rotary && (jump > POLE_RAD || shape.axes[0][slot].abs() > POLE_RAD_MM) {
                    return Err(MotionError::Infeasible {
                        piece: index,
                        position_mm: node.s,
                        what: format!(
                            "near a pole of the machine, where the tool stands along the axis it turns about, axis {} would have to turn by {:.0}° \
                             at once; tilt the workpiece or the tool so that the path passes further away",
                            joint.name,
                            jump.max(shape.axes[0][slot].abs() * STEP_MM).to_degrees()
                        ),
                    });
                }
            }
            before = Some((node.s, near.clone()));
        }
        Ok(())
    }
}

/// The nodes of some pieces, numbered from `first`, over the arc length from the start of the part.
fn build_nodes(pieces: &[Piece], first: usize, machine: &AxisSlots) -> (Vec<Node>, Vec<Shape>) {
    let (mut nodes, mut shapes) = (Vec::with_capacity(3 * pieces.len()), Vec::with_capacity(3 * pieces.len()));
    let mut parameters = Vec::new();
    let mut s = 0.0;
    for (number, piece) in pieces.iter().enumerate() {
        let length = length_between(piece, piece.range.0, piece.range.1);
        let coarse = first_cuts(piece, length, machine);
        let at = |i: usize| piece.range.0 + (piece.range.1 - piece.range.0) * i as f64 / coarse as f64;
        parameters.clear();
        parameters.push(piece.range.0);
        for i in 0..coarse {
            refine(piece, (at(i), at(i + 1)), DEPTH, &mut parameters);
        }
        let mut push = |u: f64, s: f64| {
            let (du, shape) = shape(piece, u);
            nodes.push(Node { s, u, du, piece: first + number });
            shapes.push(shape);
        };
        push(parameters[0], s);
        let whole = parameters.len() == 2;
        for ends in parameters.windows(2) {
            s += if whole { length } else { length_between(piece, ends[0], ends[1]) };
            push(ends[1], s);
        }
    }
    (nodes, shapes)
}

/// Rotation of a rotary axis between two nodes, rad, and per mm of arc length, rad/mm, that only
/// occurs near a pole.
const POLE_RAD: f64 = 1.2;
const POLE_RAD_MM: f64 = 12.0;

/// Whether axis positions are non-linear in the path coordinates: a tip in the workpiece frame on a
/// machine with rotary axes.
fn is_nonlinear(piece: &Piece, machine: &AxisSlots) -> bool {
    machine.kinematics.has_rotary_axes() && !matches!(piece.turning, Turning::Axes(_))
}

/// Number of intervals of a piece of this length before refinement.
fn first_cuts(piece: &Piece, length_mm: f64, machine: &AxisSlots) -> usize {
    let least = match piece.degree() {
        _ if is_nonlinear(piece, machine) => 2.0,
        Some(1) => return 1,
        // Its direction is parallel to a given ray at most twice: ends and middle detect a change.
        Some(2 | 3) => 1.0,
        _ => 2.0,
    };
    (length_mm / COARSE_MM).clamp(least, 512.0) as usize
}

/// `u(s)` between two nodes by the quintic with the values and two derivatives of both. The point
/// stays on the curve.
fn hermite(a: &Node, b: &Node, s: f64) -> f64 {
    let h = b.s - a.s;
    if h <= 0.0 {
        return b.u;
    }
    let t = (s - a.s) / h;
    let w = 1.0 - t;
    let basis = |t: f64, w: f64| {
        let w3 = w * w * w;
        [w3 * (1.0 + 3.0 * t + 6.0 * t * t), w3 * t * (1.0 + 3.0 * t), 0.5 * w3 * t * t]
    };
    let (p, q) = (basis(t, w), basis(w, t));
    let u = a.u * p[0] + a.du[0] * h * p[1] + a.du[1] * h * h * p[2] + b.u * q[0] - b.du[0] * h * q[1] + b.du[1] * h * h * q[2];
    u.clamp(a.u, b.u)
}

/// `du/ds` and `d²u/ds²` at a parameter, and the derivatives of the path there.
fn shape(of: &Piece, u: f64) -> ([f64; 2], Shape) {
    let [_, c1, c2, c3] = of.derivatives(u);
    let speed = c1.norm().max(1e-12);
    let slope = c1.dot(&c2) / speed;
    let bend = (c2.dot(&c2) + c1.dot(&c3) - slope * slope) / speed;
    let u1 = 1.0 / speed;
    let u2 = -slope * u1.powi(3);
    let u3 = (3.0 * slope * slope * u1 - bend) * u1.powi(4);
    let path_derivatives = [c1 * u1, c2 * (u1 * u1) + c1 * u2, c3 * (u1 * u1 * u1) + c2 * (3.0 * u1 * u2) + c1 * u3];
    let axes = path_derivatives.map(|d| std::array::from_fn(|slot| if slot < 3 { d[slot] } else { d[slot] / MM_PER_RAD }));
    let point = [path_derivatives[0], path_derivatives[1]].map(|d| Vec3::new(d[0], d[1], d[2]).norm());
    ([u1, u2], Shape { point, axes })
}

/// Angle between two path directions, rad. Exact for small angles.
pub(super) fn angle(a: &PathVector, b: &PathVector) -> f64 {
    let (a, b) = (a / a.norm().max(1e-300), b / b.norm().max(1e-300));
    2.0 * (a - b).norm().atan2((a + b).norm())
}

/// Appends the end parameters of sub-intervals with a small length and direction change.
fn refine(piece: &Piece, (from, to): (f64, f64), depth: u32, out: &mut Vec<f64>) {
    let middle = 0.5 * (from + to);
    let [a, m, b] = [from, middle, to].map(|u| piece.velocity(u));
    let long = (to - from) * m.norm() > STEP_MM;
    if depth > 0 && (long || angle(&a, &m) + angle(&m, &b) > STEP_RAD) {
        refine(piece, (from, middle), depth - 1, out);
        refine(piece, (middle, to), depth - 1, out);
    } else {
        out.push(to);
    }
}

/// Nodes and weights of the five-point Gauss-Legendre rule on `[0, 1]`.
const GAUSS: [(f64, f64); 5] = [
    (0.046_910_077_030_668_0, 0.118_463_442_528_094_54),
    (0.230_765_344_947_158_45, 0.239_314_335_249_683_23),
    (0.5, 0.284_444_444_444_444_44),
    (0.769_234_655_052_841_5, 0.239_314_335_249_683_23),
    (0.953_089_922_969_332, 0.118_463_442_528_094_54),
];

/// Arc length between two parameters, mm. Negative if `to` lies before `from`.
pub(super) fn length_between(piece: &Piece, from: f64, to: f64) -> f64 {
    let speed = |share: f64| piece.velocity(from + (to - from) * share).norm();
    let mean = match piece.degree() {
        Some(1) => speed(0.5),
        _ => GAUSS.iter().map(|(node, weight)| weight * speed(*node)).sum(),
    };
    mean * (to - from)
}

/// The parameter `length_mm` after (or, if negative, before) `u`, for lengths that are short
/// against the features of the curve.
pub(super) fn parameter_after(piece: &Piece, u: f64, length_mm: f64) -> f64 {
    let mut end = u + length_mm / piece.velocity(u).norm();
    if piece.degree() == Some(1) {
        return end;
    }
    for _ in 0..8 {
        let miss = length_mm - length_between(piece, u, end);
        end += miss / piece.velocity(end).norm();
    }
    end
}
