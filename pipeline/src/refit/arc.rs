//! Arcs of a written path. Where one would leave a kink at its ends, two of them, a biarc, lead from one point and direction to another: controls
//! slow down at kinks between arcs (LinuxCNC at one of 2 mrad, where 40 mm/s are wanted).

use gcode::Plane;
use motion::Vec6;

/// Circle of an arc.
#[derive(Debug, Clone, Copy)]
pub struct ElementArc {
    /// Plane of the arc.
    pub plane: Plane,
    /// Centre in the plane's first and second axis, mm.
    pub centre: [f64; 2],
    radius: f64,
    /// Angle of the start about the centre, rad.
    start_angle: f64,
    /// Swept angle, rad, positive counter-clockwise.
    pub sweep: f64,
    /// Coordinates along the normal at both ends, mm.
    normal: [f64; 2],
}

/// A point of a path in a plane, and the direction in which the path leads there, of length 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct Passage {
    pub(super) point: Vec6,
    pub(super) direction: [f64; 2],
}

/// Largest swept angle of the arcs between two points, rad: the centre of a longer one would follow from ends that are close to each other.
const MOST_SWEEP: f64 = 2.6;
/// Least chord of an arc, mm: twenty increments of a control with three decimals. Ends that are rounded to one point would be a full circle.
const LEAST_CHORD_MM: f64 = 0.02;
/// Least height of an arc above its chord, mm. A flatter one is written as a line: its centre would be far away.
const LEAST_HEIGHT_MM: f64 = 1e-5;
/// Angle between an arc and the direction of the path up to which it counts as none, rad. At 50 mm/s two of them change the speed of an axis
/// by 0.05 mm/s; LinuxCNC begins to slow down at a tenth of its acceleration in one servo period, 0.09 mm/s at 900 mm/s².
const SMALL_KINK: f64 = 5e-4;
/// Distance of two centres up to which two arcs are written as one, mm.
const ONE_CENTRE_MM: f64 = 1e-5;

/// The arcs of a biarc: end and arc of the first, where there are two, and the last arc. `None` in place of an arc is a line.
pub(super) type Biarc = (Option<(Vec6, Option<ElementArc>)>, Option<ElementArc>);

/// Two arcs in `plane` that meet without a kink, each with the same length of tangent, from `start` to `end` with their directions; one arc,
/// where both are of one circle; `None` where they would turn by more than [`MOST_SWEEP`].
pub(super) fn biarc(plane: Plane, start: &Passage, end: &Passage) -> Option<Biarc> {
    let [first, second, normal] = plane.axes();
    let chord = [end.point[first] - start.point[first], end.point[second] - start.point[second]];
    let (from, to) = (start.direction, end.direction);
    let along = dot(chord, [from[0] + to[0], from[1] + to[1]]);
    let (chord_squared, turn) = (dot(chord, chord), 2.0 * (1.0 - dot(from, to)));
    // The root of turn·d² + 2·along·d − chord² = 0, in the form that allows a turn of zero.
    let length = chord_squared / (along + along.mul_add(along, turn * chord_squared).sqrt());
    if !(along > 0.0 && length.is_finite() && norm(chord) >= 2.0 * LEAST_CHORD_MM) {
        return None;
    }
    let joint = [0, 1].map(|k| 0.5 * (chord[k] + length * (from[k] - to[k])));
    let rest = [chord[0] - joint[0], chord[1] - joint[1]];
    let share = norm(joint) / (norm(joint) + norm(rest));
    let mut middle = start.point.lerp(&end.point, share);
    (middle[first], middle[second]) = (start.point[first] + joint[0], start.point[second] + joint[1]);
    // The last arc is that which leads back from its end.
    let before = Circle::leaving(joint, from);
    let after = Circle::leaving(rest.map(|by| -by), to.map(|by| -by));
    if before.sweep.abs() + after.sweep.abs() > MOST_SWEEP {
        return None;
    }
    let place = |origin: &Vec6, centre: [f64; 2]| [origin[first] + centre[0], origin[second] + centre[1]];
    let about = |centre: [f64; 2], from: &Vec6, to: &Vec6, sweep: f64| {
        ElementArc::about(plane, centre, from, sweep, [from[normal], to[normal]])
    };
    let (before_centre, after_centre) = (place(&start.point, before.centre), place(&end.point, after.centre));
    let apart = norm([0, 1].map(|k| before_centre[k] - after_centre[k]));
    if apart <= ONE_CENTRE_MM && before.sweep * after.sweep < 0.0 {
        let arc = about(before_centre, &start.point, &end.point, before.sweep - after.sweep);
        return Some((None, (arc.height_mm() > LEAST_HEIGHT_MM).then_some(arc)));
    }
    let high = |arc: &ElementArc| arc.height_mm() > LEAST_HEIGHT_MM;
    let first_arc = Some(about(before_centre, &start.point, &middle, before.sweep)).filter(high);
    let last_arc = Some(about(after_centre, &middle, &end.point, -after.sweep)).filter(high);
    let is_line = first_arc.is_none() && last_arc.is_none();
    Some(((!is_line).then_some((middle, first_arc)), last_arc))
}

