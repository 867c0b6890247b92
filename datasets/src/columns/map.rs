//! The columns of a table that form a log.

use motion::{Axis, AxisKind};

use super::unit::{Quantity, unit_name};
use crate::{Check, Finding, Severity};

/// A column of a table and its factor to s, mm or rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Source {
    /// Index of the column.
    pub column: usize,
    /// Factor to s, mm or rad.
    pub scale: f64,
}

/// The two columns of an axis.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisColumns {
    /// The axis.
    pub axis: Axis,
    /// Commanded positions.
    pub reference: Source,
    /// Reported positions.
    pub actual: Source,
    /// The side whose column holds the tracking error instead, command minus actual position.
    pub error_for: Option<Side>,
    /// Whether names or a mapping state the unit.
    pub states_unit: bool,
}

/// A side of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Commanded positions.
    Reference,
    /// Reported positions.
    Actual,
}

impl AxisColumns {
    /// The columns of command, actual position and tracking error; the last one stands for one of the others that is missing.
    pub(super) fn with_error(axis: Axis, [reference, actual, error]: [Option<Source>; 3], states_unit: bool) -> Option<Self> {
        let of = |reference, actual, error_for| Some(Self { axis, reference, actual, error_for, states_unit });
        match (reference, actual, error) {
            (Some(reference), Some(actual), _) => of(reference, actual, None),
            (Some(reference), None, Some(error)) => of(reference, error, Some(Side::Actual)),
            (None, Some(actual), Some(error)) => of(error, actual, Some(Side::Reference)),
            _ => None,
        }
    }

    /// What to say of an angle whose unit is not stated, with the travel that its command would have, rad. Most controls log degrees: a few of them
    /// could be as many radians, more than a turn is refused.
    pub(crate) fn unstated_angle(&self, travel_rad: f64) -> Option<Finding> {
        if self.states_unit || self.axis.kind != AxisKind::Rotary || travel_rad == 0.0 {
            return None;
        }
        let axis = &self.axis;
        let severity = if travel_rad > std::f64::consts::TAU { Severity::Refuse } else { Severity::Warn };
        let message = format!(
            "no unit is stated for the angles of {axis}; as radians they travel {:.1}°. State it in the column mapping: `{axis}:deg`, as most \
             controls log, or `{axis}:rad`",
            travel_rad.to_degrees()
        );
        Some(Finding::new(severity, Check::Units, message).in_column(format!("{axis}_ref")))
    }

    /// What is taken for granted where a tracking error stands for a position.
    pub(super) fn assumed(&self, names: &[String]) -> Option<String> {
        let (side, other, source) = match self.error_for? {
            Side::Reference => ("command", "actual position", self.reference),
            Side::Actual => ("actual position", "command", self.actual),
        };
        let (column, unit) = (source.column, unit_name(source.scale, Quantity::of(self.axis.kind)));
        let (axis, name) = (&self.axis, names.get(column).map_or("", String::as_str));
        Some(format!(
            "the {side} of {axis} is taken from its {other} and `{name}`, which counts as command minus actual position in {unit}; where it is the \
             other way round or in another unit, map it, as with `{axis}_err={name}*-0.001`"
        ))
    }
}

/// Columns whose time stamps are not those of the log.
#[derive(Debug, Clone, PartialEq)]
pub struct Clock {
    /// Their time stamps.
    pub time: Source,
    /// Indices of the columns.
    pub signals: Vec<usize>,
}

impl Clock {
    /// Adds a column with these time stamps.
    pub(super) fn add(clocks: &mut Vec<Self>, time: Source, column: usize) {
        match clocks.iter_mut().find(|clock| clock.time == time) {
            Some(clock) => clock.signals.push(column),
            None => clocks.push(Self { time, signals: vec![column] }),
        }
    }
}

/// The columns of a table that form a log.
#[derive(Debug, Clone, PartialEq)]
pub struct ColumnMap {
    /// Time stamps, if any; those of the first command.
    pub time: Option<Source>,
    /// Columns with other time stamps.
    pub clocks: Vec<Clock>,
    /// The axes, in the order of their first column.
    pub axes: Vec<AxisColumns>,
    /// Names of the unused columns.
    pub unused: Vec<String>,
    /// What names leave open and was assumed.
    pub assumed: Vec<String>,
}

impl ColumnMap {
    /// What is to be known of the map.
    pub(crate) fn findings(&self) -> Vec<Finding> {
        let unused = (!self.unused.is_empty()).then(|| format!("columns not used: {}", self.unused.join(", ")));
        let messages = self.assumed.iter().cloned().chain(unused);
        messages.map(|message| Finding::new(Severity::Note, Check::Mended, message)).collect()
    }
}
