//! One piece of a tool path: a curve, and how the tool is turned along it.

use std::sync::Arc;

use nalgebra::SVector;

use crate::{Axis, AxisKind, Curve, Kinematics, MotionError, Pose, Vec3};

/// X, Y, Z in mm, and A, B, C with a degree counted as a millimetre, as controls do when they weigh one against the other.
pub(super) type Way = SVector<f64, 6>;
/// Way of one rad of a rotary axis, mm.
pub const MM_PER_RAD: f64 = 180.0 / std::f64::consts::PI;

/// Rotary axes A, B, C (rad) over a curve's parameter from 0 to 1: a cubic by its Bézier points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RotaryPath {
    points: [Vec3; 4],
}

impl RotaryPath {
    /// From one position to another, evenly in the parameter; rad.
    #[must_use]
    pub fn linear(from: Vec3, to: Vec3) -> Self {
        Self { points: [from, from.lerp(&to, 1.0 / 3.0), from.lerp(&to, 2.0 / 3.0), to] }
    }

    pub(super) fn bezier(points: [Vec3; 4]) -> Self {
        Self { points }
    }

    /// Positions and three derivatives at `u`, rad.
    fn derivatives(&self, u: f64) -> [Vec3; 4] {
        crate::curves::Bezier { points: self.points }.derivatives(u)
    }

    /// Positions at `u`, rad.
    #[must_use]
    pub fn at(&self, u: f64) -> Vec3 {
        self.derivatives(u)[0]
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
        Self { curve, turning: Turning::Curve, range, feed_mm_s, stop_after: false, dwell_s: 0.0 }
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
        let mut way = self.curve.derivatives(u).map(|d| Way::new(d.x, d.y, d.z, 0.0, 0.0, 0.0));
        if let Some(path) = self.turning.rotary() {
            for (way, rotary) in way.iter_mut().zip(path.derivatives(u)) {
                way.fixed_rows_mut::<3>(3).copy_from(&(rotary * MM_PER_RAD));
            }
        }
        way
    }

    /// Axis positions at `u`, nearest to `near` where there are several.
    pub(super) fn joints(&self, u: f64, kinematics: &dyn Kinematics, near: &[f64]) -> Result<Vec<f64>, MotionError> {
        let point = self.curve.point(u);
        match &self.turning {
            Turning::Curve => kinematics.inverse(&Pose { tip: point, tool: self.curve.tool(u) }, near),
            Turning::Tip(path) => kinematics.place(&point, &path.at(u).into(), near),
            Turning::Axes(path) => {
                let rotary = path.at(u);
                let at = |axis: &Axis, near: f64| axis.slot().map_or(near, |slot| [point, rotary][slot / 3][slot % 3]);
                let axes = kinematics.axes().iter().zip(near).enumerate();
                axes.map(|(index, (axis, near))| within_travel(kinematics, index, at(axis, *near))).collect()
            }
        }
    }
}

/// Rounding of a program's words may lead this far beyond a travel, mm or rad.
const BEYOND: f64 = 1e-6;

/// The position of an axis, refused beyond its travel.
fn within_travel(kinematics: &dyn Kinematics, index: usize, position: f64) -> Result<f64, MotionError> {
    let Some([low, high]) = kinematics.travel(index) else { return Ok(position) };
    if (low - BEYOND..=high + BEYOND).contains(&position) {
        return Ok(position);
    }
    let axis = &kinematics.axes()[index];
    let shown = |value: f64| match axis.kind {
        AxisKind::Rotary => format!("{:.3}°", value.to_degrees()),
        AxisKind::Linear => format!("{value:.3} mm"),
    };
    let (at, low, high) = (shown(position), shown(low), shown(high));
    Err(MotionError::Unreachable(format!("axis `{axis}` would stand at {at}, outside its travel from {low} to {high}")))
}
