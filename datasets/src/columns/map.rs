//! The columns of a table that form a log.

use motion::Axis;

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
