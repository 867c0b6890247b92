//! One piece of a tool path: a curve, and how the tool is turned along it.

use std::sync::Arc;

use nalgebra::SVector;

use crate::curves::{Bezier, Line};
use crate::{Axis, AxisKind, Curve, Kinematics, MotionError, Pose, Vec3};

/// X, Y, Z in mm, and A, B, C with a degree counted as a millimetre, as controls do when they weigh one against the other.
pub(super) type Way = SVector<f64, 6>;
/// Way of one rad of a rotary axis, mm.
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
    /// From one position to another, evenly in the parameter; rad.
    #[must_use]
    pub fn linear(from: Vec3, to: Vec3) -> Self {
        Self(Shape::Line(Line { start: from, end: to }))
    }

    pub(super) fn bezier(points: [Vec3; 4]) -> Self {
        Self(Shape::Bezier(Bezier { points }))
    }

    /// The same as a curve, its lengths in rad.
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

/// What the points of a piece's curve are, and how the tool is turned meanwhile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Turning {
    /// The tool tip in the workpiece frame; the curve says how the tool stands ([`Curve::tool`]).
    Curve,
    /// The tool tip in the workpiece frame; the rotary axes go this way (tool-centre-point control). The curve's parameter is 0 to 1.
    Tip(RotaryPath),
    /// Positions of the axes X, Y, Z; the rotary axes go this way. The curve's parameter is 0 to 1.
    Axes(RotaryPath),
}

impl Turning {
    pub(super) fn rotary(&self) -> Option<&RotaryPath> {
        match self {
            Self::Curve => None,
            Self::Tip(path) | Self::Axes(path) => Some(path),
        }
    }

    /// The same kind along another way.
    pub(super) fn along(&self, path: RotaryPath) -> Self {
        match self {
            Self::Curve => Self::Curve,
            Self::Tip(_) => Self::Tip(path),
            Self::Axes(_) => Self::Axes(path),
        }
    }
}

/// A stretch of one curve, run through at one programmed feed.
#[derive(Debug, Clone)]
pub struct Piece {
    /// The curve.
    pub curve: Arc<dyn Curve>,
    /// What its points are.
    pub turning: Turning,
    /// Parameter range that is run through, forwards.
    pub range: (f64, f64),
    /// Programmed feed along the way, mm/s, where a degree of a rotary axis that [`Turning`] states counts as a millimetre; infinite for as
    /// fast as the limits allow (a rapid).
    pub feed_mm_s: f64,
    /// How far the corner at its end may be rounded off, mm; as the plan's settings say where `None`.
    pub corner_tolerance_mm: Option<f64>,
    /// Share of the acceleration along the path that may be used on it.
    pub acceleration: f64,
    /// Come to rest at the end, even where the next piece goes on smoothly.
    pub stop_after: bool,
    /// Rest at the end, s; implies a stop when positive.
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

    /// The same piece with the tool turned so.
    #[must_use]
    pub fn turning(self, turning: Turning) -> Self {
        Self { turning, ..self }
    }

    pub(super) fn stops(&self) -> bool {
        self.stop_after || self.dwell_s > 0.0
    }

    /// Position on the way and its derivatives with respect to the curve's parameter.
    pub(super) fn derivatives(&self, u: f64) -> [Way; 4] {
        let linear = self.curve.derivatives(u);
        let rotary = self.turning.rotary().map_or([Vec3::zeros(); 4], |path| path.curve().derivatives(u));
        std::array::from_fn(|order| way(linear[order], rotary[order]))
    }

    /// Place on the way.
    pub(super) fn place(&self, u: f64) -> Way {
        way(self.curve.point(u), self.turning.rotary().map_or(Vec3::zeros(), |path| path.at(u)))
    }

    /// First derivative of the way with respect to the curve's parameter.
    pub(super) fn velocity(&self, u: f64) -> Way {
        let rotary = self.turning.rotary().map_or(Vec3::zeros(), |path| path.curve().velocity(u));
        way(self.curve.velocity(u), rotary)
    }

    /// Degree of a way that is a polynomial in the curve's parameter.
    pub(super) fn degree(&self) -> Option<usize> {
        let rotary = self.turning.rotary().map_or(Some(0), |path| path.curve().degree());
        Some(self.curve.degree()?.max(rotary?))
    }

    /// Moves `joints` to the axis positions at `u`, the nearest where there are several.
    pub(super) fn joints(&self, u: f64, machine: &AxisSlots, joints: &mut [f64]) -> Result<(), MotionError> {
        let point = self.curve.point(u);
        match &self.turning {
            Turning::Curve => machine.kinematics.reach(&Pose { tip: point, tool: self.curve.tool(u) }, joints),
            Turning::Tip(path) => machine.kinematics.place_at(&point, &path.at(u).into(), joints),
            Turning::Axes(path) => machine.stand(&point, &path.at(u), joints),
        }
    }
}

/// A place or derivative of the way.
fn way(linear: Vec3, rotary: Vec3) -> Way {
    let rotary = rotary * MM_PER_RAD;
    Way::new(linear.x, linear.y, linear.z, rotary.x, rotary.y, rotary.z)
}

/// Rounding of a program's words may lead this far beyond a travel, mm or rad.
const BEYOND: f64 = 1e-6;

/// A machine with the place of each of its axes among X, Y, Z, A, B, C.
pub(super) struct AxisSlots<'a> {
    pub kinematics: &'a dyn Kinematics,
    slots: Vec<Option<usize>>,
}

impl<'a> AxisSlots<'a> {
    pub fn of(kinematics: &'a dyn Kinematics) -> Self {
        Self { kinematics, slots: kinematics.axes().iter().map(Axis::slot).collect() }
    }

    /// Moves the axes that have a place among X, Y, Z, A, B, C there.
    fn stand(&self, linear: &Vec3, rotary: &Vec3, joints: &mut [f64]) -> Result<(), MotionError> {
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

    /// Refuses a position beyond an axis's travel.
    fn check_travel(&self, index: usize, position: f64) -> Result<(), MotionError> {
        let Some([low, high]) = self.kinematics.travel(index) else { return Ok(()) };
        if (low - BEYOND..=high + BEYOND).contains(&position) {
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
