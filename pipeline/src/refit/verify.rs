//! Verification of a compensated program, which is read back before it is written.

use std::ops::Range;

use gcode::{Move, MoveKind, PathMode, Toolpath};
use machine::ProgramWords;
use motion::Vec3;

use super::element::Element;
use super::refitted::Refitted;
use crate::error::VerifyError;
use crate::part::{Part, coordinates};

/// Rounding of written coordinates, mm, with five decimals or more.
const ROUNDING_MM: f64 = 2e-5;

/// Distance by which a line or arc between its ends may lie further off than at them, mm.
const BETWEEN_MM: f64 = 5e-3;

/// Largest rounding error of a coordinate with `decimals`, mm. It covers inch programs, which have one decimal more.
fn rounding_mm(decimals: usize) -> f64 {
    ROUNDING_MM.max(1.3 * 0.1_f64.powi(i32::try_from(decimals).unwrap_or(i32::MAX)))
}

/// Compares every move of the compensated program, or of a section of it, as it is read again, with its intended end. `moves` are the indices
/// of the original moves in its place. Moves without compensation keep their ends, compensated moves lead through their targets, and no
/// target lies further than `max_shift_mm` from the original curve.
///
/// # Errors
/// Names the line at which the output differs. Such output must not be written.
pub fn verify(
    part: &Part,
    moves: &Range<usize>,
    refitted: &Refitted,
    toolpath: &Toolpath,
    max_shift_mm: f64,
    decimals: usize,
) -> Result<(), VerifyError> {
    let rounding_mm = rounding_mm(decimals);
    let mut written = toolpath.moves.iter();
    let mut targets = refitted.targets.iter().peekable();
    let has_rotary_axes = part.plan.desired.kinematics().has_rotary_axes();
    for (index, original) in moves.clone().map(|index| (index, &part.toolpath.moves[index])) {
        let line = original.block as usize + 1;
        let Some((_, elements)) = targets.next_if(|(owner, _)| *owner == index) else {
            let Some(same) = written.next() else { return Err(VerifyError::Missing { line }) };
            // A dwell keeps the end of the move before it.
            let waits = matches!(original.kind, MoveKind::Dwell { .. });
            let alike = std::mem::discriminant(&same.kind) == std::mem::discriminant(&original.kind);
            if !alike || !(waits || ends_alike(same, original)) {
                let (is, was) = (Vec3::from(same.end.nominal_mm()), Vec3::from(original.end.nominal_mm()));
                return Err(VerifyError::Changed { line, is, was });
            }
            continue;
        };
        for element in elements {
            let Some(step) = written.next() else { return Err(VerifyError::Ends { line }) };
            let end = coordinates(&step.end);
            if !is_alike(&step.kind, element, rounding_mm) || (end - element.point).norm() > rounding_mm * 6.0_f64.sqrt() {
                return Err(VerifyError::Elsewhere { line, is: end, wanted: element.point });
            }
            // In axis words of a machine with rotary axes, tip and axes move apart. There the reference itself was
            // bounded.
            let bounded = has_rotary_axes && part.words_of(original) == ProgramWords::Axes;
            let at = |share: f64| distance(original, Vec3::from(step.point_mm(share)));
            let (end_mm, off_mm) = (at(1.0), at(1.0).max(at(0.5) - BETWEEN_MM));
            let allowed_mm = max_shift_mm + rounding_mm * 3.0_f64.sqrt() + corner_mm(part, index);
            // A distance that is no number is not within it.
            let is_within = end_mm.is_finite() && off_mm <= allowed_mm;
            if !(bounded || is_within) {
                return Err(VerifyError::TooFar { line, off_mm });
            }
        }
    }
    match written.next() {
        Some(extra) => Err(VerifyError::Extra { line: extra.block as usize + 1 }),
        None => Ok(()),
    }
}

