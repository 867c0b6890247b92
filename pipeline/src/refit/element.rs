//! Elements of a written path: lines and arcs between points, and their distance from the corrected curve.

use gcode::Plane;
use motion::Vec6;

/// End of a line or arc to be written.
#[derive(Debug, Clone, Copy)]
pub(super) struct Target {
    pub(super) element: Element,
    /// Time at which the plan passes the end, s.
    pub(super) time_s: f64,
    /// Time of a line of a slow zone, s; `None` at the program's own feed.
    pub(super) slow_s: Option<f64>,
}

/// A line or arc, from the end of the element before it.
#[derive(Debug, Clone, Copy)]
pub struct Element {
    /// End in program coordinates, mm and rad.
    pub point: Vec6,
    /// The arc that leads there; `None` for a line.
    pub arc: Option<ElementArc>,
}

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

/// Largest swept angle of one arc, rad: the centre of a longer one would follow from ends that are close to each other.
const MOST_SWEEP: f64 = 2.6;
/// Least height of an arc above its chord, mm. A flatter one is written as a line: its centre would be far away.
const LEAST_HEIGHT_MM: f64 = 5e-5;
/// Lever at which a rotary axis counts, mm.
const LEVER_MM: f64 = 100.0;

impl ElementArc {
    /// Arc from `start` through `between` to `end` in `plane`; `None` where a line is as good, or where it would be longer than
    /// [`MOST_SWEEP`] or run in the other direction.
    pub(super) fn through(plane: Plane, counter_clockwise: bool, start: Vec6, between: Vec6, end: Vec6) -> Option<Self> {
        let [first, second, normal] = plane.axes();
        let from_start = |point: Vec6| [point[first] - start[first], point[second] - start[second]];
        let (b, c) = (from_start(between), from_start(end));
        let cross = b[0] * c[1] - b[1] * c[0];
        let chord = c[0].hypot(c[1]);
        if cross.abs() <= LEAST_HEIGHT_MM * chord || chord <= 0.0 {
            return None;
        }
        let (bb, cc) = (b[0] * b[0] + b[1] * b[1], c[0] * c[0] + c[1] * c[1]);
        let centre = [(c[1] * bb - b[1] * cc) / (2.0 * cross), (b[0] * cc - c[0] * bb) / (2.0 * cross)];
        let start_angle = (-centre[1]).atan2(-centre[0]);
        let turned = ((c[1] - centre[1]).atan2(c[0] - centre[0]) - start_angle).rem_euclid(std::f64::consts::TAU);
        let sweep = if counter_clockwise { turned } else { turned - std::f64::consts::TAU };
        // The points turn left where the cross product is positive: `between` lies right of the chord.
        let same_direction = counter_clockwise == (cross > 0.0);
        (same_direction && sweep.abs() <= MOST_SWEEP).then_some(Self {
            plane,
            centre: [centre[0] + start[first], centre[1] + start[second]],
            radius: centre[0].hypot(centre[1]),
            start_angle,
            sweep,
            normal: [start[normal], end[normal]],
        })
    }

    /// Distance of a point of the curve from the arc, mm. The control moves along the normal in proportion to the angle.
    fn off(&self, point: Vec6) -> f64 {
        let [first, second, normal] = self.plane.axes();
        let arm = [point[first] - self.centre[0], point[second] - self.centre[1]];
        let angle = arm[1].atan2(arm[0]) - self.start_angle;
        let turned = if self.sweep > 0.0 { angle } else { -angle }.rem_euclid(std::f64::consts::TAU);
        // A point just before the start has turned by almost a full circle.
        let turned = if turned > std::f64::consts::PI + 0.5 * self.sweep.abs() { 0.0 } else { turned };
        let share = (turned / self.sweep.abs()).min(1.0);
        let height = self.normal[0] + (self.normal[1] - self.normal[0]) * share;
        (arm[0].hypot(arm[1]) - self.radius).hypot(point[normal] - height)
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

impl Element {
    /// Length from `start`, mm.
    pub(super) fn length(&self, start: Vec6) -> f64 {
        self.arc.map_or_else(|| at_lever(self.point - start).norm(), |arc| arc.length_mm())
    }

    /// Distance of a point of the curve from the element that begins at `start`, mm.
    pub(super) fn off(&self, start: Vec6, point: Vec6) -> f64 {
        self.arc.map_or_else(|| off_line(point, start, self.point), |arc| arc.off(point))
    }
}

/// A displacement in mm, with rotary axes at their lever.
fn at_lever(displacement: Vec6) -> Vec6 {
    displacement.component_mul(&Vec6::new(1.0, 1.0, 1.0, LEVER_MM, LEVER_MM, LEVER_MM))
}

/// Distance of a point from the line between two others, mm.
fn off_line(point: Vec6, start: Vec6, end: Vec6) -> f64 {
    let (chord, off) = (at_lever(end - start), at_lever(point - start));
    let length_squared = chord.norm_squared();
    if length_squared < 1e-24 { off.norm() } else { (off - chord * (off.dot(&chord) / length_squared)).norm() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn on_circle(angle: f64, height: f64) -> Vec6 {
        Vec6::new(3.0 + 10.0 * angle.cos(), -2.0 + 10.0 * angle.sin(), height, 0.0, 0.0, 0.0)
    }

    #[test]
    fn three_points_give_the_circle_in_the_direction_of_the_move() {
        for (sign, ccw) in [(1.0, true), (-1.0, false)] {
            let at = |share: f64| on_circle(3.0 + sign * 1.2 * share, share);
            let arc = ElementArc::through(Plane::Xy, ccw, at(0.0), at(0.4), at(1.0)).expect("a circle");
            assert!((arc.centre[0] - 3.0).abs() < 1e-9 && (arc.centre[1] + 2.0).abs() < 1e-9);
            assert!((arc.sweep - sign * 1.2).abs() < 1e-9);
            assert!((arc.length_mm() - 12.0_f64.hypot(1.0)).abs() < 1e-9);
            let element = Element { point: at(1.0), arc: Some(arc) };
            for share in [0.0, 0.2, 0.7, 1.0] {
                assert!(element.off(at(0.0), at(share)) < 1e-9, "{share}");
            }
            let aside = at(0.5) + Vec6::new(0.0, 0.0, 0.003, 0.0, 0.0, 0.0);
            assert!((element.off(at(0.0), aside) - 0.003).abs() < 1e-9);
        }
    }

    #[test]
    fn lines_other_directions_and_long_arcs_are_no_arcs() {
        let at = |angle: f64| on_circle(angle, 0.0);
        assert!(ElementArc::through(Plane::Xy, false, at(0.0), at(0.5), at(1.0)).is_none());
        assert!(ElementArc::through(Plane::Xy, true, at(0.0), at(1.5), at(3.0)).is_none());
        assert!(ElementArc::through(Plane::Xy, true, at(0.0), at(5e-4), at(1e-3)).is_none());
        assert!(ElementArc::through(Plane::Xy, true, at(0.0), at(0.1), at(0.0)).is_none());
        let straight = |x: f64| Vec6::new(x, 0.0, 0.0, 0.0, 0.0, 0.0);
        assert!(ElementArc::through(Plane::Xy, true, straight(0.0), straight(1.0), straight(2.0)).is_none());
    }
}
