//! Writes logs to files.

use std::io::Write;
use std::path::Path;

use motion::Trajectory;

use crate::formats::parquet;
use crate::{DatasetError, Log, write_atomically};

/// Digits after the decimal point in text files: 1e-9 mm, rad or s.
const DECIMALS: usize = 9;

/// Writes a run as `t,x_ref,x_act,y_ref,y_act,…` in s, mm, rad: Parquet where the name ends in `.parquet`, else CSV with nine decimals.
///
/// # Errors
/// When the file cannot be written; the previous file at `path` is then unchanged.
pub fn write_log(path: &Path, log: &Log) -> Result<(), DatasetError> {
    write_content(path, &log_content(path, log)?)
}

/// The log as bytes. The extension of `path` selects the format, as in [`write_log`]; nothing is written.
///
/// # Errors
/// When command and actual positions of the log do not match.
pub fn log_content(path: &Path, log: &Log) -> Result<Vec<u8>, DatasetError> {
    log.reference.check_matches(&log.actual)?;
    let mut columns = vec![times(&log.reference)];
    let pairs = log.reference.columns().iter().zip(log.actual.columns());
    for (axis, (reference, actual)) in log.axes().iter().zip(pairs) {
        columns.push((format!("{axis}_ref"), reference.clone()));
        columns.push((format!("{axis}_act"), actual.clone()));
    }
    content(path, &columns)
}

pub(crate) fn times(trajectory: &Trajectory) -> (String, Vec<f64>) {
    let times = (0..trajectory.len()).map(|k| k as f64 * trajectory.period_s()).collect();
    ("t".to_owned(), times)
}

pub(crate) fn write_content(path: &Path, content: &[u8]) -> Result<(), DatasetError> {
    write_atomically(path, |file| file.write_all(content).map_err(|source| DatasetError::io(path, source)))
}

/// Named columns in the format given by the extension of `path`.
pub(crate) fn content(path: &Path, columns: &[(String, Vec<f64>)]) -> Result<Vec<u8>, DatasetError> {
    let as_parquet =
        path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("parquet") || ending.eq_ignore_ascii_case("pq"));
    let mut bytes = Vec::new();
    if as_parquet {
        parquet::write(&mut bytes, columns).map_err(|error| DatasetError::format(path, error))?;
    } else {
        write_text(&mut bytes, columns).map_err(|source| DatasetError::io(path, source))?;
    }
    Ok(bytes)
}

fn write_text(bytes: &mut Vec<u8>, columns: &[(String, Vec<f64>)]) -> std::io::Result<()> {
    let names: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
    writeln!(bytes, "{}", names.join(","))?;
    for row in 0..columns.first().map_or(0, |(_, values)| values.len()) {
        for (index, (_, values)) in columns.iter().enumerate() {
            let comma = if index > 0 { "," } else { "" };
            write!(bytes, "{comma}{:.DECIMALS$}", values[row])?;
        }
        bytes.write_all(b"\n")?;
    }
    Ok(())
}
