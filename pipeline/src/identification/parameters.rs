//! The numbers of a control, as entries of a machine description.

use machine::{ControlSpec, CornerRule, MachineSpec, PathSpec};
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
    /// Jerk of every linear axis, the same for all. That of rotary axes stays what the logs reach.
    AxisJerk,
    /// The time in which the acceleration changes, instead of the jerk: it does not change with the acceleration.
    Rise,
    Smoothing,
    Filter(usize),
    /// Of an axis, a filter of its own.
    OwnFilter(usize, usize),
    TimeConstant,
    OwnTimeConstant(usize),
    LookAhead,
    LineTime,
    Corner,
    ShortLines,
    /// Acceleration along the tightest arcs, instead of that along and across together: it does not change with the one across.
    Arcs,
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
    // A machine file takes an average and a lag of together five thousand periods.
    let longest_ms = (2500.0 * period_ms).min(300.0);
    let average = [period_ms, longest_ms];
    if structure.shape.has_jerk() {
        out.push(parameter("path.rise_ms", Entry::Rise, average));
        out.push(parameter("jerk_mm_s3", Entry::AxisJerk, [1.0, NO_JERK]));
    }
    if structure.shape.is_smooth() {
        out.push(parameter("path.smoothing_ms", Entry::Smoothing, average));
    }
    let lag = [0.2 * period_ms, longest_ms];
    let filters = 0..structure.shape.filters();
    if structure.besides.own_filters {
        for (axis, name) in machine.axes.iter().enumerate().map(|(k, axis)| (k, axis.name())) {
            out.extend(
                filters.clone().map(|k| parameter(&format!("{name}.filters_ms[{k}]"), Entry::OwnFilter(axis, k), average)),
            );
            if structure.shape.has_lag() {
                out.push(parameter(&format!("{name}.time_constant_ms"), Entry::OwnTimeConstant(axis), lag));
            }
        }
    } else {
        out.extend(filters.map(|k| parameter(&format!("control.filters_ms[{k}]"), Entry::Filter(k), average)));
        if structure.shape.has_lag() {
            out.push(parameter("control.time_constant_ms", Entry::TimeConstant, lag));
        }
    }
    if structure.besides.arcs {
        out.push(parameter("path.tight_arcs_mm_s2", Entry::Arcs, [1.0, 1e6]));
    }
    if structure.besides.look_ahead {
        out.push(parameter("control.look_ahead_lines", Entry::LookAhead, [1.0, 2000.0]));
    }
    if structure.besides.line_time {
        out.push(parameter("control.line_time_ms", Entry::LineTime, [0.01, 1000.0]));
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

/// What the common limit of the accelerations in arcs leaves along the tightest ones, mm/s².
fn along_tight_arcs(path: &PathSpec) -> Option<f64> {
    let both = path.arc_acceleration_mm_s2?;
    Some((both.powi(2) - path.centripetal_mm_s2.powi(2)).max(0.0).sqrt())
}

impl Parameter {
    /// Whether it is the time of an average.
    fn is_average(&self) -> bool {
        matches!(self.entry, Entry::Rise | Entry::Smoothing | Entry::Filter(_) | Entry::OwnFilter(..))
    }

    /// Whether it changes by whole steps, as long as its least value: an average, or a number of lines.
    pub fn is_stepped(&self) -> bool {
        self.is_average() || matches!(self.entry, Entry::LookAhead)
    }

    /// Whether its time and that of `other` add up, in an axis or in all of them.
    pub fn adds_to(&self, other: &Self) -> bool {
        let axis = |entry: Entry| if let Entry::OwnFilter(axis, _) = entry { Some(axis) } else { None };
        let alike = axis(self.entry).zip(axis(other.entry)).is_none_or(|(own, other)| own == other);
        self.is_average() && other.is_average() && self.key != other.key && alike
    }

    /// Other values from which a search may start, where a limit lies above others that hide it: near these.
    pub fn other_starts(&self, machine: &MachineSpec) -> Vec<f64> {
        let linear = machine.axes.iter().filter(|axis| axis.axis().kind == AxisKind::Linear);
        let most = linear.map(|axis| axis.limits().acceleration).fold(0.0, f64::max);
        let starts = match self.entry {
            Entry::Axis(_) => [0.9, 0.7].map(|share| share * machine.path.acceleration_mm_s2).to_vec(),
            Entry::PathAcceleration => vec![most, 0.7 * most],
            Entry::Centripetal => [0.5, 1.0].map(|share| share * most.min(machine.path.acceleration_mm_s2)).to_vec(),
            _ => Vec::new(),
        };
        let now = self.of(machine);
        starts.into_iter().filter(|start| *start < 0.9 * now && *start > 0.0).collect()
    }

    /// The value with which it has no effect, for a parameter that many controls do not have.
    pub fn neutral(&self) -> Option<f64> {
        match self.entry {
            Entry::ShortLines => Some(1.0),
            Entry::AxisJerk => Some(NO_JERK),
            _ => None,
        }
    }

    /// The value after a Gauss–Newton step: in steps for what is stepped, else in the logarithm. Limited, for slopes hold nearby.
    pub fn moved(&self, value: f64, step: f64) -> f64 {
        if self.is_stepped() {
            value + self.range[0] * step.clamp(-6.0, 6.0).round()
        } else {
            value * step.clamp(-0.7, 0.7).exp()
        }
    }

    /// The value after a step by `factor`, up (`direction` 1) or down (−1). Averages are made of whole periods, a look-ahead of whole lines.
    pub fn step(&self, value: f64, factor: f64, direction: f64) -> f64 {
        let next = value * factor.powf(direction);
        if !self.is_stepped() {
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
            Entry::AxisJerk => {
                let linear = machine.axes.iter().filter(|axis| axis.axis().kind == AxisKind::Linear);
                linear.map(|axis| axis.limits().jerk).fold(NO_JERK, f64::min)
            }
            Entry::PathAcceleration => path.acceleration_mm_s2,
            Entry::PathVelocity => path.velocity_mm_s,
            Entry::Centripetal => path.centripetal_mm_s2,
            Entry::Rise => 2e3 * path.acceleration_mm_s2 / path.jerk_mm_s3,
            Entry::Smoothing => path.smoothing_ms,
            Entry::Filter(k) => machine.control.unwrap_or_default().filters_ms[k],
            Entry::OwnFilter(axis, k) => machine.axes[axis].filters().0.unwrap_or_default()[k],
            Entry::TimeConstant => machine.control.unwrap_or_default().time_constant_ms,
            Entry::OwnTimeConstant(axis) => machine.axes[axis].filters().1.unwrap_or_default(),
            Entry::LookAhead => machine.control.unwrap_or_default().look_ahead_lines.map_or(self.range[1], f64::from),
            Entry::LineTime => machine.control.unwrap_or_default().line_time_ms,
            Entry::Corner => match machine.control.unwrap_or_default().corners {
                CornerRule::BlendMm(value) | CornerRule::SpeedJumpMmS(value) | CornerRule::JunctionDeviationMm(value) => value,
            },
            Entry::ShortLines => path.short_line_acceleration,
            Entry::Arcs => along_tight_arcs(path).unwrap_or(self.range[1]),
        }
    }

    /// Enters `value`, limited to the range.
    pub fn set(&self, machine: &mut MachineSpec, value: f64) {
        let value = if self.is_stepped() { self.range[0] * (value / self.range[0]).round() } else { value };
        let value = value.clamp(self.range[0], self.range[1]);
        let path = &mut machine.path;
        let rise_s = 2.0 * path.acceleration_mm_s2 / path.jerk_mm_s3;
        let mut control = machine.control.unwrap_or_default();
        match self.entry {
            Entry::Axis(k) => {
                let limits = machine.axes[k].limits();
                machine.axes[k].set_limits(AxisLimits { acceleration: value, ..limits });
            }
            Entry::AxisJerk => machine.axes.iter_mut().filter(|axis| axis.axis().kind == AxisKind::Linear).for_each(|axis| {
                let limits = axis.limits();
                axis.set_limits(AxisLimits { jerk: value, ..limits });
            }),
            Entry::PathAcceleration => {
                path.acceleration_mm_s2 = value;
                path.jerk_mm_s3 = 2.0 * value / rise_s;
            }
            Entry::PathVelocity => path.velocity_mm_s = value,
            Entry::Centripetal => {
                path.arc_acceleration_mm_s2 = along_tight_arcs(path).map(|along| along.hypot(value));
                path.centripetal_mm_s2 = value;
            }
            Entry::Rise => path.jerk_mm_s3 = 2e3 * path.acceleration_mm_s2 / value,
            Entry::Smoothing => path.smoothing_ms = value,
            Entry::Filter(k) => control.filters_ms[k] = value,
            Entry::OwnFilter(axis, k) => {
                let (filters_ms, time_constant_ms) = machine.axes[axis].filters();
                let mut filters_ms = filters_ms.unwrap_or_default();
                filters_ms[k] = value;
                machine.axes[axis].set_filters(Some(filters_ms), time_constant_ms);
            }
            Entry::TimeConstant => control.time_constant_ms = value,
            Entry::OwnTimeConstant(axis) => {
                let (filters_ms, _) = machine.axes[axis].filters();
                machine.axes[axis].set_filters(filters_ms, Some(value));
            }
            Entry::LookAhead => control.look_ahead_lines = Some(value.round() as u32),
            Entry::LineTime => control.line_time_ms = value,
            Entry::Corner => {
                control.corners = match control.corners {
                    CornerRule::BlendMm(_) => CornerRule::BlendMm(value),
                    CornerRule::SpeedJumpMmS(_) => CornerRule::SpeedJumpMmS(value),
                    CornerRule::JunctionDeviationMm(_) => CornerRule::JunctionDeviationMm(value),
                };
            }
            Entry::ShortLines => path.short_line_acceleration = value,
            Entry::Arcs => path.arc_acceleration_mm_s2 = Some(value.hypot(path.centripetal_mm_s2)),
        }
        machine.control = Some(ControlSpec { ..control });
    }
}
