//! Positions as arrays: a row a sample, a column an axis.

use motion::{Axis, Trajectory};
use numpy::{AllowTypeChange, PyArray1, PyArray2, PyArrayLike1, PyArrayLike2, PyArrayMethods};
use pyo3::prelude::*;

use crate::errors::{OrRaise, UsageError};

/// The positions of a trajectory.
pub fn array<'py>(py: Python<'py>, trajectory: &Trajectory) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (rows, columns) = (trajectory.len(), trajectory.axes().len());
    let mut values = Vec::with_capacity(rows * columns);
    for k in 0..rows {
        values.extend(trajectory.at(k));
    }
    PyArray1::from_vec(py, values).reshape([rows, columns])
}

/// The instants of a trajectory, s.
pub fn times<'py>(py: Python<'py>, trajectory: &Trajectory) -> Bound<'py, PyArray1<f64>> {
    PyArray1::from_vec(py, (0..trajectory.len()).map(|k| k as f64 * trajectory.period_s()).collect())
}

/// The names of axes.
pub fn names(axes: &[Axis]) -> Vec<String> {
    axes.iter().map(|axis| axis.name.clone()).collect()
}

/// The columns of an array of `axes` columns; of one dimension where that is a single axis.
pub fn columns(value: &Bound<'_, PyAny>, axes: usize) -> PyResult<Vec<Vec<f64>>> {
    let found = if let Ok(array) = value.extract::<PyArrayLike2<'_, f64, AllowTypeChange>>() {
        array.as_array().columns().into_iter().map(|column| column.to_vec()).collect()
    } else {
        let wanted = |_| UsageError::new_err("positions are an array with a row a sample and a column an axis, mm and rad");
        let array = value.extract::<PyArrayLike1<'_, f64, AllowTypeChange>>().map_err(wanted)?;
        vec![array.as_array().to_vec()]
    };
    if found.len() != axes {
        let why = format!("the array has {} columns; the machine has {axes} axes, a column each", found.len());
        return Err(UsageError::new_err(why));
    }
    Ok(found)
}

/// An array as a trajectory of these axes.
pub fn trajectory(value: &Bound<'_, PyAny>, period_s: f64, axes: &[Axis]) -> PyResult<Trajectory> {
    Trajectory::new(period_s, axes.to_vec(), columns(value, axes.len())?).or_raise()
}
