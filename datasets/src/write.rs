//! Writes logs to files.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use motion::{Axis, Trajectory};

use crate::atomic::unnamed_beside;
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

/// A log that is written as it comes, for a path: to a file without a name, which takes no memory and leaves nothing behind.
pub struct LogSpool {
    path: PathBuf,
    out: Sink,
    period_s: f64,
    samples: usize,
}

enum Sink {
    Text(BufWriter<File>),
    Parquet(Box<parquet::Writer>),
}

impl LogSpool {
    /// A log with these axes for `path`, whose ending selects the format, as in [`write_log`].
    ///
    /// # Errors
    /// When no file can be made in the folder of `path`.
    pub fn new(path: &Path, axes: &[Axis], period_s: f64) -> Result<Self, DatasetError> {
        let failed = |source| DatasetError::io(path, source);
        let file = unnamed_beside(path).map_err(failed)?;
        let mut names = vec!["t".to_owned()];
        names.extend(axes.iter().flat_map(|axis| [format!("{axis}_ref"), format!("{axis}_act")]));
        let out = if is_parquet(path) {
            let writer = parquet::Writer::new(file, &names).map_err(|error| DatasetError::format(path, error))?;
            Sink::Parquet(Box::new(writer))
        } else {
            let mut file = BufWriter::new(file);
            writeln!(file, "{}", names.join(",")).map_err(failed)?;
            Sink::Text(file)
        };
        Ok(Self { path: path.to_owned(), out, period_s, samples: 0 })
    }

    /// Adds the next samples, one column an axis.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn add(&mut self, reference: &[&[f64]], actual: &[&[f64]]) -> Result<(), DatasetError> {
        let samples = reference.first().map_or(0, |column| column.len());
        let times: Vec<f64> = (self.samples..self.samples + samples).map(|k| k as f64 * self.period_s).collect();
        let mut columns = vec![times.as_slice()];
        columns.extend(reference.iter().zip(actual).flat_map(|(reference, actual)| [*reference, *actual]));
        match &mut self.out {
            Sink::Text(file) => write_rows(file, &columns).map_err(|source| DatasetError::io(&self.path, source))?,
            Sink::Parquet(writer) => writer.add(&columns).map_err(|error| DatasetError::format(&self.path, error))?,
        }
        self.samples += samples;
        Ok(())
    }

    /// The path, and the file with the content for [`write_all_and`](crate::write_all_and).
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn finish(self) -> Result<(PathBuf, File), DatasetError> {
        let file = match self.out {
            Sink::Text(file) => file.into_inner().map_err(|error| DatasetError::io(&self.path, error.into_error()))?,
            Sink::Parquet(writer) => writer.finish().map_err(|error| DatasetError::format(&self.path, error))?,
        };
        Ok((self.path, file))
    }
}

/// Named columns in the format given by the extension of `path`.
pub(crate) fn content(path: &Path, columns: &[(String, Vec<f64>)]) -> Result<Vec<u8>, DatasetError> {
    let mut bytes = Vec::new();
    if is_parquet(path) {
        parquet::write(&mut bytes, columns).map_err(|error| DatasetError::format(path, error))?;
    } else {
        write_text(&mut bytes, columns).map_err(|source| DatasetError::io(path, source))?;
    }
    Ok(bytes)
}

fn is_parquet(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("parquet") || ending.eq_ignore_ascii_case("pq"))
}

fn write_text(bytes: &mut Vec<u8>, columns: &[(String, Vec<f64>)]) -> std::io::Result<()> {
    let names: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
    writeln!(bytes, "{}", names.join(","))?;
    write_rows(bytes, &columns.iter().map(|(_, values)| values.as_slice()).collect::<Vec<_>>())
}

fn write_rows(out: &mut impl Write, columns: &[&[f64]]) -> std::io::Result<()> {
    for row in 0..columns.first().map_or(0, |values| values.len()) {
        for (index, values) in columns.iter().enumerate() {
            let comma = if index > 0 { "," } else { "" };
            write!(out, "{comma}{:.DECIMALS$}", values[row])?;
        }
        out.write_all(b"\n")?;
    }
    Ok(())
}
