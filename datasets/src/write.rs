//! Logs to files.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use motion::Trajectory;

use crate::formats::parquet;
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
    write_columns(path, &columns)
}

pub(crate) fn times(trajectory: &Trajectory) -> (String, Vec<f64>) {
    let times = (0..trajectory.len()).map(|k| k as f64 * trajectory.period_s()).collect();
    ("t".to_owned(), times)
}

pub(crate) fn write_columns(path: &Path, columns: &[(String, Vec<f64>)]) -> Result<(), DatasetError> {
    let as_parquet =
        path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("parquet") || ending.eq_ignore_ascii_case("pq"));
    write_atomically(path, |file: &mut File| {
        if as_parquet {
            parquet::write(file, columns).map_err(|error| DatasetError::format(path, error))
        } else {
            write_text(file, columns).map_err(|source| DatasetError::io(path, source))
        }
    })
}

fn write_text(file: &mut File, columns: &[(String, Vec<f64>)]) -> std::io::Result<()> {
    let mut file = BufWriter::new(file);
    let names: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
    writeln!(file, "{}", names.join(","))?;
    for row in 0..columns.first().map_or(0, |(_, values)| values.len()) {
        for (index, (_, values)) in columns.iter().enumerate() {
            let comma = if index > 0 { "," } else { "" };
            write!(file, "{comma}{:.DECIMALS$}", values[row])?;
        }
        file.write_all(b"\n")?;
    }
    file.flush()
}