/// The arc in `plane` from `start` through `between` to `end`; `None` where a line is as good, or where it would turn by more than
/// [`MOST_SWEEP`].
pub(super) fn arc_through(plane: Plane, start: &Vec6, between: &Vec6, end: &Vec6) -> Option<ElementArc> {
    let [first, second, normal] = plane.axes();
    let from_start = |point: &Vec6| [point[first] - start[first], point[second] - start[second]];
    let (to, over) = (from_start(end), from_start(between));
    let rest = [to[0] - over[0], to[1] - over[1]];
    // Both chords turn by half of the sweep.
    let sweep = 2.0 * cross(over, rest).atan2(dot(over, rest));
    let chord = norm(to);
    // Half the chord from the centre, under half the sweep.
    let height = 0.5 * chord / (0.5 * sweep).tan();
    let centre = [0.5 * to[0] - to[1] / chord * height, 0.5 * to[1] + to[0] / chord * height];
    let place = [start[first] + centre[0], start[second] + centre[1]];
    let arc = ElementArc::about(plane, place, start, sweep, [start[normal], end[normal]]);
    (chord >= LEAST_CHORD_MM && sweep.abs() <= MOST_SWEEP && arc.height_mm() > LEAST_HEIGHT_MM).then_some(arc)
}

/// The circle that leaves the origin in a direction and leads to a point.
#[derive(Debug, Clone, Copy)]
struct Circle {
    centre: [f64; 2],
    /// Swept angle on the way to the point, rad.
    sweep: f64,
}

impl Circle {
    fn leaving(to: [f64; 2], direction: [f64; 2]) -> Self {
        let across = cross(direction, to);
        // Straight on, the radius is infinite and the sweep zero.
        let radius = 0.5 * dot(to, to) / across;
        // The angle between direction and chord is half of the swept one.
        Self { centre: [-direction[1] * radius, direction[0] * radius], sweep: 2.0 * across.atan2(dot(direction, to)) }
    }
}

impl ElementArc {
    fn about(plane: Plane, centre: [f64; 2], start: &Vec6, sweep: f64, normal: [f64; 2]) -> Self {
        let [first, second, _] = plane.axes();
        let arm = [start[first] - centre[0], start[second] - centre[1]];
        Self { plane, centre, radius: norm(arm), start_angle: arm[1].atan2(arm[0]), sweep, normal }
    }

    /// Whether the arc leaves and arrives in these directions, up to kinks at which no control slows down.
    pub(super) fn follows(&self, start: [f64; 2], end: [f64; 2]) -> bool {
        let near = |angle: f64, wanted: [f64; 2]| {
            let (sin, cos) = angle.sin_cos();
            let direction = if self.sweep > 0.0 { [-sin, cos] } else { [sin, -cos] };
            dot(direction, wanted) > 0.0 && cross(direction, wanted).abs() <= SMALL_KINK
        };
        near(self.start_angle, start) && near(self.start_angle + self.sweep, end)
    }

    /// Distance of a point of the curve from the arc, mm. The control moves along the normal in proportion to the angle.
    pub(super) fn off(&self, point: Vec6) -> f64 {
        let [first, second, normal] = self.plane.axes();
        let arm = [point[first] - self.centre[0], point[second] - self.centre[1]];
        let angle = arm[1].atan2(arm[0]) - self.start_angle;
        let turned = if self.sweep > 0.0 { angle } else { -angle }.rem_euclid(std::f64::consts::TAU);
        // A point just before the start has turned by almost a full circle.
        let turned = if turned > std::f64::consts::PI + 0.5 * self.sweep.abs() { 0.0 } else { turned };
        let share = (turned / self.sweep.abs()).min(1.0);
        let height = self.normal[0] + (self.normal[1] - self.normal[0]) * share;
        (norm(arm) - self.radius).hypot(point[normal] - height)
    }

    /// Height above the chord, mm; zero where the radius is infinite.
    fn height_mm(&self) -> f64 {
        let height = 2.0 * self.radius * (0.25 * self.sweep).sin().powi(2);
        if height.is_finite() { height } else { 0.0 }
    }

    /// Length, mm.
    pub(super) fn length_mm(&self) -> f64 {
        (self.radius * self.sweep).hypot(self.normal[1] - self.normal[0])
    }

    /// G code. In mirrored coordinates an arc runs the other way round.
    pub(super) fn code(&self, is_mirrored: bool) -> &'static str {
        if (self.sweep > 0.0) != is_mirrored { "G3" } else { "G2" }
    }
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

