//! `measure`: tracking and contour error of a recorded run.

use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::measurement::{self, Measurement};
use crate::model::Model;

/// Tracking and contour error of a recorded run, as the command `measure` finds them.
#[pyfunction]
#[pyo3(signature = (log, desired = None, *, machine = None, model = None, **options))]
pub fn measure(
    py: Python<'_>,
    log: &Bound<'_, PyAny>,
    desired: Option<&Bound<'_, PyAny>>,
    machine: Option<&Bound<'_, PyAny>>,
    model: Option<&Bound<'_, Model>>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<Measurement> {
    measurement::measure(py, log, desired, machine, model.map(|model| &model.get().bundle), options)
}