/// Whether a move is the intended line or arc, its end apart.
fn is_alike(kind: &MoveKind, element: &Element, rounding_mm: f64) -> bool {
    match (kind, &element.arc) {
        (MoveKind::Line, None) => true,
        (MoveKind::Arc(arc), Some(wanted)) => {
            let off = [0, 1].map(|axis| arc.centre_mm[axis] - wanted.centre[axis]);
            let same_way = arc.plane == wanted.plane && (arc.sweep > 0.0) == (wanted.sweep > 0.0);
            same_way && off[0].hypot(off[1]) <= 3.0 * rounding_mm && arc.sweep.abs() < std::f64::consts::PI
        }
        _ => false,
    }
}

/// Largest rounding of the corners of a move by the control, mm, which points may include: its own tolerance, or that of a
/// neighbour; that of the plan where the program states none.
fn corner_mm(part: &Part, index: usize) -> f64 {
    let tolerance = |step: &Move| match part.toolpath.modal(step).path {
        PathMode::Continuous { tolerance_mm: Some(own_mm), .. } => own_mm,
        PathMode::Continuous { .. } | PathMode::Default => part.settings.corner_tolerance_mm,
        PathMode::ExactPath | PathMode::ExactStop => 0.0,
    };
    let moves = &part.toolpath.moves;
    moves[index.saturating_sub(1)..moves.len().min(index + 2)].iter().map(tolerance).fold(0.0, f64::max)
}

fn ends_alike(a: &Move, b: &Move) -> bool {
    (coordinates(&a.end) - coordinates(&b.end)).iter().all(|off| off.abs() <= ROUNDING_MM)
}

/// Distance of a point from the curve of a move, mm.
fn distance(of: &Move, point: Vec3) -> f64 {
    let at = |share: f64| Vec3::from(of.point_mm(share));
    // The share of a chord that is nearest to the point.
    let nearest = |from: f64, to: f64| {
        let (a, b) = (at(from), at(to));
        let chord = b - a;
        let share = ((point - a).dot(&chord) / chord.norm_squared().max(1e-18)).clamp(0.0, 1.0);
        (from + share * (to - from), (point - a - chord * share).norm())
    };
    let MoveKind::Arc(arc) = of.kind else { return nearest(0.0, 1.0).1 };
    let pieces = (arc.sweep.abs() / 0.01).ceil().clamp(8.0, 4096.0) as usize;
    let width = 1.0 / pieces as f64;
    let chords = (0..pieces).map(|i| nearest(i as f64 * width, (i + 1) as f64 * width));
    let (mut share, _) = chords.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default();
    // A chord leaves an arc of metres by hundredths of a millimetre.
    for beside in SHORTER.map(|part| part * width) {
        (share, _) = nearest((share - beside).max(0.0), (share + beside).min(1.0));
    }
    (point - at(share)).norm()
}

/// Lengths of the chords that follow each other where the nearest point of an arc is sought, as shares of the first ones.
const SHORTER: [f64; 3] = [0.5, 0.1, 0.01];

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    #[test]
    fn the_distance_from_a_long_arc_is_that_from_the_arc() {
        // A half circle of 2540 mm, whose points of 0.01 rad leave chords of 0.03 mm.
        let program = gcode::parse("G21 G90 G17\nG0 X0 Y0 Z0\nG2 X5080 Y0 I2540 J0 F1000\nM2\n");
        let toolpath = gcode::interpret(&program, &gcode::Dialect::LinuxCnc.into()).unwrap();
        let arc = toolpath.moves.iter().find(|step| step.is_feed()).unwrap();
        for k in 0..200 {
            let (sin, cos) = (0.5 * TAU * (f64::from(k) + 0.37) / 200.0).sin_cos();
            for off in [-0.05, 0.0, 0.002, 0.05] {
                let (radius, rise) = (2540.0 + off, 0.5 * off);
                let point = Vec3::new(2540.0 - radius * cos, radius * sin, rise);
                let wanted = f64::hypot(off, rise);
                assert!((distance(arc, point) - wanted).abs() < 1e-6, "{} {wanted}", distance(arc, point));
            }
        }
        // Beyond its ends, the distance from these.
        assert!((distance(arc, Vec3::new(-0.03, -0.04, 0.0)) - 0.05).abs() < 1e-9);
    }
}
