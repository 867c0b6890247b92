//! Elements of a written path: lines and arcs between points, and their distance from the corrected curve.

use motion::Vec6;

use super::arc::ElementArc;

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

/// One line or arc between two points of the curve, or two that meet at a joint.
#[derive(Debug, Clone, Copy)]
pub(super) struct Span {
    pub(super) joint: Option<Element>,
    pub(super) end: Element,
}

/// Lever at which a rotary axis counts, mm.
const LEVER_MM: f64 = 100.0;

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

impl Span {
    /// Distance of a point of the curve from the span that begins at `start`, mm.
    pub(super) fn off(&self, start: Vec6, point: Vec6) -> f64 {
        let Some(joint) = self.joint else { return self.end.off(start, point) };
        if (point - joint.point).dot(&(self.end.point - start)) < 0.0 {
            joint.off(start, point)
        } else {
            self.end.off(joint.point, point)
        }
    }

    /// Share of its length at the joint; zero without one.
    pub(super) fn share_at_joint(&self, start: Vec6) -> f64 {
        let Some(joint) = self.joint else { return 0.0 };
        let (before, after) = (joint.length(start), self.end.length(joint.point));
        before / (before + after)
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
