//! Circular and helical arcs from centre words or a radius.

use std::f64::consts::{PI, TAU};

use crate::plane::Plane;
use crate::rotation::Rotation;

/// End points closer than this, in mm, coincide: the arc is a full circle.
const SAME_POINT_MM: f64 = 1e-9;

/// Points closer than this, in mm, determine no direction: a hundredth of the smallest increment of a control (10⁻⁴ mm).
const NO_DIRECTION_MM: f64 = 1e-6;
/// A chord that leaves a tangent, or three points that leave a line, by a smaller angle, rad, are straight: they
/// deviate by 1 µm over 1 m.
const STRAIGHT: f64 = 1e-6;

/// An arc in its plane. It is a helix if start and end differ along the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arc {
    /// The plane.
    pub plane: Plane,
    /// Centre in the plane's first and second axis, mm.
    pub centre_mm: [f64; 2],
    /// Radius at the start, mm.
    pub radius_start_mm: f64,
    /// Radius at the end, mm. It differs from the start radius by the rounding of the program.
    pub radius_end_mm: f64,
    /// Angle of the start about the centre, rad, from the plane's first axis to its second.
    pub start_angle: f64,
    /// Swept angle, rad, positive counter-clockwise (G3), beyond ±2π for several turns.
    pub sweep: f64,
}

/// Tolerance on the difference between the radii at start and end. An arc is refused above
/// `coarse_mm`, and above `fine_mm` if the difference also exceeds `relative` times the radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArcTolerance {
    /// Upper limit, mm: a larger difference is always refused.
    pub coarse_mm: f64,
    /// A difference up to this, mm, is always accepted.
    pub fine_mm: f64,
    /// Between the two limits, accepted up to this fraction of the radius.
    pub relative: f64,
}

impl ArcTolerance {
    fn accepts(&self, radius_start: f64, radius_end: f64) -> bool {
        let difference = (radius_start - radius_end).abs();
        difference <= self.coarse_mm && (difference <= self.fine_mm || difference <= self.relative * radius_start.max(radius_end))
    }
}

/// Why an arc cannot be built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ArcFault {
    RadiiDiffer { start_mm: f64, end_mm: f64 },
    ZeroRadius,
    RadiusTooSmall { radius_mm: f64, half_chord_mm: f64 },
    RadiusWithoutChord,
}

/// The ends of an arc, and how it runs from one to the other. Plane coordinates, mm.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ArcEnds {
    pub plane: Plane,
    pub start: [f64; 2],
    pub end: [f64; 2],
    pub counter_clockwise: bool,
    /// Full circles and the rest that follows them, counted: 1 up to a full circle.
    pub turns: u32,
    pub tolerance: ArcTolerance,
}

impl ArcEnds {
    /// The arc about `centre`; equal ends make a full circle.
    pub fn about(&self, centre: [f64; 2]) -> Result<Arc, ArcFault> {
        let Self { plane, start, end, counter_clockwise, turns, tolerance } = *self;
        let from = [start[0] - centre[0], start[1] - centre[1]];
        let to = [end[0] - centre[0], end[1] - centre[1]];
        let (radius_start_mm, radius_end_mm) = (from[0].hypot(from[1]), to[0].hypot(to[1]));
        if !tolerance.accepts(radius_start_mm, radius_end_mm) {
            return Err(ArcFault::RadiiDiffer { start_mm: radius_start_mm, end_mm: radius_end_mm });
        }
        if radius_start_mm.min(radius_end_mm) <= SAME_POINT_MM {
            return Err(ArcFault::ZeroRadius);
        }
        let start_angle = from[1].atan2(from[0]);
        let turned = if self.are_closed() { 0.0 } else { (to[1].atan2(to[0]) - start_angle).rem_euclid(TAU) };
        let whole = TAU * f64::from(turns.saturating_sub(1));
        let sweep = match (counter_clockwise, turned == 0.0) {
            (true, true) => TAU + whole,
            (true, false) => turned + whole,
            (false, _) => turned - TAU - whole,
        };
        Ok(Arc { plane, centre_mm: centre, radius_start_mm, radius_end_mm, start_angle, sweep })
    }

    /// Whether both ends are one point of the plane.
    pub fn are_closed(&self) -> bool {
        (self.end[0] - self.start[0]).hypot(self.end[1] - self.start[1]) <= SAME_POINT_MM
    }

