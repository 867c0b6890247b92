//! Recorded runs.

use std::path::PathBuf;

use datasets::{ReadOptions, Report, log_content};
use motion::Axis;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::OrRaise;
use crate::options::{self, LogOptions};
use crate::tables::{self, Read};
use crate::{arrays, errors::UsageError};

/// One recorded run: commanded and actual positions at the same instants.
#[pyclass(frozen, module = "precomp")]
pub struct Log {
    pub run: datasets::Log,
    /// What reading it found.
    pub found: Report,
}

impl From<datasets::Log> for Log {
    fn from(run: datasets::Log) -> Self {
        Self { run, found: Report::default() }
    }
}

#[pymethods]
impl Log {
    /// A run from arrays with a row a sample and a column an axis.
    #[new]
    #[pyo3(signature = (reference, actual, *, period_s, axes, name = "log"))]
    fn new(
        reference: &Bound<'_, PyAny>,
        actual: &Bound<'_, PyAny>,
        period_s: f64,
        axes: Vec<String>,
        name: &str,
    ) -> PyResult<Self> {
        let axes: Vec<Axis> = axes.iter().map(|axis| Axis::named(axis)).collect();
        let of = |array| arrays::trajectory(array, period_s, &axes);
        Ok(datasets::Log::new(name, of(reference)?, of(actual)?).or_raise()?.into())
    }

    /// Reads a run from a file, a data frame or a dictionary of arrays.
    #[staticmethod]
    #[pyo3(signature = (frame, **options))]
    fn read(frame: &Bound<'_, PyAny>, options: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let options: LogOptions = options::read(options)?;
        let (run, found) = run(frame, 0, &options.columns.options())?;
        Ok(Self { run, found })
    }

    /// Name of the run.
    #[getter]
    fn name(&self) -> &str {
        &self.run.name
    }

    /// Names of the axes.
    #[getter]
    fn axes(&self) -> Vec<String> {
        arrays::names(self.run.axes())
    }

    /// Time between samples, s.
    #[getter]
    fn period_s(&self) -> f64 {
        self.run.period_s()
    }

    /// Instants of the samples, s.
    #[getter]
    fn time_s<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        arrays::times(py, &self.run.reference)
    }

    /// Commanded positions, mm or rad.
    #[getter]
    fn reference<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        arrays::array(py, &self.run.reference)
    }

    /// Actual positions, mm or rad.
    #[getter]
    fn actual<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        arrays::array(py, &self.run.actual)
    }

    /// What was found while reading, a line each.
    #[getter]
    fn findings(&self) -> Vec<String> {
        self.found.findings.iter().map(ToString::to_string).collect()
    }

    /// The columns `t`, `x_ref`, `x_act` and so on.
    fn columns<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let columns = PyDict::new(py);
        columns.set_item("t", arrays::times(py, &self.run.reference))?;
        let pairs = self.run.reference.columns().iter().zip(self.run.actual.columns());
        for (axis, (reference, actual)) in self.run.axes().iter().zip(pairs) {
            columns.set_item(format!("{axis}_ref"), PyArray1::from_slice(py, reference))?;
            columns.set_item(format!("{axis}_act"), PyArray1::from_slice(py, actual))?;
        }
        Ok(columns)
    }

    /// Writes the run as CSV, or as Parquet where the path ends in `.parquet`.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        write(path.clone(), log_content(&path, &self.run).or_raise()?)
    }

    fn __len__(&self) -> usize {
        self.run.len()
    }

    fn __repr__(&self) -> String {
        let (axes, seconds) = (self.axes().join(" "), self.run.reference.duration_s());
        format!("Log({:?}, axes {axes}, {} samples, {seconds:.2} s)", self.run.name, self.run.len())
    }
}

/// The run of one frame or [`Log`]; `index` numbers it where it has no name.
pub fn run(frame: &Bound<'_, PyAny>, index: usize, options: &ReadOptions) -> PyResult<Read> {
    match frame.cast::<Log>() {
        Ok(log) => Ok((log.get().run.clone(), log.get().found.clone())),
        Err(_) => tables::run(frame, index, options),
    }
}

/// The runs of one frame, cut at the gaps of its time stamps; the first one has what was found.
pub fn runs(frame: &Bound<'_, PyAny>, index: usize, options: &ReadOptions) -> PyResult<Vec<Read>> {
    if frame.cast::<Log>().is_ok() {
        return Ok(vec![run(frame, index, options)?]);
    }
    let (runs, mut found) = tables::runs(frame, index, options)?;
    Ok(runs.into_iter().map(|run| (run, std::mem::take(&mut found))).collect())
}

/// Writes a file: complete or not at all.
pub fn write(path: PathBuf, content: Vec<u8>) -> PyResult<()> {
    let shown = path.display().to_string();
    datasets::write_all(&[(path, content)]).map_err(|error| UsageError::new_err(format!("cannot write {shown}: {error}")))
}
