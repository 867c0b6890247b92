//! Logs of a day, read by polars: only the columns that are needed, and no more rows than are.

use std::path::Path;

use datasets::{Log, ReadOptions, Severity, Table, runs_from_table};
use polars::prelude::{Column, DataFrame, DataType, Engine, HiveOptions, LazyFrame, PlRefPath, ScanArgsParquet, col, len};

use crate::error::{FleetError, Result};
use crate::store::Day;

/// A lazy scan of one file.
pub(crate) fn scan(path: &Path) -> Result<LazyFrame> {
    let place = PlRefPath::try_from_path(path).map_err(FleetError::scan(path))?;
    // Machine and day are known from the folders.
    let hive_options = HiveOptions { enabled: Some(false), ..HiveOptions::default() };
    let args = ScanArgsParquet { glob: false, hive_options, ..ScanArgsParquet::default() };
    LazyFrame::scan_parquet(place, args).map_err(FleetError::scan(path))
}

/// What a query gives, row group by row group.
pub(crate) fn collect(frame: LazyFrame, path: &Path) -> Result<DataFrame> {
    let found = frame.collect_with_engine(Engine::Streaming).map_err(FleetError::scan(path))?;
    Ok(found.unwrap_single())
}

/// Number of rows of a file, from its footer.
fn rows(path: &Path) -> Result<usize> {
    let found = collect(scan(path)?.select([len().cast(DataType::Float64)]), path)?;
    Ok(numbers(&found, path)?.first().and_then(|column| column.first()).map_or(0, |count| *count as usize))
}

/// The first `most` rows of the numeric columns of a file, as in the file: missing numbers are NaN.
///
/// # Errors
/// When the file is no Parquet file, or damaged.
pub fn read_table(path: &Path, most: usize) -> Result<Table> {
    let mut frame = scan(path)?;
    let schema = frame.collect_schema().map_err(FleetError::scan(path))?;
    let names: Vec<String> =
        schema.iter().filter(|(_, kind)| kind.is_primitive_numeric()).map(|(name, _)| name.to_string()).collect();
    let columns = names.iter().map(|name| col(name.as_str()).cast(DataType::Float64));
    let found = collect(frame.select(columns.collect::<Vec<_>>()).slice(0, u32::try_from(most).unwrap_or(u32::MAX)), path)?;
    let columns = numbers(&found, path)?;
    let count = columns.first().map_or(0, Vec::len);
    Ok(Table { names, columns, lines: (1..=count).collect(), ..Table::default() })
}

/// The columns of a frame of `f64`.
pub(crate) fn numbers(frame: &DataFrame, path: &Path) -> Result<Vec<Vec<f64>>> {
    let column = |column: &Column| -> Result<Vec<f64>> {
        let values = column.f64().map_err(FleetError::scan(path))?;
        Ok(values.iter().map(|value| value.unwrap_or(f64::NAN)).collect())
    };
    frame.columns().iter().map(column).collect()
}

/// The logs of a day, one for every stretch without a gap: all of it up to `most` samples, else the first part of every file, so that memory does
/// not grow with the length of a day. mm, rad and s; named by file.
///
/// # Errors
/// When a file cannot be read, its columns are not recognised, or it is not fit for use.
pub fn day_logs(day: &Day, most: usize) -> Result<Vec<Log>> {
    let lengths = day.files.iter().map(|file| rows(file)).collect::<Result<Vec<usize>>>()?;
    let share = most as f64 / lengths.iter().sum::<usize>().max(1) as f64;
    let mut logs = Vec::new();
    for (file, length) in day.files.iter().zip(lengths) {
        let part = if share < 1.0 { (share * length as f64).ceil() as usize } else { length };
        let (runs, report) = runs_from_table(file, &read_table(file, part)?, &ReadOptions::default())?;
        if let Some(finding) = report.of(Severity::Refuse).next() {
            return Err(FleetError::Unfit { path: file.clone(), reason: finding.to_string() });
        }
        logs.extend(runs);
    }
    Ok(logs)
}
