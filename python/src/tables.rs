//! What a run may be given as: a file, a data frame, a dictionary of arrays.

use std::path::{Path, PathBuf};

use datasets::{Log, ReadOptions, Report, Table, log_from_table, runs_from_table};
use numpy::{AllowTypeChange, PyArrayLike1};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

use crate::arrow;
use crate::errors::{OrRaise, UsageError};

/// A run, and what reading it found.
pub type Read = (Log, Report);

/// The run of one frame; `index` numbers it where it has no name.
pub fn run(frame: &Bound<'_, PyAny>, index: usize, options: &ReadOptions) -> PyResult<Read> {
    if let Some(path) = path(frame)? {
        return frame.py().detach(|| precomp::read::log(&path, options)).or_raise();
    }
    let Some(table) = table(frame)? else { return Err(no_frame(frame)) };
    log_from_table(Path::new(&format!("run-{}", index + 1)), &table, options).or_raise()
}

/// The runs of one frame, cut at the gaps of its time stamps, and what reading it found.
pub fn runs(frame: &Bound<'_, PyAny>, index: usize, options: &ReadOptions) -> PyResult<(Vec<Log>, Report)> {
    if let Some(path) = path(frame)? {
        return frame.py().detach(|| precomp::read::runs(&path, options)).or_raise();
    }
    let Some(table) = table(frame)? else { return Err(no_frame(frame)) };
    runs_from_table(Path::new(&format!("run-{}", index + 1)), &table, options).or_raise()
}

/// The path that a text or an `os.PathLike` is; `None` for other objects.
pub fn path(object: &Bound<'_, PyAny>) -> PyResult<Option<PathBuf>> {
    let is_path = object.is_instance_of::<PyString>() || object.hasattr("__fspath__")?;
    is_path.then(|| object.extract()).transpose()
}

/// The columns of a data frame or of a dictionary of arrays; `None` for other objects.
pub fn table(frame: &Bound<'_, PyAny>) -> PyResult<Option<Table>> {
    let Ok(columns) = frame.cast::<PyDict>() else { return arrow::table(frame) };
    let mut table = Table::default();
    for (name, values) in columns {
        let name: String = name.extract().map_err(|_| UsageError::new_err("the names of columns have to be texts"))?;
        let values = numbers(&values).map_err(|error| UsageError::new_err(format!("column `{name}`: {error}")))?;
        if table.columns.first().is_some_and(|first| first.len() != values.len()) {
            let why = format!("column `{name}` has {} values, the first one {}", values.len(), table.columns[0].len());
            return Err(UsageError::new_err(format!("{why}; give columns of equal length")));
        }
        table.lines = (1..=values.len()).collect();
        table.names.push(name);
        table.columns.push(values);
    }
    Ok(Some(table))
}

/// The numbers of an array; instants as seconds since the first one.
fn numbers(values: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let array = values.py().import("numpy")?.call_method1("asarray", (values,))?;
    let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
    if kind == "M" || kind == "m" {
        let ticks = array.call_method1("astype", (format!("{kind}8[ns]"),))?.call_method1("view", ("i8",))?;
        let ticks = ticks.call_method1("__sub__", (ticks.get_item(0)?,))?;
        return numbers(&ticks.call_method1("__truediv__", (1e9,))?);
    }
    let array = array.extract::<PyArrayLike1<'_, f64, AllowTypeChange>>()?;
    Ok(array.as_array().to_vec())
}

/// The error for an object that is no run.
fn no_frame(frame: &Bound<'_, PyAny>) -> PyErr {
    let kind = frame.get_type().name().map_or_else(|_| "object".to_owned(), |name| name.to_string());
    let why = "is no log: give a path, a dictionary of arrays, a Log, or a data frame with `__arrow_c_stream__` (pandas from 2.2, polars, pyarrow)";
    UsageError::new_err(format!("`{kind}` {why}"))
}
