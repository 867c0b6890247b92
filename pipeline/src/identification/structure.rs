//! Structures of a control: how it shapes acceleration and how it passes corners.

use std::fmt;

use machine::{ControlSpec, CornerRule, MachineSpec};
use motion::{AxisKind, AxisLimits};

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
    /// Two along the path, one of every axis.
    SmoothAndFilter,
    /// A first-order lag of every axis.
    Lag,
    /// A moving average of the motion along the path, a first-order lag of every axis.
    JerkAndLag,
}

pub(super) const SHAPES: [Shape; 9] = [
    Shape::Jerk,
    Shape::Trapezoid,
    Shape::Smooth,
    Shape::Filter,
    Shape::Filters,
    Shape::JerkAndFilter,
    Shape::SmoothAndFilter,
    Shape::Lag,
    Shape::JerkAndLag,
];

/// How corners are passed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Corners {
    Blend,
    SpeedJump,
    JunctionDeviation,
    Stop,
}

pub(super) const CORNERS: [Corners; 4] = [Corners::Blend, Corners::SpeedJump, Corners::JunctionDeviation, Corners::Stop];

/// What a control does besides.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Besides {
    /// Every axis has filters of its own.
    pub own_filters: bool,
    /// It knows only some lines ahead.
    pub look_ahead: bool,
    /// It needs a least time for a line.
    pub line_time: bool,
    /// In arcs the accelerations along and across have a common limit.
    pub arcs: bool,
}

/// The structure of a control.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Structure {
    pub shape: Shape,
    pub corners: Corners,
    pub besides: Besides,
}

/// First value where the machine before had another structure: a moving average or time constant, ms.
const FIRST_AVERAGE_MS: f64 = 15.0;
/// First values of the corners where a machine had another rule of them.
#[derive(Debug, Clone, Copy)]
pub(super) struct FirstCorners {
    pub blend_mm: f64,
    pub jump_mm_s: f64,
    pub deviation_mm: f64,
}

/// Values in the middle of what controls are set to.
impl Default for FirstCorners {
    fn default() -> Self {
        Self { blend_mm: 0.01, jump_mm_s: 5.0, deviation_mm: 0.01 }
    }
}

/// Lines ahead and ms.
const FIRST_LOOK_AHEAD: u32 = 16;
const FIRST_LINE_TIME_MS: f64 = 4.0;
/// Share of the acceleration across the path.
const FIRST_IN_ARCS: f64 = 1.2;
/// A jerk that stands for none, mm/s³: any acceleration within one period.
pub(super) const NO_JERK: f64 = 1e10;

impl Shape {
    pub fn has_jerk(self) -> bool {
        matches!(self, Self::Jerk | Self::Smooth | Self::JerkAndFilter | Self::SmoothAndFilter | Self::JerkAndLag)
    }

    pub fn is_smooth(self) -> bool {
        matches!(self, Self::Smooth | Self::SmoothAndFilter)
    }

    pub fn has_lag(self) -> bool {
        matches!(self, Self::Lag | Self::JerkAndLag)
    }

    pub fn is_filtered(self) -> bool {
        self.filters() > 0 || self.has_lag()
    }

    /// Number of moving averages of every axis.
    pub fn filters(self) -> usize {
        match self {
            Self::Trapezoid | Self::Jerk | Self::Smooth | Self::Lag | Self::JerkAndLag => 0,
            Self::Filter | Self::JerkAndFilter | Self::SmoothAndFilter => 1,
            Self::Filters => 2,
        }
    }
}

impl Structure {
    /// Filters of each axis need filters.
    pub fn is_possible(self) -> bool {
        self.shape.is_filtered() || !self.besides.own_filters
    }

    /// The structure and the machine without averages of one period, which are none.
    pub fn simplified(self, mut machine: MachineSpec) -> (Self, MachineSpec) {
        let is_none = |average_ms: f64| average_ms < 1.5 * machine.sampling_period_ms;
        let no_rise = is_none(2e3 * machine.path.acceleration_mm_s2 / machine.path.jerk_mm_s3);
        let mut control = machine.control.unwrap_or_default();
        let [first, second] = control.filters_ms;
        let shape = match self.shape {
            _ if self.besides.own_filters => self.shape,
            Shape::Smooth if is_none(machine.path.smoothing_ms) => Shape::Jerk,
            Shape::Filters if is_none(first) || is_none(second) => Shape::Filter,
            Shape::SmoothAndFilter if is_none(machine.path.smoothing_ms) => Shape::JerkAndFilter,
            Shape::JerkAndFilter if no_rise => Shape::Filter,
            Shape::JerkAndFilter if is_none(first) => Shape::Jerk,
            Shape::JerkAndLag if no_rise => Shape::Lag,
            shape => shape,
        };
        if shape != self.shape {
            control.filters_ms = [first.max(second), first.min(second)];
            machine.control = Some(control);
        }
        let structure = Self { shape, ..self };
        let machine = structure.applied(&machine);
        (structure, machine)
    }

