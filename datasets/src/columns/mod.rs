//! What the columns of a table mean: which axis, commanded or actual, in which unit.

mod mapping;
mod names;
mod recognise;
mod unit;

pub(crate) use names::is_joint_pin;
pub(crate) use recognise::{implied_period_s, recognise_reference};
pub use unit::{Quantity, Unit};

use std::path::Path;

use motion::Axis;

use crate::{DatasetError, Table};

/// A column of a table, and what its values are multiplied by to become s, mm or rad.
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

/// Which columns of a table make a log.
#[derive(Debug, Clone, PartialEq)]
pub struct ColumnMap {
    /// Time stamps, where there are any.
    pub time: Option<Source>,
    /// The axes, in the order of their first column.
    pub axes: Vec<AxisColumns>,
    /// Names of the columns that are not used.
    pub unused: Vec<String>,
}

impl ColumnMap {
    /// The map that a table's column names speak for; names are understood only when every word in them is.
    ///
    /// # Errors
    /// When no axis has both columns, two columns claim the same place, or units contradict each other.
    pub fn recognise(path: &Path, table: &Table) -> Result<Self, DatasetError> {
        recognise::recognise(path, table)
    }

    /// The map that a text like `t=time_s,x_ref=x_cmd_mm,x_act=raw*0.001,y_ref=#4:um,y_act=#5:um` says.
    ///
    /// On the right: a column's name or `#` and its number, then `*factor` or `:unit` where the unit in the column's name, else s, mm
    /// or rad, is not meant. Without `t` a time column is looked for by its name.
    ///
    /// # Errors
    /// When the text cannot be read, or names what the table has not.
    pub fn parse(text: &str, path: &Path, table: &Table) -> Result<Self, DatasetError> {
        mapping::parse(text, path, table)
    }
}
