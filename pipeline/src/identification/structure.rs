//! Structures of a control: how it shapes acceleration and how it passes corners.

use std::fmt;

use machine::{ControlSpec, CornerRule, MachineSpec};
use motion::AxisLimits;

/// How a change of acceleration is shaped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shape {
    /// It is not.
    Trapezoid,
    /// A moving average of the motion along the path: limited jerk.
    Jerk,
    /// Two of them: jerk without jumps.
    Smooth,
    /// A moving average of every axis.
    Filter,
    /// Two of them.
    Filters,
    /// One along the path, one of every axis.
    JerkAndFilter,
}

pub(super) const SHAPES: [Shape; 6] =
    [Shape::Jerk, Shape::Trapezoid, Shape::Smooth, Shape::Filter, Shape::Filters, Shape::JerkAndFilter];

/// How corners are passed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Corners {
    Blend,
    SpeedJump,
    JunctionDeviation,
    Stop,
}

pub(super) const CORNERS: [Corners; 4] = [Corners::Blend, Corners::SpeedJump, Corners::JunctionDeviation, Corners::Stop];

/// The structure of a control.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Structure {
    pub shape: Shape,
    pub corners: Corners,
}

/// First values where the machine before had another structure: a moving average, ms; a blend, mm; a jump, mm/s; a junction deviation, mm.
const FIRST_AVERAGE_MS: f64 = 15.0;
const FIRST_BLEND_MM: f64 = 0.01;
const FIRST_JUMP_MM_S: f64 = 5.0;
const FIRST_DEVIATION_MM: f64 = 0.01;
/// A jerk that stands for none, mm/s³: any acceleration within one period.
pub(super) const NO_JERK: f64 = 1e10;

impl Shape {
    pub fn has_jerk(self) -> bool {
        matches!(self, Self::Jerk | Self::Smooth | Self::JerkAndFilter)
    }

    pub fn is_smooth(self) -> bool {
        self == Self::Smooth
    }

    pub fn filters(self) -> usize {
        match self {
            Self::Trapezoid | Self::Jerk | Self::Smooth => 0,
            Self::Filter | Self::JerkAndFilter => 1,
            Self::Filters => 2,
        }
    }
}

impl Structure {
    /// `machine` with this structure, with its own values as far as it has them.
    pub fn applied(self, machine: &MachineSpec) -> MachineSpec {
        let mut out = machine.clone();
        let before = machine.control.unwrap_or_default();
        let rise_s = 2.0 * machine.path.acceleration_mm_s2 / machine.path.jerk_mm_s3;
        let has_rise = rise_s > 1e-3;
        out.path.jerk_mm_s3 = match self.shape.has_jerk() {
            true if has_rise => machine.path.jerk_mm_s3,
            true => 2.0 * machine.path.acceleration_mm_s2 / (FIRST_AVERAGE_MS * 1e-3),
            false => NO_JERK,
        };
        // Without a limit of the jerk along the path there is none of the axes.
        let jerk = |own: f64| match self.shape.has_jerk() {
            true if own < NO_JERK => own,
            true => out.path.jerk_mm_s3,
            false => NO_JERK,
        };
        out.axes.iter_mut().for_each(|axis| {
            let limits = axis.limits();
            axis.set_limits(AxisLimits { jerk: jerk(limits.jerk), ..limits });
        });
        out.path.smoothing_ms = match self.shape.is_smooth() {
            true if machine.path.smoothing_ms > 0.0 => machine.path.smoothing_ms,
            true => FIRST_AVERAGE_MS,
            false => 0.0,
        };
        let mut filters_ms = [0.0; 2];
        for (filter_ms, before_ms) in filters_ms.iter_mut().zip(before.filters_ms).take(self.shape.filters()) {
            *filter_ms = if before_ms > 0.0 { before_ms } else { FIRST_AVERAGE_MS };
        }
        let corners = match (self.corners, before.corners) {
            (Corners::Blend, CornerRule::BlendMm(mm)) if mm > 0.0 && machine.control.is_some() => CornerRule::BlendMm(mm),
            (Corners::Blend, _) => CornerRule::BlendMm(FIRST_BLEND_MM),
            (Corners::SpeedJump, CornerRule::SpeedJumpMmS(mm_s)) => CornerRule::SpeedJumpMmS(mm_s),
            (Corners::SpeedJump, _) => CornerRule::SpeedJumpMmS(FIRST_JUMP_MM_S),
            (Corners::JunctionDeviation, CornerRule::JunctionDeviationMm(mm)) => CornerRule::JunctionDeviationMm(mm),
            (Corners::JunctionDeviation, _) => CornerRule::JunctionDeviationMm(FIRST_DEVIATION_MM),
            (Corners::Stop, _) => CornerRule::BlendMm(0.0),
        };
        out.control = Some(ControlSpec { corners, filters_ms });
        out
    }
}

impl fmt::Display for Structure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shape = match self.shape {
            Shape::Trapezoid => "acceleration in steps",
            Shape::Jerk => "limited jerk along the path",
            Shape::Smooth => "jerk without jumps along the path",
            Shape::Filter => "a moving average of every axis",
            Shape::Filters => "two moving averages of every axis",
            Shape::JerkAndFilter => "limited jerk along the path, then a moving average of every axis",
        };
        let corners = match self.corners {
            Corners::Blend => "corners rounded within a tolerance",
            Corners::SpeedJump => "corners passed with a limited jump of an axis's speed",
            Corners::JunctionDeviation => "corners passed by junction deviation",
            Corners::Stop => "a stop at every corner",
        };
        write!(f, "{shape}; {corners}")
    }
}
