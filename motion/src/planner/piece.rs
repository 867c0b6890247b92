//! One piece of a tool path: a curve and the rotary motion along it.

use std::sync::Arc;

use nalgebra::SVector;

use crate::curves::{Bezier, Line};
use crate::{Axis, AxisKind, Curve, Kinematics, MotionError, Pose, Vec3};

/// X, Y, Z in mm, and A, B, C with a degree counted as a millimetre, as in controls that combine
/// both.
pub(super) type PathVector = SVector<f64, 6>;
/// Directions that differ by less count as smooth, rad: a velocity step of 2 µm/s at 100 mm/s.
pub(super) const SMOOTH_RAD: f64 = 2e-5;
/// Path length of one rad of a rotary axis, mm.
pub const MM_PER_RAD: f64 = 180.0 / std::f64::consts::PI;

/// Rotary axes A, B, C (rad) over a curve's parameter from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RotaryPath(Shape);

#[derive(Debug, Clone, Copy, PartialEq)]
enum Shape {
    Line(Line),
    Bezier(Bezier),
}

impl RotaryPath {
    /// Linear in the parameter, between two positions in rad.
    #[must_use]
    pub fn linear(from: Vec3, to: Vec3) -> Self {
        Self(Shape::Line(Line { start: from, end: to }))
    }

    pub(super) fn bezier(points: [Vec3; 4]) -> Self {
        Self(Shape::Bezier(Bezier { points }))
    }

    /// The same as a curve, with lengths in rad.
    fn curve(&self) -> &dyn Curve {
        match &self.0 {
            Shape::Line(line) => line,
            Shape::Bezier(bezier) => bezier,
        }
    }

    /// Positions at `u`, rad.
    #[must_use]
    pub fn at(&self, u: f64) -> Vec3 {
        self.curve().point(u)
    }
}

/// Meaning of a piece's curve, and the rotary motion along it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Turning {
    /// The tool tip in the workpiece frame. The curve states the tool direction ([`Curve::tool`]).
    Curve,
    /// The tool tip in the workpiece frame, with this rotary motion (tool-centre-point control).
    /// The curve parameter is 0 to 1.
    Tip(RotaryPath),
    /// Positions of the axes X, Y, Z, with this rotary motion. The curve parameter is 0 to 1.
    Axes(RotaryPath),
}

impl Turning {
    pub(super) fn rotary(&self) -> Option<&RotaryPath> {
        match self {
            Self::Curve => None,
            Self::Tip(path) | Self::Axes(path) => Some(path),
        }
    }

    /// The same kind with another rotary path.
    pub(super) fn along(&self, path: RotaryPath) -> Self {
        match self {
            Self::Curve => Self::Curve,
            Self::Tip(_) => Self::Tip(path),
            Self::Axes(_) => Self::Axes(path),
        }
    }
}

/// A part of one curve with one programmed feed.
#[derive(Debug, Clone)]
pub struct Piece {
    /// The curve.
    pub curve: Arc<dyn Curve>,
    /// Meaning of its points.
    pub turning: Turning,
    /// Parameter range, increasing.
    pub range: (f64, f64),
    /// Programmed feed along the path, mm/s, where a degree of a rotary axis stated by [`Turning`]
    /// counts as a millimetre. Infinite for a rapid, which the limits alone bound.
    pub feed_mm_s: f64,
    /// Rounding tolerance of the corner at its end, mm. `None`: by the settings of the plan.
    pub corner_tolerance_mm: Option<f64>,
    /// Fraction of the acceleration along the path that may be used on it.
    pub acceleration: f64,
    /// Stop at the end, even before a smooth continuation.
    pub stop_after: bool,
    /// Dwell at the end, s. Implies a stop if positive.
    pub dwell_s: f64,
}

impl Piece {
    /// The whole of a curve at one feed (mm/s).
    #[must_use]
    pub fn whole(curve: Arc<dyn Curve>, feed_mm_s: f64) -> Self {
        let range = curve.domain();
        Self {
            curve,
            turning: Turning::Curve,
            range,
            feed_mm_s,
            corner_tolerance_mm: None,
            acceleration: 1.0,
            stop_after: false,
            dwell_s: 0.0,
        }
    }

    /// The same piece with this rotary motion.
    #[must_use]
    pub fn turning(self, turning: Turning) -> Self {
        Self { turning, ..self }
    }