    /// The arc of radius `|radius|`. A negative radius selects the arc above 180°.
    pub fn with_radius(&self, radius: f64) -> Result<Arc, ArcFault> {
        let Self { start, end, counter_clockwise, tolerance, .. } = *self;
        let chord = [end[0] - start[0], end[1] - start[1]];
        let half_chord_mm = 0.5 * chord[0].hypot(chord[1]);
        if half_chord_mm <= SAME_POINT_MM {
            return Err(ArcFault::RadiusWithoutChord);
        }
        if half_chord_mm - radius.abs() > tolerance.fine_mm {
            return Err(ArcFault::RadiusTooSmall { radius_mm: radius.abs(), half_chord_mm });
        }
        // The centre lies left of the chord for the short counter-clockwise arc, right for the short clockwise one.
        let height = (radius * radius - half_chord_mm * half_chord_mm).max(0.0).sqrt();
        let side = if counter_clockwise == (radius > 0.0) { 1.0 } else { -1.0 };
        let scale = side * height / (2.0 * half_chord_mm);
        let centre = [start[0] + 0.5 * chord[0] - scale * chord[1], start[1] + 0.5 * chord[1] + scale * chord[0]];
        self.about(centre)
    }
}

impl Arc {
    /// The point at `fraction` (0 to 1) of the sweep, in the plane's two axes, mm; the radius runs linearly between the ends.
    pub fn plane_point(&self, fraction: f64) -> [f64; 2] {
        let radius = self.radius_start_mm + (self.radius_end_mm - self.radius_start_mm) * fraction;
        let (sin, cos) = (self.start_angle + self.sweep * fraction).sin_cos();
        [self.centre_mm[0] + radius * cos, self.centre_mm[1] + radius * sin]
    }

    /// The arc in the work frame, from turned coordinates. `None` where it lies in another plane than they are turned in.
    pub(crate) fn in_work(&self, rotation: &Rotation) -> Option<Self> {
        let centre_mm = rotation.point_in_work(self.centre_mm);
        let (angle, sweep) = match rotation.is_mirrored() {
            true => (PI - self.start_angle, -self.sweep),
            false => (self.start_angle, self.sweep),
        };
        let start_angle = angle + rotation.angle_rad();
        let [radius_start_mm, radius_end_mm] =
            [self.radius_start_mm, self.radius_end_mm].map(|radius| radius * rotation.factor());
        let plane = self.plane;
        (plane == rotation.plane()).then_some(Self { plane, centre_mm, radius_start_mm, radius_end_mm, start_angle, sweep })
    }

    /// Unit vector of motion at the end, in the plane's two axes.
    pub(crate) fn end_direction(&self) -> [f64; 2] {
        let (sin, cos) = (self.start_angle + self.sweep).sin_cos();
        let turn = self.sweep.signum();
        [-sin * turn, cos * turn]
    }

    /// Length of the helix that rises by `rise_mm` along the normal, mm: `√((r̄·θ)² + Δr² + h²)`.
    /// Exact for equal radii.
    pub fn length_mm(&self, rise_mm: f64) -> f64 {
        let mean = 0.5 * (self.radius_start_mm + self.radius_end_mm);
        let radial = self.radius_end_mm - self.radius_start_mm;
        (mean * self.sweep).hypot(radial).hypot(rise_mm)
    }
}

/// What continues a contour tangentially.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Tangential {
    Line,
    /// `turn` is true for counter-clockwise.
    Circle {
        centre: [f64; 2],
        turn: bool,
    },
}

/// The circle or line that leaves `start` along a unit vector and ends in `stop`. `None` if there is none, or no motion.
pub(crate) fn tangential(along: [f64; 2], start: [f64; 2], stop: [f64; 2]) -> Option<Tangential> {
    let chord = from_to(start, stop);
    let length = chord[0].hypot(chord[1]);
    let across = cross(along, chord);
    if length <= NO_DIRECTION_MM {
        return None;
    }
    if across.abs() <= STRAIGHT * length {
        let ahead = along[0] * chord[0] + along[1] * chord[1] > 0.0;
        return ahead.then_some(Tangential::Line);
    }
    // The centre lies on the normal (−t₂, t₁) of the start, at the signed radius |c|²/(2 n·c).
    let radius = length * length / (2.0 * across);
    let centre = [start[0] - radius * along[1], start[1] + radius * along[0]];
    Some(Tangential::Circle { centre, turn: across > 0.0 })
}

