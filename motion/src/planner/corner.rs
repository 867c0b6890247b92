//! Corners between pieces, rounded within a tolerance.

use std::sync::Arc;

use super::Piece;
use super::geometry::{angle, length_between, parameter_after};
use super::piece::{MM_PER_RAD, RotaryPath};
use crate::Vec3;
use crate::curves::Bezier;

/// Directions that differ by less pass as smooth, rad: at 100 mm/s a step of 2 µm/s.
const SMOOTH_RAD: f64 = 2e-5;
/// A sharper turn is a reversal: the tool stops there, rad.
const REVERSAL_RAD: f64 = 2.9;
/// Shorter pieces have no direction worth following, mm.
const POINT_MM: f64 = 1e-9;

/// Angle by which the direction turns from `before` to `after`, rad.
fn turn(before: &Piece, after: &Piece) -> f64 {
    angle(&before.derivatives(before.range.1)[1], &after.derivatives(after.range.0)[1])
}

/// Whether the tool can go on from `before` to `after` without a stop.
pub(super) fn can_pass(before: &Piece, after: &Piece, tolerance_mm: f64) -> bool {
    let turn = turn(before, after);
    let alike = std::mem::discriminant(&before.turning) == std::mem::discriminant(&after.turning);
    alike && (turn < SMOOTH_RAD || (tolerance_mm > 0.0 && turn < REVERSAL_RAD))
}

/// The pieces between two rests with every corner replaced by a Bézier that leaves the corner by at most `tolerance_mm` and takes
/// at most half of each neighbour. Returns the pieces and, for each, the index in the whole path.
pub(super) fn round(pieces: &[Piece], first: usize, tolerance_mm: f64) -> (Vec<Piece>, Vec<usize>) {
    let mut rounded: Vec<Piece> = Vec::with_capacity(2 * pieces.len());
    let mut index = Vec::with_capacity(2 * pieces.len());
    // The half of a piece that its two corners may use is measured on the whole piece.
    let mut previous_length = 0.0_f64;
    for (offset, piece) in pieces.iter().enumerate() {
        let length = length_between(piece, piece.range.0, piece.range.1);
        if length < POINT_MM {
            continue;
        }
        let mut piece = piece.clone();
        if let Some(before) = rounded.last_mut()
            && let Some(blend) = blend(before, &mut piece, previous_length.min(length) / 2.0, tolerance_mm)
        {
            // Two halves, so that each counts to its own piece.
            let owner = *index.last().unwrap_or(&(first + offset));
            for (range, owner) in [((0.0, 0.5), owner), ((0.5, 1.0), first + offset)] {
                rounded.push(Piece { range, ..blend.clone() });
                index.push(owner);
            }
        }
        previous_length = length;
        rounded.push(piece);
        index.push(first + offset);
    }
    (rounded, index)
}

/// Trims both pieces at their common corner and returns the piece between; `None` where they join smoothly.
fn blend(before: &mut Piece, after: &mut Piece, most_mm: f64, tolerance_mm: f64) -> Option<Piece> {
    let turn = turn(before, after);
    if turn < SMOOTH_RAD {
        return None;
    }
    // The middle of the blend of two lines is l·sin(turn/2)/2 from the corner.
    let mut legs = (2.0 * tolerance_mm / (turn / 2.0).sin()).min(most_mm);
    for (piece, u) in [(&*before, before.range.1), (&*after, after.range.0)] {
        let [_, first, second, _] = piece.derivatives(u);
        let across = second - first * (first.dot(&second) / first.norm_squared());
        let curvature = across.norm() / first.norm_squared();
        // A curved leg leaves its tangent by κ·l²/2.
        if curvature * legs * legs > tolerance_mm {
            legs = (tolerance_mm / curvature).sqrt();
        }
    }
    before.range.1 = parameter_after(before, before.range.1, -legs);
    after.range.0 = parameter_after(after, after.range.0, legs);
    let [start, start_direction, ..] = before.derivatives(before.range.1);
    let [end, end_direction, ..] = after.derivatives(after.range.0);
    // With handles of two thirds of a leg the blend of two lines is a parabola: its curvature is nearly even, so that a
    // dense polyline is followed like the curve it samples.
    let handle = 2.0 / 3.0 * legs;
    let points = [start, start + start_direction.normalize() * handle, end - end_direction.normalize() * handle, end];
    let linear = points.map(|p| Vec3::new(p[0], p[1], p[2]));
    let rotary = points.map(|p| Vec3::new(p[3], p[4], p[5]) / MM_PER_RAD);
    Some(Piece {
        curve: Arc::new(Bezier { points: linear }),
        turning: before.turning.along(RotaryPath::bezier(rotary)),
        range: (0.0, 1.0),
        feed_mm_s: before.feed_mm_s.min(after.feed_mm_s),
        stop_after: false,
        dwell_s: 0.0,
    })
}