pub(super) fn norm(a: [f64; 2]) -> f64 {
    a[0].hypot(a[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn passage(x: f64, y: f64, z: f64, angle: f64) -> Passage {
        Passage { point: Vec6::new(x, y, z, 0.0, 0.0, 0.0), direction: [angle.cos(), angle.sin()] }
    }

    fn on_circle(angle: f64, height: f64, way: f64) -> Passage {
        passage(3.0 + 10.0 * angle.cos(), -2.0 + 10.0 * angle.sin(), height, angle + way * std::f64::consts::FRAC_PI_2)
    }

    /// Directions of an arc at both ends.
    fn directions(arc: &ElementArc) -> [f64; 2] {
        let quarter = std::f64::consts::FRAC_PI_2.copysign(arc.sweep);
        [arc.start_angle + quarter, arc.start_angle + arc.sweep + quarter]
    }

    fn same_angle(a: f64, b: f64) -> bool {
        ((a - b).sin().abs() < 1e-9) && (a - b).cos() > 0.0
    }

    #[test]
    fn two_points_of_a_circle_are_joined_by_one_arc_of_it() {
        for way in [1.0, -1.0] {
            let at = |share: f64| on_circle(3.0 + way * 1.2 * share, share, way);
            let (joint, arc) = biarc(Plane::Xy, &at(0.0), &at(1.0)).expect("arcs");
            assert!(joint.is_none());
            let arc = arc.expect("an arc");
            assert!((arc.centre[0] - 3.0).abs() < 1e-9 && (arc.centre[1] + 2.0).abs() < 1e-9);
            assert!((arc.sweep - way * 1.2).abs() < 1e-9);
            assert!((arc.length_mm() - 12.0_f64.hypot(1.0)).abs() < 1e-9);
            for share in [0.0, 0.2, 0.7, 1.0] {
                assert!(arc.off(at(share).point) < 1e-9, "{share}");
            }
            let aside = at(0.5).point + Vec6::new(0.0, 0.0, 0.003, 0.0, 0.0, 0.0);
            assert!((arc.off(aside) - 0.003).abs() < 1e-9);
        }
    }

    #[test]
    fn three_points_of_a_circle_give_an_arc_of_it() {
        for way in [1.0, -1.0] {
            let at = |share: f64| on_circle(3.0 + way * 2.4 * share, share, way).point;
            let arc = arc_through(Plane::Xy, &at(0.0), &at(0.3), &at(1.0)).expect("an arc");
            assert!((arc.centre[0] - 3.0).abs() < 1e-9 && (arc.centre[1] + 2.0).abs() < 1e-9);
            assert!((arc.sweep - way * 2.4).abs() < 1e-9);
        }
        let at = |angle: f64| on_circle(angle, 0.0, 1.0).point;
        assert!(arc_through(Plane::Xy, &at(0.0), &at(1.5), &at(3.0)).is_none());
        assert!(arc_through(Plane::Xy, &at(0.0), &at(5e-4), &at(1e-3)).is_none());
        assert!(arc_through(Plane::Xy, &at(0.0), &at(0.1), &at(0.0)).is_none());
        let straight = |x: f64| passage(x, 0.0, 0.0, 0.0).point;
        assert!(arc_through(Plane::Xy, &straight(0.0), &straight(1.0), &straight(2.0)).is_none());
    }

    #[test]
    fn two_arcs_meet_each_other_and_both_directions_without_a_kink() {
        // Turns to one side, and to both.
        for (from, to) in [(0.3, -0.5), (0.4, 0.4), (-0.2, 0.25), (0.0, 0.3)] {
            let (start, end) =
                (passage(1.0, 2.0, 0.0, from + 0.7), passage(1.0 + 0.7_f64.cos(), 2.0 + 0.7_f64.sin(), 0.5, to + 0.7));
            let (joint, last) = biarc(Plane::Xy, &start, &end).expect("arcs");
            let (middle, first) = joint.expect("two arcs");
            let (first, last) = (first.expect("an arc"), last.expect("an arc"));
            let ([leaves, meets], [goes_on, arrives]) = (directions(&first), directions(&last));
            assert!(same_angle(leaves, from + 0.7), "{from} {to}: {leaves}");
            assert!(same_angle(meets, goes_on), "{from} {to}: {meets} {goes_on}");
            assert!(same_angle(arrives, to + 0.7), "{from} {to}: {arrives}");
            for (arc, at) in [(first, start.point), (first, middle), (last, middle), (last, end.point)] {
                assert!(arc.off(at) < 1e-9, "{from} {to}");
            }
        }
    }

    #[test]
    fn straight_passages_and_long_ways_round_are_no_arcs() {
        let (start, end) = (passage(0.0, 0.0, 0.0, 0.0), passage(2.0, 0.0, 0.0, 0.0));
        let (joint, last) = biarc(Plane::Xy, &start, &end).expect("a line");
        assert!(last.is_none() && joint.is_none_or(|(_, first)| first.is_none()));
        let at = |angle: f64| on_circle(angle, 0.0, 1.0);
        assert!(biarc(Plane::Xy, &at(0.0), &at(3.0)).is_none());
        assert!(biarc(Plane::Xy, &at(0.0), &at(-0.5)).is_none());
        assert!(biarc(Plane::Xy, &at(0.0), &at(3e-3)).is_none());
    }
}
