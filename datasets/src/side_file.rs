//! Side files: mapping and period of a log that does not state them.

use std::path::{Path, PathBuf};

use crate::DatasetError;
use crate::columns::{Quantity, Unit};
use crate::options::ReadOptions;

/// Extension that is appended to the log's name: `run.txt.columns` for `run.txt`.
const ENDING: &str = "columns";

/// Path of the side file of the log `path`: `run.txt.columns` for `run.txt`.
#[must_use]
pub fn side_file(path: &Path) -> PathBuf {
    let mut beside = path.as_os_str().to_owned();
    beside.push(".");
    beside.push(ENDING);
    PathBuf::from(beside)
}

/// Reads the side file of `path`; `None` if there is none.
///
/// It has one entry per line: `period = 1 ms`, and those of a column mapping (`x_ref = 1:mm`, `x:inch`); `#`
/// begins a comment.
///
/// # Errors
/// When it cannot be read or parsed.
pub(crate) fn read_side_file(path: &Path) -> Result<Option<(PathBuf, ReadOptions)>, DatasetError> {
    let beside = side_file(path);
    if !beside.is_file() {
        return Ok(None);
    }
    let text = std::fs::read_to_string(&beside).map_err(|source| DatasetError::io(&beside, source))?;
    let mut options = ReadOptions::default();
    let mut columns = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default().trim();
        match line.split_once('=') {
            _ if line.is_empty() => {}
            Some((key, value)) if key.trim() == "period" => {
                let period_s = period_s(value.trim()).ok_or_else(|| {
                    let message = format!("line {}: `{}` is no period; write it as `period = 1 ms`", index + 1, value.trim());
                    DatasetError::format(&beside, message)
                })?;
                options.period_s = Some(period_s);
            }
            Some(_) => columns.push(line.to_owned()),
            // The unit of an axis.
            None if line.contains(':') => columns.push(line.to_owned()),
            None => {
                let message = format!("line {}: `{line}` has no `=`; write `period = 1 ms` or `x_ref = 1:mm`", index + 1);
                return Err(DatasetError::format(&beside, message));
            }
        }
    }
    options.columns = (!columns.is_empty()).then(|| columns.join(","));
    Ok(Some((beside, options)))
}

/// A positive time with its unit, s.
pub(crate) fn period_s(text: &str) -> Option<f64> {
    let end = text.find(|c: char| !(c.is_ascii_digit() || ['.', 'e', '-', '+'].contains(&c)))?;
    let unit = Unit::named(&text[end..]).filter(|unit| unit.quantity == Quantity::Time)?;
    let value: f64 = text[..end].trim().parse().ok()?;
    (value.is_finite() && value > 0.0).then_some(value * unit.scale)
}