    /// Length over both halves as straight lines, mm: not above the length of the piece.
    pub(super) fn least_length_mm(&self) -> f64 {
        let (from, to) = self.range;
        let [start, middle, end] = [from, f64::midpoint(from, to), to].map(|u| self.coordinates(u));
        (middle - start).norm() + (end - middle).norm()
    }

    pub(super) fn stops(&self) -> bool {
        self.stop_after || self.dwell_s > 0.0
    }

    /// Path coordinates and their derivatives with respect to the curve parameter.
    pub(super) fn derivatives(&self, u: f64) -> [PathVector; 4] {
        let linear = self.curve.derivatives(u);
        let rotary = self.turning.rotary().map_or([Vec3::zeros(); 4], |path| path.curve().derivatives(u));
        std::array::from_fn(|order| path_vector(linear[order], rotary[order]))
    }

    /// Path coordinates.
    pub(super) fn coordinates(&self, u: f64) -> PathVector {
        path_vector(self.curve.point(u), self.turning.rotary().map_or(Vec3::zeros(), |path| path.at(u)))
    }

    /// First derivative of the path coordinates with respect to the curve parameter.
    pub(super) fn velocity(&self, u: f64) -> PathVector {
        let rotary = self.turning.rotary().map_or(Vec3::zeros(), |path| path.curve().velocity(u));
        path_vector(self.curve.velocity(u), rotary)
    }

    /// Degree of path coordinates that are polynomials in the curve parameter.
    pub(super) fn degree(&self) -> Option<usize> {
        let rotary = self.turning.rotary().map_or(Some(0), |path| path.curve().degree());
        Some(self.curve.degree()?.max(rotary?))
    }

    /// Moves `joints` to the axis positions at `u`, to the nearest of several solutions.
    pub(super) fn joints(&self, u: f64, machine: &AxisSlots, joints: &mut [f64]) -> Result<(), MotionError> {
        let point = self.curve.point(u);
        match &self.turning {
            Turning::Curve => machine.kinematics.reach(&Pose { tip: point, tool: self.curve.tool(u) }, joints),
            Turning::Tip(path) => machine.kinematics.place_at(&point, &path.at(u).into(), joints),
            Turning::Axes(path) => machine.set_axes(&point, &path.at(u), joints),
        }
    }
}

/// Path coordinates, or a derivative of them.
fn path_vector(linear: Vec3, rotary: Vec3) -> PathVector {
    let rotary = rotary * MM_PER_RAD;
    PathVector::new(linear.x, linear.y, linear.z, rotary.x, rotary.y, rotary.z)
}

/// Tolerance on the travel for the rounding of program words, mm or rad.
const TRAVEL_TOLERANCE: f64 = 1e-6;

/// A machine with the index of each axis among X, Y, Z, A, B, C.
pub(super) struct AxisSlots<'a> {
    pub kinematics: &'a dyn Kinematics,
    slots: Vec<Option<usize>>,
}

impl<'a> AxisSlots<'a> {
    pub fn of(kinematics: &'a dyn Kinematics) -> Self {
        Self { kinematics, slots: kinematics.axes().iter().map(Axis::slot).collect() }
    }

    /// Sets the axes that are among X, Y, Z, A, B, C to these positions.
    fn set_axes(&self, linear: &Vec3, rotary: &Vec3, joints: &mut [f64]) -> Result<(), MotionError> {
        for (index, (joint, slot)) in joints.iter_mut().zip(&self.slots).enumerate() {
            match *slot {
                Some(slot @ 0..3) => *joint = linear[slot],
                Some(slot) => *joint = rotary[slot - 3],
                None => {}
            }
            self.check_travel(index, *joint)?;
        }
        Ok(())
    }

    /// Refuses a position outside the travel of an axis.
    fn check_travel(&self, index: usize, position: f64) -> Result<(), MotionError> {
        let Some([low, high]) = self.kinematics.travel(index) else { return Ok(()) };
        if (low - TRAVEL_TOLERANCE..=high + TRAVEL_TOLERANCE).contains(&position) {
            return Ok(());
        }
        let axis = &self.kinematics.axes()[index];
        let shown = |value: f64| match axis.kind {
            AxisKind::Rotary => format!("{:.3}°", value.to_degrees()),
            AxisKind::Linear => format!("{value:.3} mm"),
        };
        let (at, low, high) = (shown(position), shown(low), shown(high));
        Err(MotionError::Unreachable(format!("axis `{axis}` would stand at {at}, outside its travel from {low} to {high}")))
    }
}
