//! What the columns of a file are taken for.

use std::path::Path;

use motion::Axis;

use crate::columns::{Quantity, Side, unit_name};
use crate::formats::{format_of, table_of};
use crate::read::{map_of, runs_of, stated};
use crate::{ColumnMap, DatasetError, Log, ReadOptions, Report, Table};

/// A log with what its columns are taken for.
#[derive(Debug, Clone, PartialEq)]
pub struct Inspection {
    /// Name of the file's format.
    pub format: &'static str,
    /// Number of rows of the file.
    pub rows: usize,
    /// The columns, in the order of the file.
    pub columns: Vec<Column>,
    /// The runs: one, or those between the gaps of the time stamps.
    pub runs: Vec<Log>,
    /// Findings while reading.
    pub report: Report,
}

/// A column of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Its name in the file.
    pub name: String,
    /// What it is taken for.
    pub role: Role,
    /// The unit that it is taken to be in; a factor to s, mm or rad where that is no unit's. Empty for a column that is not used.
    pub unit: String,
}

/// What a column is taken for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Role {
    /// Time stamps.
    Time,
    /// Commanded positions of an axis.
    Commanded(Axis),
    /// Reported positions of an axis.
    Actual(Axis),
    /// Tracking errors of an axis, in place of its commanded or reported positions.
    Error(Axis),
    /// Nothing.
    Unused,
}

/// Reads runs as [`read_runs`](crate::read_runs) does, and tells what their columns are taken for.
///
/// # Errors
/// As [`read_runs`](crate::read_runs).
pub fn inspect(path: &Path, options: &ReadOptions) -> Result<Inspection, DatasetError> {
    let bytes = std::fs::read(path).map_err(|source| DatasetError::io(path, source))?;
    let format = format_of(&bytes).map_or("unknown", |format| format.name());
    let table = table_of(path, bytes)?;
    let mut report = Report { findings: table.findings.clone() };
    let options = stated(path, options, &mut report)?;
    let columns = columns(&table, &map_of(path, &table, &options)?);
    let (runs, report) = runs_of(path, &table, &options, report)?;
    Ok(Inspection { format, rows: table.len(), columns, runs, report })
}

fn columns(table: &Table, map: &ColumnMap) -> Vec<Column> {
    let of = |(index, name): (usize, &String)| {
        let (role, unit) = role(index, map);
        Column { name: name.clone(), role, unit }
    };
    table.names.iter().enumerate().map(of).collect()
}

fn role(index: usize, map: &ColumnMap) -> (Role, String) {
    let mut times = map.time.iter().chain(map.clocks.iter().map(|clock| &clock.time));
    if let Some(time) = times.find(|time| time.column == index) {
        return (Role::Time, unit_name(time.scale, Quantity::Time));
    }
    for axis in &map.axes {
        let quantity = Quantity::of(axis.axis.kind);
        let of = |side, role: Role| if axis.error_for == Some(side) { Role::Error(axis.axis.clone()) } else { role };
        for (source, role) in [
            (axis.reference, of(Side::Reference, Role::Commanded(axis.axis.clone()))),
            (axis.actual, of(Side::Actual, Role::Actual(axis.axis.clone()))),
        ] {
            if source.column == index {
                return (role, unit_name(source.scale, quantity));
            }
        }
    }
    (Role::Unused, String::new())
}
