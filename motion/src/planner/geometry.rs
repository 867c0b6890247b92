//! A stretch of path over its arc length.

use super::Piece;
use crate::{Curve, Vec3};

/// Longest step between grid nodes, mm.
const STEP_MM: f64 = 0.25;
/// First cut of a curve, before it is refined, mm.
const COARSE_MM: f64 = 1.0;
/// Largest turn between grid nodes, rad.
const STEP_RAD: f64 = 0.04;
/// How often an interval may be halved to meet the two.
const DEPTH: u32 = 14;

/// A grid node: the path and its derivatives with respect to arc length.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    /// Arc length from the start of the stretch, mm.
    pub s: f64,
    u: f64,
    /// `du/ds`, `d²u/ds²`.
    du: [f64; 2],
    /// `r′, r″, r‴` with respect to arc length.
    pub derivatives: [Vec3; 3],
    /// Index into the stretch's pieces.
    piece: usize,
}

/// A point of the stretch.
pub(super) struct Place {
    pub point: Vec3,
    /// Index of the piece in the whole path.
    pub piece: usize,
}

/// A stretch between two rests, on a grid of arc length.
pub(super) struct Stretch<'a> {
    pieces: &'a [Piece],
    index: &'a [usize],
    pub nodes: Vec<Node>,
}

impl<'a> Stretch<'a> {
    /// Lays the grid; at every joint of pieces there are two nodes, so that jumps of curvature are kept.
    /// `None` when the pieces have no length.
    pub fn new(pieces: &'a [Piece], index: &'a [usize]) -> Option<Self> {
        let mut nodes: Vec<Node> = Vec::new();
        let mut s = 0.0;
        for (number, piece) in pieces.iter().enumerate() {
            let curve = piece.curve.as_ref();
            let mut parameters = vec![piece.range.0];
            let length = length_between(curve, piece.range.0, piece.range.1);
            let straight = curve.derivatives(piece.range.0)[2..].iter().all(|d| *d == Vec3::zeros());
            let coarse = if straight { 1 } else { (length / COARSE_MM).clamp(2.0, 512.0) as usize };
            let at = |i: usize| piece.range.0 + (piece.range.1 - piece.range.0) * i as f64 / coarse as f64;
            for i in 0..coarse {
                refine(curve, (at(i), at(i + 1)), DEPTH, &mut parameters);
            }
            let mut last = piece.range.0;
            for u in parameters {
                s += length_between(curve, last, u);
                last = u;
                nodes.push(node(curve, u, s, number));
            }
        }
        (nodes.last()?.s > 0.0).then_some(Self { pieces, index, nodes })
    }

    /// Length of the stretch, mm.
    pub fn length_mm(&self) -> f64 {
        self.nodes.last().map_or(0.0, |node| node.s)
    }

    /// Index in the whole path and end position (mm) of every piece, in order; the last entry of an index counts.
    pub fn piece_ends(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.nodes.iter().map(|node| (self.index[node.piece], node.s))
    }

    /// Programmed feed at a node, mm/s.
    pub fn feed_mm_s(&self, node: &Node) -> f64 {
        self.pieces[node.piece].feed_mm_s
    }

    /// The point at arc length `s`, clamped to the stretch.
    pub fn at(&self, s: f64) -> Place {
        let after = self.nodes.partition_point(|node| node.s < s).clamp(1, self.nodes.len() - 1);
        let (a, b) = (&self.nodes[after - 1], &self.nodes[after]);
        let u = if a.piece == b.piece { hermite(a, b, s.clamp(a.s, b.s)) } else { b.u };
        Place { point: self.pieces[b.piece].curve.point(u), piece: self.index[b.piece] }
    }
}

/// `u(s)` between two nodes by the quintic that meets values and two derivatives at both: the point stays on the curve.
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

fn node(curve: &dyn Curve, u: f64, s: f64, piece: usize) -> Node {
    let [_, c1, c2, c3] = curve.derivatives(u);
    let speed = c1.norm().max(1e-12);
    let slope = c1.dot(&c2) / speed;
    let bend = (c2.dot(&c2) + c1.dot(&c3) - slope * slope) / speed;
    let u1 = 1.0 / speed;
    let u2 = -slope * u1.powi(3);
    let u3 = (3.0 * slope * slope * u1 - bend) * u1.powi(4);
    Node {
        s,
        u,
        du: [u1, u2],
        derivatives: [c1 * u1, c2 * (u1 * u1) + c1 * u2, c3 * (u1 * u1 * u1) + c2 * (3.0 * u1 * u2) + c1 * u3],
        piece,
    }
}

/// Appends the end parameters of sub-intervals that are short and turn little.
fn refine(curve: &dyn Curve, (from, to): (f64, f64), depth: u32, out: &mut Vec<f64>) {
    let middle = 0.5 * (from + to);
    let [a, m, b] = [from, middle, to].map(|u| curve.derivatives(u)[1]);
    let long = (to - from) * m.norm() > STEP_MM;
    let angle = |p: Vec3, q: Vec3| p.cross(&q).norm().atan2(p.dot(&q));
    if depth > 0 && (long || angle(a, m) + angle(m, b) > STEP_RAD) {
        refine(curve, (from, middle), depth - 1, out);
        refine(curve, (middle, to), depth - 1, out);
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

/// Length of the curve between two parameters, mm; negative when `to` lies before `from`.
pub(super) fn length_between(curve: &dyn Curve, from: f64, to: f64) -> f64 {
    GAUSS.iter().map(|(node, weight)| weight * curve.derivatives(from + (to - from) * node)[1].norm()).sum::<f64>() * (to - from)
}

/// The parameter `length_mm` after (or, negative, before) `u`, for lengths that are short against the curve's features.
pub(super) fn parameter_after(curve: &dyn Curve, u: f64, length_mm: f64) -> f64 {
    let mut end = u + length_mm / curve.derivatives(u)[1].norm();
    for _ in 0..8 {
        let miss = length_mm - length_between(curve, u, end);
        end += miss / curve.derivatives(end)[1].norm();
    }
    end
}