/// Centre of the circle from `start` through `middle` to `stop`, and whether it runs counter-clockwise. `None` for points on a line, and where two
/// of them coincide.
pub(crate) fn circle_through(start: [f64; 2], middle: [f64; 2], stop: [f64; 2]) -> Option<([f64; 2], bool)> {
    let (a, b, c) = (from_to(start, middle), from_to(start, stop), from_to(middle, stop));
    let across = cross(a, b);
    let apart = [a, b, c].iter().all(|side| side[0].hypot(side[1]) > NO_DIRECTION_MM);
    let (aa, bb) = (a[0] * a[0] + a[1] * a[1], b[0] * b[0] + b[1] * b[1]);
    if !apart || across.abs() <= STRAIGHT * (aa * bb).sqrt() {
        return None;
    }
    // Circumcentre of a triangle with one corner in the origin.
    let scale = 0.5 / across;
    let centre = [start[0] + scale * (b[1] * aa - a[1] * bb), start[1] + scale * (a[0] * bb - b[0] * aa)];
    Some((centre, across > 0.0))
}

/// Unit vector from one point to another; `None` where they coincide.
pub(crate) fn direction(from: [f64; 2], to: [f64; 2]) -> Option<[f64; 2]> {
    let along = from_to(from, to);
    let length = along[0].hypot(along[1]);
    (length > NO_DIRECTION_MM).then(|| along.map(|part| part / length))
}

fn from_to(from: [f64; 2], to: [f64; 2]) -> [f64; 2] {
    [to[0] - from[0], to[1] - from[1]]
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    const TOLERANCE: ArcTolerance = ArcTolerance { coarse_mm: 0.5, fine_mm: 0.005, relative: 1e-3 };

    fn ends(start: [f64; 2], end: [f64; 2], counter_clockwise: bool) -> ArcEnds {
        ArcEnds { plane: Plane::Xy, start, end, counter_clockwise, turns: 1, tolerance: TOLERANCE }
    }

    #[test]
    fn radius_and_centre_describe_the_same_arc() {
        let (start, end) = ([10.0, 0.0], [0.0, 10.0]);
        for (ccw, radius, centre, sweep) in [
            (true, 10.0, [0.0, 0.0], FRAC_PI_2),
            (false, 10.0, [10.0, 10.0], -FRAC_PI_2),
            (true, -10.0, [10.0, 10.0], 3.0 * FRAC_PI_2),
            (false, -10.0, [0.0, 0.0], -3.0 * FRAC_PI_2),
        ] {
            let by_radius = ends(start, end, ccw).with_radius(radius).expect("valid");
            let by_centre = ends(start, end, ccw).about(centre).expect("valid");
            assert!((by_radius.sweep - sweep).abs() < 1e-12 && (by_centre.sweep - sweep).abs() < 1e-12);
            for fraction in [0.0, 0.3, 1.0] {
                let (p, q) = (by_radius.plane_point(fraction), by_centre.plane_point(fraction));
                assert!((p[0] - q[0]).abs() < 1e-9 && (p[1] - q[1]).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn circles_turns_and_faults() {
        let at = [5.0, 0.0];
        let circle = ends(at, at, false).about([0.0, 0.0]).expect("valid");
        assert_eq!(circle.sweep, -TAU);
        assert!((circle.length_mm(0.0) - 10.0 * PI).abs() < 1e-9);
        let three = ArcEnds { turns: 3, ..ends(at, [0.0, 5.0], true) }.about([0.0, 0.0]).expect("valid");
        assert!((three.sweep - (2.0 * TAU + FRAC_PI_2)).abs() < 1e-12);
        assert!(matches!(ends(at, [0.0, 6.0], true).about([0.0, 0.0]), Err(ArcFault::RadiiDiffer { .. })));
        assert_eq!(ends(at, at, true).with_radius(5.0), Err(ArcFault::RadiusWithoutChord));
        assert!(matches!(ends(at, [-5.0, 0.0], true).with_radius(4.9), Err(ArcFault::RadiusTooSmall { .. })));
        let half = ends(at, [-5.0, 0.0], true).with_radius(4.999).expect("within tolerance");
        assert!((half.sweep - PI).abs() < 1e-9);
    }

    #[test]
    fn three_points_make_one_circle() {
        let (centre, turn) = circle_through([30.0, 40.0], [40.0, 45.0], [50.0, 40.0]).expect("a circle");
        assert!((centre[0] - 40.0).abs() < 1e-12 && (centre[1] - 32.5).abs() < 1e-12 && !turn);
        // The large arc in the other direction.
        let (centre, turn) = circle_through([10.0, 0.0], [-10.0, 0.0], [0.0, 10.0]).expect("a circle");
        assert!(centre[0].hypot(centre[1]) < 1e-12 && !turn);
        for points in [[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]], [[0.0, 0.0], [5.0, 5.0], [0.0, 0.0]], [[0.0; 2]; 3]] {
            assert_eq!(circle_through(points[0], points[1], points[2]), None);
        }
    }
}
