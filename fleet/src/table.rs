//! Logs of a day, read by polars: only the columns that are needed, and no more rows than are.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use datasets::{Log, ReadOptions, Severity, Table, runs_from_table};
use polars::prelude::{
    Column, DataFrame, DataType, Engine, HiveOptions, LazyFrame, PlRefPath, PolarsResult, ScanArgsParquet, col, len,
};

use crate::error::{FleetError, Result};
use crate::store::Day;

/// The result of a query. polars panics on some damaged files; the panic becomes an error.
fn guarded<T>(path: &Path, query: impl FnOnce() -> PolarsResult<T>) -> Result<T> {
    catch_unwind(AssertUnwindSafe(query))
        .map_err(|_| FleetError::Unfit {
            path: path.to_owned(),
            reason: "the Parquet file is damaged; copy it again".to_owned(),
        })?
        .map_err(FleetError::scan(path))
}

/// A lazy scan of one file.
pub(crate) fn scan(path: &Path) -> Result<LazyFrame> {
    let place = PlRefPath::try_from_path(path).map_err(FleetError::scan(path))?;
    // Machine and day are known from the folders.
    let hive_options = HiveOptions { enabled: Some(false), ..HiveOptions::default() };
    let args = ScanArgsParquet { glob: false, hive_options, ..ScanArgsParquet::default() };
    guarded(path, || LazyFrame::scan_parquet(place, args))
}

/// What a query gives, row group by row group.
pub(crate) fn collect(frame: LazyFrame, path: &Path) -> Result<DataFrame> {
    guarded(path, || Ok(frame.collect_with_engine(Engine::Streaming)?.unwrap_single()))
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
    let schema = guarded(path, || frame.collect_schema())?;
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Bytes of a log turned over one after another, and the file cut off: a table or an error that names the file, no panic and no hang.
    #[test]
    fn a_damaged_file_is_an_error_or_a_table() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.parquet");
        let column = |scale: f64| (0..300).map(|k| scale * f64::from(k)).collect::<Vec<_>>();
        let reference = motion::Trajectory::new(0.002, motion::Axis::xyz()[..1].to_vec(), vec![column(0.01)]).unwrap();
        let actual = reference.with_columns(vec![column(0.0099)]).unwrap();
        let bytes = datasets::log_content(&path, &Log::new("run", reference, actual).unwrap()).unwrap();
        let mut errors = 0;
        let mut check = |damaged: &[u8]| {
            std::fs::write(&path, damaged).unwrap();
            let day = Day { date: "2026-01-01".to_owned(), files: vec![path.clone()] };
            match day_logs(&day, 1000).and_then(|_| crate::quality::quality(&day)) {
                Ok(_) => {}
                Err(error) => {
                    assert!(error.to_string().contains("run.parquet"), "{error}");
                    errors += 1;
                }
            }
        };
        for at in (0..bytes.len()).step_by(3) {
            let mut damaged = bytes.clone();
            damaged[at] ^= 0x41;
            check(&damaged);
            check(&bytes[..at]);
        }
        // At least every file that is cut off.
        assert!(errors >= 100, "{errors}");
    }
}
