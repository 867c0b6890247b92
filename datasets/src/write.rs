//! Logs to files.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use motion::Trajectory;
use polars::prelude::{Column, CsvWriter, DataFrame, ParquetWriter, SerWriter};

use crate::{DatasetError, Log, write_atomically};

/// Digits after the decimal point in text files: 1e-9 mm, rad or s.
const DECIMALS: usize = 9;

/// Writes a run as `t,x_ref,x_act,y_ref,y_act,…` in s, mm, rad: Parquet where the name ends in `.parquet`, else CSV with nine decimals.
///
/// # Errors
/// When the file cannot be written; what was at `path` is then still there.
pub fn write_log(path: &Path, log: &Log) -> Result<(), DatasetError> {
    log.reference.check_matches(&log.actual)?;
    let mut columns = vec![times(&log.reference)];
    let pairs = log.reference.columns().iter().zip(log.actual.columns());
    for (axis, (reference, actual)) in log.axes().iter().zip(pairs) {
        columns.push((format!("{axis}_ref"), reference.clone()));
        columns.push((format!("{axis}_act"), actual.clone()));
    }
    write_columns(path, columns)
}

pub(crate) fn times(trajectory: &Trajectory) -> (String, Vec<f64>) {
    let times = (0..trajectory.len()).map(|k| k as f64 * trajectory.period_s()).collect();
    ("t".to_owned(), times)
}

pub(crate) fn write_columns(path: &Path, columns: Vec<(String, Vec<f64>)>) -> Result<(), DatasetError> {
    let failed = |error: polars::error::PolarsError| DatasetError::format(path, error);
    let columns = columns.into_iter().map(|(name, values)| Column::new(name.as_str().into(), values)).collect();
    let mut frame = DataFrame::new_infer_height(columns).map_err(failed)?;
    let parquet =
        path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("parquet") || ending.eq_ignore_ascii_case("pq"));
    write_atomically(path, |file: &mut File| {
        if parquet {
            ParquetWriter::new(file).finish(&mut frame).map(|_| ()).map_err(failed)
        } else {
            let mut buffered = BufWriter::new(file);
            CsvWriter::new(&mut buffered).with_float_precision(Some(DECIMALS)).finish(&mut frame).map_err(failed)?;
            std::io::Write::flush(&mut buffered).map_err(|source| DatasetError::io(path, source))
        }
    })
}
