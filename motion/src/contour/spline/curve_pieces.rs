//! An analytic curve as cubic pieces, accurate enough to locate foot points.

use super::cubic::Cubic;
use super::pieces::Pieces;
use crate::{Curve, Vec3};

/// Largest distance between the pieces and the curve, mm.
const TOLERANCE_MM: f64 = 1e-8;
/// Number of pieces before refinement.
const FIRST_CUT: usize = 256;
/// Maximum bisections of a piece. Ends the refinement at a kink.
const MAX_BISECTIONS: u32 = 30;

/// The pieces and the parameters of their joints.
#[derive(Debug, Clone, Default)]
pub(in crate::contour) struct CurvePieces {
    pub pieces: Pieces,
    /// Curve parameter at the start of every piece, and at the end of the last.
    ends: Vec<f64>,
}

/// Parameter, point and first derivative.
type Node = (f64, Vec3, Vec3);

impl CurvePieces {
    /// Subdivides `curve` until each cubic Hermite piece is within [`TOLERANCE_MM`] of it.
    pub fn new(curve: &dyn Curve) -> Self {
        let (first, last) = curve.domain();
        let node = |u: f64| {
            let [point, slope, ..] = curve.derivatives(u);
            (u, point, slope)
        };
        let mut cut = Self::default();
        cut.ends.push(first);
        let mut start = node(first);
        for i in 1..=FIRST_CUT {
            let share = i as f64 / FIRST_CUT as f64;
            let end = node(first * (1.0 - share) + last * share);
            cut.add(&node, start, end, MAX_BISECTIONS);
            start = end;
        }
        cut
    }

    fn add(&mut self, node: &dyn Fn(f64) -> Node, start: Node, end: Node, halvings: u32) {
        let width = end.0 - start.0;
        let (leaving, arriving) = (start.2 * width, end.2 * width);
        let cubic = Cubic::hermite(start.1, leaving, end.1, arriving);
        let middle = node(start.0 + 0.5 * width);
        let close = |t: f64, point: Vec3| (cubic.point(t) - point).norm() <= TOLERANCE_MM;
        let fits =
            || close(0.5, middle.1) && close(0.25, node(start.0 + 0.25 * width).1) && close(0.75, node(start.0 + 0.75 * width).1);
        if halvings == 0 || fits() {
            self.pieces.push(start.1, leaving, end.1, arriving);
            self.ends.push(end.0);
        } else {
            self.add(node, start, middle, halvings - 1);
            self.add(node, middle, end, halvings - 1);
        }
    }

    /// Curve parameter at a position (piece and fraction).
    pub fn parameter(&self, position: f64) -> f64 {
        let (piece, t) = self.pieces.split(position);
        self.ends[piece] + t * (self.ends[piece + 1] - self.ends[piece])
    }

    /// Position of a curve parameter.
    pub fn position(&self, u: f64) -> f64 {
        let piece = self.ends.partition_point(|end| *end <= u).clamp(1, self.pieces.end()) - 1;
        let width = self.ends[piece + 1] - self.ends[piece];
        let share = if width > 0.0 { (u - self.ends[piece]) / width } else { 0.0 };
        piece as f64 + share.clamp(0.0, 1.0)
    }

    /// Parameters one piece before and one piece after a position.
    pub fn around(&self, position: f64) -> (f64, f64) {
        let (piece, _) = self.pieces.split(position);
        let after = (piece + 2).min(self.pieces.end());
        (self.ends[piece.saturating_sub(1)], self.ends[after])
    }

    /// Positions of samples on the curve in time order, each searched forward of the one before.
    pub fn positions_of(&self, samples: &[Vec3]) -> Vec<f64> {
        let mut last = 0.0;
        let mut before = samples.first().copied().unwrap_or_default();
        samples
            .iter()
            .map(|sample| {
                let (piece, t) = self.pieces.split(last);
                let reach = self.pieces.arc_at(last) + 4.0 * (sample - before).norm();
                let mut high = piece + 1;
                while high < self.pieces.end() && self.pieces.arc(high) <= reach {
                    high += 1;
                }
                let high = (high + 1).min(self.pieces.end());
                last = self.pieces.nearest(piece, high, (piece, t), sample).position().max(last);
                before = *sample;
                last
            })
            .collect()
    }
}