    /// `machine` with this structure, with its own values as far as it has them.
    pub fn applied(self, machine: &MachineSpec) -> MachineSpec {
        self.applied_from(machine, FirstCorners::default())
    }

    /// The same with first values of another rule of corners.
    pub fn applied_from(self, machine: &MachineSpec, first: FirstCorners) -> MachineSpec {
        let mut out = machine.clone();
        let before = machine.control.unwrap_or_default();
        let rise_s = 2.0 * machine.path.acceleration_mm_s2 / machine.path.jerk_mm_s3;
        let has_rise = rise_s > 5e-4 * machine.sampling_period_ms;
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
        // That of a rotary axis, of another unit, stays what the logs reach.
        out.axes.iter_mut().filter(|axis| axis.axis().kind == AxisKind::Linear).for_each(|axis| {
            let limits = axis.limits();
            axis.set_limits(AxisLimits { jerk: jerk(limits.jerk), ..limits });
        });
        out.path.smoothing_ms = match self.shape.is_smooth() {
            true if machine.path.smoothing_ms > 0.0 => machine.path.smoothing_ms,
            true => FIRST_AVERAGE_MS,
            false => 0.0,
        };
        let first_in_arcs = || FIRST_IN_ARCS * machine.path.centripetal_mm_s2;
        out.path.arc_acceleration_mm_s2 =
            self.besides.arcs.then(|| machine.path.arc_acceleration_mm_s2.unwrap_or_else(first_in_arcs));
        let mut filters_ms = [0.0; 2];
        for (filter_ms, before_ms) in filters_ms.iter_mut().zip(before.filters_ms).take(self.shape.filters()) {
            *filter_ms = if before_ms > 0.0 { before_ms } else { FIRST_AVERAGE_MS };
        }
        let time_constant_ms = match self.shape.has_lag() {
            true if before.time_constant_ms > 0.0 => before.time_constant_ms,
            true => FIRST_AVERAGE_MS,
            false => 0.0,
        };
        for axis in &mut out.axes {
            let (own_filters_ms, own_constant_ms) = axis.filters();
            let own = self.besides.own_filters;
            axis.set_filters(
                own.then(|| own_filters_ms.unwrap_or(filters_ms)).filter(|_| self.shape.filters() > 0),
                own.then(|| own_constant_ms.unwrap_or(time_constant_ms)).filter(|_| self.shape.has_lag()),
            );
        }
        let corners = match (self.corners, before.corners) {
            (Corners::Blend, CornerRule::BlendMm(mm)) if mm > 0.0 && machine.control.is_some() => CornerRule::BlendMm(mm),
            (Corners::Blend, _) => CornerRule::BlendMm(first.blend_mm),
            (Corners::SpeedJump, CornerRule::SpeedJumpMmS(mm_s)) => CornerRule::SpeedJumpMmS(mm_s),
            (Corners::SpeedJump, _) => CornerRule::SpeedJumpMmS(first.jump_mm_s),
            (Corners::JunctionDeviation, CornerRule::JunctionDeviationMm(mm)) => CornerRule::JunctionDeviationMm(mm),
            (Corners::JunctionDeviation, _) => CornerRule::JunctionDeviationMm(first.deviation_mm),
            (Corners::Stop, _) => CornerRule::BlendMm(0.0),
        };
        let line_time_ms = if before.line_time_ms > 0.0 { before.line_time_ms } else { FIRST_LINE_TIME_MS };
        out.control = Some(ControlSpec {
            corners,
            filters_ms,
            time_constant_ms,
            look_ahead_lines: self.besides.look_ahead.then(|| before.look_ahead_lines.unwrap_or(FIRST_LOOK_AHEAD)),
            line_time_ms: if self.besides.line_time { line_time_ms } else { 0.0 },
        });
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
            Shape::SmoothAndFilter => "jerk without jumps along the path, then a moving average of every axis",
            Shape::JerkAndFilter => "limited jerk along the path, then a moving average of every axis",
            Shape::Lag => "a first-order lag of every axis",
            Shape::JerkAndLag => "limited jerk along the path, then a first-order lag of every axis",
        };
        let corners = match self.corners {
            Corners::Blend => "corners rounded within a tolerance",
            Corners::SpeedJump => "corners passed with a limited jump of an axis's speed",
            Corners::JunctionDeviation => "corners passed by junction deviation",
            Corners::Stop => "a stop at every corner",
        };
        write!(f, "{shape}")?;
        let Besides { own_filters, look_ahead, line_time, arcs } = self.besides;
        if own_filters {
            f.write_str(", different for each")?;
        }
        write!(f, "; {corners}")?;
        let others = [
            (look_ahead, "a look-ahead of some lines"),
            (line_time, "a least time for a line"),
            (arcs, "less acceleration along tight arcs"),
        ];
        for (has, words) in others {
            if has {
                write!(f, "; {words}")?;
            }
        }
        Ok(())
    }
}
