//! Reads and writes references: `t,x,y,z[,a,b,c]`.

use std::path::Path;

use motion::{Axis, Trajectory};

use crate::clocks::on_one_clock;
use crate::columns::{CommandColumns, recognise_reference};
use crate::formats::read_table;
use crate::read::{map_of, opened};
use crate::recorded::{Recorded, columns_of};
use crate::write::{content, times, write_content};
use crate::{ColumnMap, DatasetError, ReadOptions, Report, Table, turns};

/// Reads a reference, one column per axis; of a log, the commanded columns.
///
/// A column mapping in `options` has the form of one for logs; only the `_ref` entries are used.
///
/// # Errors
/// As [`read_log`](crate::read_log), and when the time stamps have a gap: what is commanded there is not known.
pub fn read_reference(path: &Path, options: &ReadOptions) -> Result<(Trajectory, Report), DatasetError> {
    if options.columns.is_none() {
        return reference_from_table(path, &read_table(path)?, options.period_s);
    }
    let (table, options, mut report) = opened(path, options)?;
    let map = map_of(path, &table, &options)?;
    report.findings.extend(map.findings());
    reference_of(path, &table, commands_of(path, &table, map)?, options.period_s, report)
}

/// The commanded columns of a log.
///
/// # Errors
/// When an axis has none.
pub(crate) fn commands_of(path: &Path, table: &Table, map: ColumnMap) -> Result<CommandColumns, DatasetError> {
    map.try_into().map_err(|reason| DatasetError::Columns { path: path.to_owned(), reason, names: table.names.clone() })
}

/// As [`read_reference`], from columns that are already in memory, named as in a file; errors have the name `path`. `period_s` is the
/// sampling period where there are no time stamps.
///
/// # Errors
/// As [`read_reference`].
pub fn reference_from_table(path: &Path, table: &Table, period_s: Option<f64>) -> Result<(Trajectory, Report), DatasetError> {
    let report = Report { findings: table.findings.clone() };
    reference_of(path, table, recognise_reference(path, table)?, period_s, report)
}

fn reference_of(
    path: &Path,
    table: &Table,
    CommandColumns { time, clocks, axes: sources }: CommandColumns,
    period_s: Option<f64>,
    mut report: Report,
) -> Result<(Trajectory, Report), DatasetError> {
    let (table, findings) = on_one_clock(path, table, time, &clocks)?;
    report.findings.extend(findings);
    let mut columns = columns_of(path, &table, &sources)?;
    let axes: Vec<Axis> = sources.iter().map(|(axis, _)| axis.clone()).collect();
    report.findings.extend(turns::go_on(&axes, &mut columns));
    let (recorded, findings) = Recorded::new(path, &table, time, (&sources, columns), period_s)?;
    report.findings.extend(findings);
    if let Some((gap, line, time_s)) = recorded.gaps().first() {
        return Err(DatasetError::Gap { path: path.to_owned(), line: *line, time_s: *time_s, step_s: gap.step_s });
    }
    let uniform = recorded.uniform(path)?;
    report.findings.extend(uniform.findings);
    Ok((Trajectory::new(uniform.period_s, axes, uniform.columns)?, report))
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
