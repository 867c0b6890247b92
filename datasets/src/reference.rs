//! Reads and writes references: `t,x,y,z[,a,b,c]`.

use std::path::Path;

use motion::{Axis, Trajectory};

use crate::columns::recognise_reference;
use crate::formats::read_table;
use crate::read::uniform_columns;
use crate::write::{content, times, write_content};
use crate::{DatasetError, ReadOptions, Report};

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
    let table = read_table(path)?;
    let (time, sources) = recognise_reference(path, &table)?;
    let ((period_s, _), columns, findings) = uniform_columns(path, &table, time, &sources, options.period_s)?;
    let axes: Vec<Axis> = sources.into_iter().map(|(axis, _)| axis).collect();
    let mut report = Report { findings: table.findings };
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
