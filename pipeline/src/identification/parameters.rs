//! The numbers of a control, as entries of a machine description.

use machine::{ControlSpec, CornerRule, MachineSpec};
use motion::{AxisKind, AxisLimits};

use super::structure::{Corners, NO_JERK, Structure};

/// A number of a control.
#[derive(Debug, Clone)]
pub(super) struct Parameter {
    /// Its key in the machine file.
    pub key: String,
    entry: Entry,
    /// Least and greatest value.
    pub range: [f64; 2],
}

#[derive(Debug, Clone, Copy)]
enum Entry {
    /// Acceleration of an axis.
    Axis(usize),
    PathAcceleration,
    PathVelocity,
    Centripetal,
    /// Jerk of every axis, the same for all.
    AxisJerk,
    /// The time in which the acceleration changes, instead of the jerk: it does not change with the acceleration.
    Rise,
    Smoothing,
    Filter(usize),
    Corner,
    ShortLines,
}

/// The parameters of a structure. The least averages are a period: a shorter one is none.
pub(super) fn parameters(structure: Structure, machine: &MachineSpec) -> Vec<Parameter> {
    let period_ms = machine.sampling_period_ms;
    let parameter = |key: &str, entry, range| Parameter { key: key.to_owned(), entry, range };
    let linear = machine.axes.iter().enumerate().filter(|(_, axis)| axis.axis().kind == AxisKind::Linear);
    let mut out: Vec<Parameter> =
        linear.map(|(k, axis)| parameter(&format!("{}.acceleration_mm_s2", axis.name()), Entry::Axis(k), [1.0, 1e6])).collect();
    out.push(parameter("path.acceleration_mm_s2", Entry::PathAcceleration, [1.0, 1e6]));
    out.push(parameter("path.velocity_mm_s", Entry::PathVelocity, [0.1, 1e4]));
    out.push(parameter("path.centripetal_mm_s2", Entry::Centripetal, [1.0, 1e6]));
    let average = [period_ms, 300.0];
    if structure.shape.has_jerk() {
        out.push(parameter("path.rise_ms", Entry::Rise, average));
        out.push(parameter("jerk_mm_s3", Entry::AxisJerk, [1.0, NO_JERK]));
    }
    if structure.shape.is_smooth() {
        out.push(parameter("path.smoothing_ms", Entry::Smoothing, average));
    }
    for k in 0..structure.shape.filters() {
        out.push(parameter(&format!("control.filters_ms[{k}]"), Entry::Filter(k), average));
    }
    match structure.corners {
        Corners::Blend => {
            out.push(parameter("control.corners.blend_mm", Entry::Corner, [1e-4, 1.0]));
            out.push(parameter("path.short_line_acceleration", Entry::ShortLines, [0.1, 1.0]));
        }
        Corners::SpeedJump => out.push(parameter("control.corners.speed_jump_mm_s", Entry::Corner, [0.05, 500.0])),
        Corners::JunctionDeviation => out.push(parameter("control.corners.junction_deviation_mm", Entry::Corner, [1e-5, 1.0])),
        Corners::Stop => {}
    }
    out
}

impl Parameter {
    /// Whether it is the time of an average.
    pub fn is_average(&self) -> bool {
        matches!(self.entry, Entry::Rise | Entry::Smoothing | Entry::Filter(_))
    }

    /// The value with which it has no effect, for a parameter that many controls do not have.
    pub fn neutral(&self) -> Option<f64> {
        match self.entry {
            Entry::ShortLines => Some(1.0),
            Entry::AxisJerk => Some(NO_JERK),
            _ => None,
        }
    }

    /// The value after a Gauss–Newton step: in periods for an average, else in the logarithm. Limited, for slopes hold nearby.
    pub fn moved(&self, value: f64, step: f64) -> f64 {
        if self.is_average() {
            value + self.range[0] * step.clamp(-6.0, 6.0).round()
        } else {
            value * step.clamp(-0.7, 0.7).exp()
        }
    }

    /// The value after a step by `factor`, up (`direction` 1) or down (−1). Averages are made of whole periods.
    pub fn step(&self, value: f64, factor: f64, direction: f64) -> f64 {
        let next = value * factor.powf(direction);
        if !self.is_average() {
            return next;
        }
        let periods = |value: f64| (value / self.range[0]).round();
        let (from, to) = (periods(value), periods(next));
        self.range[0] * if to == from { from + direction } else { to }
    }

    /// Its value in a machine description.
    pub fn of(&self, machine: &MachineSpec) -> f64 {
        let path = &machine.path;
        match self.entry {
            Entry::Axis(k) => machine.axes[k].limits().acceleration,
            Entry::AxisJerk => machine.axes.iter().map(|axis| axis.limits().jerk).fold(NO_JERK, f64::min),
            Entry::PathAcceleration => path.acceleration_mm_s2,
            Entry::PathVelocity => path.velocity_mm_s,
            Entry::Centripetal => path.centripetal_mm_s2,
            Entry::Rise => 2e3 * path.acceleration_mm_s2 / path.jerk_mm_s3,
            Entry::Smoothing => path.smoothing_ms,
            Entry::Filter(k) => machine.control.unwrap_or_default().filters_ms[k],
            Entry::Corner => match machine.control.unwrap_or_default().corners {
                CornerRule::BlendMm(value) | CornerRule::SpeedJumpMmS(value) | CornerRule::JunctionDeviationMm(value) => value,
            },
            Entry::ShortLines => path.short_line_acceleration,
        }
    }

    /// Enters `value`, limited to the range.
    pub fn set(&self, machine: &mut MachineSpec, value: f64) {
        let value = value.clamp(self.range[0], self.range[1]);
        let path = &mut machine.path;
        let rise_s = 2.0 * path.acceleration_mm_s2 / path.jerk_mm_s3;
        let mut control = machine.control.unwrap_or_default();
        match self.entry {
            Entry::Axis(k) => {
                let limits = machine.axes[k].limits();
                machine.axes[k].set_limits(AxisLimits { acceleration: value, ..limits });
            }
            Entry::AxisJerk => machine.axes.iter_mut().for_each(|axis| {
                let limits = axis.limits();
                axis.set_limits(AxisLimits { jerk: value, ..limits });
            }),
            Entry::PathAcceleration => {
                path.acceleration_mm_s2 = value;
                path.jerk_mm_s3 = 2.0 * value / rise_s;
            }
            Entry::PathVelocity => path.velocity_mm_s = value,
            Entry::Centripetal => path.centripetal_mm_s2 = value,
            Entry::Rise => path.jerk_mm_s3 = 2e3 * path.acceleration_mm_s2 / value,
            Entry::Smoothing => path.smoothing_ms = value,
            Entry::Filter(k) => control.filters_ms[k] = value,
            Entry::Corner => {
                control.corners = match control.corners {
                    CornerRule::BlendMm(_) => CornerRule::BlendMm(value),
                    CornerRule::SpeedJumpMmS(_) => CornerRule::SpeedJumpMmS(value),
                    CornerRule::JunctionDeviationMm(_) => CornerRule::JunctionDeviationMm(value),
                };
            }
            Entry::ShortLines => path.short_line_acceleration = value,
        }
        machine.control = Some(ControlSpec { ..control });
    }
}
