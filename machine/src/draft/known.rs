//! What is known of a machine before its file is written.

use crate::ControlSpec;

/// What is known of a machine.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Draft {
    /// Name of the machine.
    pub name: String,
    /// Where all of it comes from, for the head of the file.
    pub origin: String,
    /// Sampling period of its command and logs, ms.
    pub period_ms: Option<Known<f64>>,
    /// Name of the built-in controller profile.
    pub controller: Option<String>,
    /// Limits along the path; those of the axes where absent.
    pub path_velocity_mm_s: Option<Known<f64>>,
    /// Largest acceleration along the path, mm/s².
    pub path_acceleration_mm_s2: Option<Known<f64>>,
    /// Time in which the control changes its acceleration, ms: one step of its planner where it limits no jerk.
    pub rise_ms: Option<Known<f64>>,
    /// Time over which changes of acceleration are smoothed in addition, ms.
    pub smoothing_ms: Option<f64>,
    /// Share of the acceleration along lines too short for the blends of their corners, and before a dwell.
    pub short_line_acceleration: Option<Known<f64>>,
    /// Acceleration across the path in arcs, mm/s²; that along the path where absent.
    pub centripetal_mm_s2: Option<Known<f64>>,
    /// Acceleration in arcs, along and across together, mm/s².
    pub arc_acceleration_mm_s2: Option<Known<f64>>,
    /// Rule of corners.
    pub control: Option<Known<ControlSpec>>,
    /// Lines that the control knows after the present one.
    pub look_ahead_lines: Option<Known<u32>>,
    /// The axes, in the order x y z a b c.
    pub axes: Vec<AxisDraft>,
    /// What the file cannot say, for the reader.
    pub notes: Vec<String>,
}

/// A value with where it was found.
#[derive(Debug, Clone, PartialEq)]
pub struct Known<T> {
    /// The value.
    pub value: T,
    /// Key and line, or option.
    pub source: String,
}

/// What is known of an axis. Units: mm for a linear axis, degrees for a rotary one.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AxisDraft {
    /// Lower-case name.
    pub name: String,
    /// Whether it turns.
    pub is_rotary: bool,
    /// Largest speed, mm/s or °/s.
    pub velocity: Option<Known<f64>>,
    /// Largest acceleration, mm/s² or °/s².
    pub acceleration: Option<Known<f64>>,
    /// Largest jerk, mm/s³ or °/s³.
    pub jerk: Option<Known<f64>>,
    /// Lowest and highest position, mm or °.
    pub travel: Option<Known<[f64; 2]>>,
}

/// A value that a machine file needs and a draft lacks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Missing {
    /// What it is.
    pub what: String,
    /// Name of the axis; `None` for the machine.
    pub axis: Option<String>,
    /// Which value.
    pub value: MissingValue,
}

/// The values without which there is no machine file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MissingValue {
    /// The axes themselves.
    Axes,
    /// Sampling period.
    Period,
    /// Largest speed of an axis.
    Velocity,
    /// Largest acceleration of an axis.
    Acceleration,
}

impl<T> Known<T> {
    /// A value and where it was found.
    pub fn new(value: T, source: impl Into<String>) -> Self {
        Self { value, source: source.into() }
    }
}

impl Draft {
    /// What a machine file needs and this draft lacks, all at once.
    #[must_use]
    pub fn missing(&self) -> Vec<Missing> {
        let mut missing = Vec::new();
        let mut note = |is_missing: bool, axis: Option<&AxisDraft>, value: MissingValue, what: &str| {
            if is_missing {
                let what = axis.map_or_else(|| what.to_owned(), |axis| format!("{what} of {}", axis.name));
                missing.push(Missing { what, axis: axis.map(|axis| axis.name.clone()), value });
            }
        };
        note(self.axes.is_empty(), None, MissingValue::Axes, "the axes");
        note(self.period_ms.is_none(), None, MissingValue::Period, "the sampling period of command and logs");
        for axis in &self.axes {
            note(axis.velocity.is_none(), Some(axis), MissingValue::Velocity, "the largest speed");
            note(axis.acceleration.is_none(), Some(axis), MissingValue::Acceleration, "the largest acceleration");
        }
        missing
    }

    /// The axis of a name, made where it is not there.
    pub fn axis(&mut self, name: &str) -> &mut AxisDraft {
        let at = match self.axes.iter().position(|axis| axis.name == name) {
            Some(at) => at,
            None => {
                let is_rotary = ["a", "b", "c"].contains(&name);
                let at = self.axes.partition_point(|axis| order(&axis.name) < order(name));
                self.axes.insert(at, AxisDraft { name: name.to_owned(), is_rotary, ..AxisDraft::default() });
                at
            }
        };
        &mut self.axes[at]
    }
}

/// Place of an axis in a machine file.
pub(super) fn order(name: &str) -> usize {
    ["x", "y", "z", "a", "b", "c"].iter().position(|known| *known == name).unwrap_or(6)
}
