//! Reads and writes references: `t,x,y,z[,a,b,c]`.

use std::path::Path;

use motion::{Axis, Trajectory};

use crate::columns::recognise_reference;
use crate::formats::read_table;
use crate::read::uniform_columns;
use crate::write::{content, times, write_content};
use crate::{DatasetError, ReadOptions, Report, Table};

/// Reads a reference, one column per axis; of a log, the commanded columns.
///
/// A column mapping in `options` has the form of one for logs; only the `_ref` entries are used.
///
/// # Errors
/// As [`read_log`](crate::read_log).
pub fn read_reference(path: &Path, options: &ReadOptions) -> Result<(Trajectory, Report), DatasetError> {
    if options.columns.is_some() {
        let (log, report) = crate::read_log(path, options)?;
        return Ok((log.reference, report));
    }
    reference_from_table(path, &read_table(path)?, options.period_s)
}

/// As [`read_reference`], from columns that are already in memory, named as in a file; errors have the name `path`. `period_s` is the
/// sampling period where there are no time stamps.
///
/// # Errors
/// As [`read_reference`].
pub fn reference_from_table(path: &Path, table: &Table, period_s: Option<f64>) -> Result<(Trajectory, Report), DatasetError> {
    let (time, sources) = recognise_reference(path, table)?;
    let ((period_s, _), columns, findings) = uniform_columns(path, table, time, &sources, period_s)?;
    let axes: Vec<Axis> = sources.into_iter().map(|(axis, _)| axis).collect();
    let mut report = Report { findings: table.findings.clone() };
    report.findings.extend(findings);
    Ok((Trajectory::new(period_s, axes, columns)?, report))
}

/// Writes a reference as `t,x,y,z,…` in s, mm, rad: Parquet where the name ends in `.parquet`, else CSV with nine decimals.
///
/// # Errors
/// When the file cannot be written; the previous file at `path` is then unchanged.
pub fn write_reference(path: &Path, reference: &Trajectory) -> Result<(), DatasetError> {
    write_content(path, &reference_content(path, reference)?)
}

/// The bytes that [`write_reference`] writes to `path`.
///
/// # Errors
/// When the format given by the extension of `path` cannot hold the columns.
pub fn reference_content(path: &Path, reference: &Trajectory) -> Result<Vec<u8>, DatasetError> {
    let mut columns = vec![times(reference)];
    let named = reference.axes().iter().zip(reference.columns());
    columns.extend(named.map(|(axis, column)| (axis.name.clone(), column.clone())));
    content(path, &columns)
}
