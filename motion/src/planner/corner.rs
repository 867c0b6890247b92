//! Corners between pieces, rounded within a tolerance.

use std::sync::Arc;

use rayon::prelude::*;

use super::geometry::{angle, length_between, parameter_after};
use super::piece::{MM_PER_RAD, Piece, RotaryPath, SMOOTH_RAD};
use super::settings::{Corners, PlanSettings};
use crate::curves::Bezier;
use crate::{Limits, Vec3};

/// A larger direction change is a reversal: the tool stops there, rad.
const REVERSAL_RAD: f64 = 2.9;
/// Shorter pieces have no usable direction, mm.
const POINT_MM: f64 = 1e-9;
/// Minimum pieces per thread.
pub(super) const SHARE: usize = 512;

/// Angle between the directions `before` and `after`, rad.
fn turn(before: &Piece, after: &Piece) -> f64 {
    angle(&before.velocity(before.range.1), &after.velocity(after.range.0))
}

/// Whether the tool can continue from `before` to `after` without a stop.
pub(super) fn can_pass(before: &Piece, after: &Piece, tolerance_mm: f64) -> bool {
    let turn = turn(before, after);
    let alike = std::mem::discriminant(&before.turning) == std::mem::discriminant(&after.turning);
    alike && (turn < SMOOTH_RAD || (tolerance_mm > 0.0 && turn < REVERSAL_RAD))
}

/// The blend of a corner, and the parameters at which it leaves the piece before and joins the
/// piece after.
struct Corner {
    leave: f64,
    meet: f64,
    blend: Piece,
    /// Whether the pieces are too short for the rounding that the tolerance allows.
    crowded: bool,
}

/// Corner rounding settings.
pub(super) struct Rounding {
    tolerance_mm: f64,
    /// Whether corners are rounded at all. Else every corner is passed at speed, unless the program asks for a stop.
    blends: bool,
    /// Fraction of the acceleration that is used along pieces whose end is not rounded as the tolerance allows.
    short_acceleration: f64,
    /// Velocity jump below which the control does not treat a joint as a corner, mm/s.
    jump_mm_s: f64,
}

/// Velocity jump that a control accepts without a blend, as a fraction of acceleration × period.
const JUMP: f64 = 0.1;

impl Rounding {
    pub fn new(settings: &PlanSettings, limits: &Limits) -> Self {
        Self {
            tolerance_mm: settings.corner_tolerance_mm,
            blends: settings.corners == Corners::Blend,
            short_acceleration: settings.short_line_acceleration,
            jump_mm_s: JUMP * limits.path_acceleration_mm_s2 * settings.period_s,
        }
    }

    /// Tolerance of the corner at the end of a piece, mm.
    pub fn tolerance_mm(&self, piece: &Piece) -> f64 {
        match piece.corner_tolerance_mm {
            Some(tolerance_mm) if self.blends || tolerance_mm == 0.0 => tolerance_mm,
            _ if self.blends => self.tolerance_mm,
            _ => f64::INFINITY,
        }
    }

    /// Fraction of the acceleration along a piece; `short` where the corner at its end is not rounded as the tolerance allows. At an exact
    /// stop none would be rounded.
    fn acceleration(&self, piece: &Piece, short: bool) -> f64 {
        let is_rounded = self.blends && self.tolerance_mm(piece) > 0.0;
        if short && is_rounded { self.short_acceleration } else { 1.0 }
    }
}

impl Corner {
    /// One half of the blend: each half counts to its own piece.
    fn half(&self, range: (f64, f64)) -> Piece {
        Piece { range, ..self.blend.clone() }
    }
}

