//! Contour errors, sample by sample.

use anyhow::Result;
use motion::{DesiredPath, Trajectory};
use numpy::PyArray1;
use pipeline::statistics::contour_errors;
use pyo3::prelude::*;

/// Contour error of every sample of a run in the path's time, mm.
pub fn errors_mm(desired: &DesiredPath, actual: &Trajectory) -> Result<Vec<f64>> {
    Ok(contour_errors(desired, actual)?.iter().map(|error| error.magnitude_mm).collect())
}

/// Lengths in µm.
pub fn micrometres<'py>(py: Python<'py>, lengths_mm: &[f64]) -> Bound<'py, PyArray1<f64>> {
    PyArray1::from_vec(py, lengths_mm.iter().map(|length| length * 1e3).collect())
}
