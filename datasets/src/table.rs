//! Named columns of numbers without an interpretation.

use crate::{DatasetError, Finding};
use std::path::Path;

/// Output of a [`LogFormat`](crate::LogFormat): columns of equal length, as in the file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// Column names, optionally followed by a unit in brackets or after an underscore.
    pub names: Vec<String>,
    /// One column per name; NaN for missing numbers.
    pub columns: Vec<Vec<f64>>,
    /// Line of each row in a text file, row of a binary file, from 1.
    pub lines: Vec<usize>,
    /// Sampling period, s, if the format states it.
    pub period_s: Option<f64>,
    /// Corrections while reading.
    pub findings: Vec<Finding>,
}

impl Table {
    /// Number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.lines.len()
    }

    /// Whether there is no row.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.lines.is_empty()
    }

    /// Column `index`, each value times `scale`.
    ///
    /// # Errors
    /// When there is no such column.
    pub(crate) fn scaled(&self, path: &Path, index: usize, scale: f64) -> Result<Vec<f64>, DatasetError> {
        let missing = || DatasetError::format(path, format!("there is no column {}", index + 1));
        Ok(self.columns.get(index).ok_or_else(missing)?.iter().map(|value| value * scale).collect())
    }

    /// As [`Table::scaled`], of numbers only.
    ///
    /// # Errors
    /// As [`Table::scaled`], and when a value is not finite.
    pub(crate) fn finite(&self, path: &Path, index: usize, scale: f64) -> Result<Vec<f64>, DatasetError> {
        let values = self.scaled(path, index, scale)?;
        let Some(row) = values.iter().position(|value| !value.is_finite()) else { return Ok(values) };
        let column = self.names.get(index).cloned().unwrap_or_default();
        Err(DatasetError::Missing { path: path.to_owned(), line: self.lines.get(row).copied().unwrap_or(row + 1), column })
    }

    /// As [`Table::finite`], with no value beyond ± `most`, in `unit`.
    ///
    /// # Errors
    /// As [`Table::finite`], and [`DatasetError::Absurd`] for the first value beyond.
    pub(crate) fn within(
        &self,
        path: &Path,
        index: usize,
        scale: f64,
        most: f64,
        unit: &'static str,
    ) -> Result<Vec<f64>, DatasetError> {
        let values = self.finite(path, index, scale)?;
        let Some(row) = values.iter().position(|value| value.abs() > most) else { return Ok(values) };
        let line = self.lines.get(row).copied().unwrap_or(row + 1);
        let column = self.names.get(index).cloned().unwrap_or_default();
        Err(DatasetError::Absurd { path: path.to_owned(), line, column, value: values[row], most, unit })
    }
}