/// The pieces between two stops with every corner replaced by a Bézier that deviates from the
/// corner by at most the tolerance and uses at most half of each neighbour. `ends`: the last of them ends the program. Returns the pieces and,
/// for each, the index in the whole path.
pub(super) fn round(pieces: &[Piece], first: usize, ends: bool, rounding: &Rounding) -> (Vec<Piece>, Vec<usize>) {
    let length = |piece: &Piece| length_between(piece, piece.range.0, piece.range.1);
    let lengths: Vec<f64> = pieces.par_iter().with_min_len(SHARE).map(length).collect();
    let kept: Vec<usize> = (0..pieces.len()).filter(|k| lengths[*k] >= POINT_MM).collect();
    let corner = |pair: &[usize]| {
        // The half of a piece available to its two corners refers to the whole piece.
        let most_mm = lengths[pair[0]].min(lengths[pair[1]]) / 2.0;
        blend(&pieces[pair[0]], &pieces[pair[1]], most_mm, rounding)
    };
    let corners: Vec<Option<Corner>> = kept.par_windows(2).with_min_len(SHARE).map(corner).collect();
    let mut rounded: Vec<Piece> = Vec::with_capacity(3 * pieces.len());
    let mut index = Vec::with_capacity(3 * pieces.len());
    for (number, &k) in kept.iter().enumerate() {
        let before = number.checked_sub(1).and_then(|corner| corners[corner].as_ref());
        let after = corners.get(number).and_then(Option::as_ref);
        let crowded = before.is_some_and(|corner| corner.crowded) || after.is_some_and(|corner| corner.crowded);
        let waits = pieces[k].dwell_s > 0.0 || (ends && k + 1 == pieces.len());
        let acceleration = pieces[k].acceleration * rounding.acceleration(&pieces[k], crowded || waits);
        let start = rounded.len();
        let (from, to) = pieces[k].range;
        let range = (before.map_or(from, |corner| corner.meet), after.map_or(to, |corner| corner.leave));
        rounded.extend(before.map(|corner| corner.half((0.5, 1.0))));
        // Between adjoining blends only a rounding error of the piece remains.
        if length_between(&pieces[k], range.0, range.1) >= POINT_MM {
            rounded.push(Piece { range, ..pieces[k].clone() });
        }
        rounded.extend(after.map(|corner| corner.half((0.0, 0.5))));
        rounded[start..].iter_mut().for_each(|piece| piece.acceleration = acceleration);
        index.resize(rounded.len(), first + k);
    }
    (rounded, index)
}

/// The blend between two pieces. `None` if they join smoothly.
fn blend(before: &Piece, after: &Piece, most_mm: f64, rounding: &Rounding) -> Option<Corner> {
    let turn = turn(before, after);
    if turn < SMOOTH_RAD || !rounding.blends {
        return None;
    }
    let tolerance_mm = rounding.tolerance_mm(before);
    // The middle of the blend of two lines is l·sin(turn/2)/2 from the corner.
    let wanted_mm = 2.0 * tolerance_mm / (turn / 2.0).sin();
    let feed_mm_s = before.feed_mm_s.min(after.feed_mm_s);
    let crowded = wanted_mm > most_mm && turn * feed_mm_s > rounding.jump_mm_s;
    let mut legs = wanted_mm.min(most_mm);
    for (piece, u) in [(before, before.range.1), (after, after.range.0)] {
        if piece.degree() == Some(1) {
            continue;
        }
        let [_, first, second, _] = piece.derivatives(u);
        let across = second - first * (first.dot(&second) / first.norm_squared());
        let curvature = across.norm() / first.norm_squared();
        // A curved leg deviates from its tangent by κ·l²/2.
        if curvature * legs * legs > tolerance_mm {
            legs = (tolerance_mm / curvature).sqrt();
        }
    }
    let leave = parameter_after(before, before.range.1, -legs);
    let meet = parameter_after(after, after.range.0, legs);
    let (start, end) = (before.coordinates(leave), after.coordinates(meet));
    // With handles of two thirds of a leg the blend of two lines is a parabola. Its curvature is
    // nearly uniform, so a dense polyline is followed like the curve that it samples.
    let handle = 2.0 / 3.0 * legs;
    let (out, back) = (before.velocity(leave).normalize() * handle, after.velocity(meet).normalize() * handle);
    let points = [start, start + out, end - back, end];
    let linear = points.map(|p| Vec3::new(p[0], p[1], p[2]));
    let rotary = points.map(|p| Vec3::new(p[3], p[4], p[5]) / MM_PER_RAD);
    let blend = Piece {
        curve: Arc::new(Bezier { points: linear }),
        turning: before.turning.along(RotaryPath::bezier(rotary)),
        range: (0.0, 1.0),
        feed_mm_s,
        corner_tolerance_mm: None,
        acceleration: 1.0,
        stop_after: false,
        dwell_s: 0.0,
    };
    Some(Corner { leave, meet, blend, crowded })
}
