//! Models of machines.

use std::path::PathBuf;
use std::sync::Mutex;

use datasets::Log as Recorded;
use models::Bundle;
use pipeline::{Setup, machine_of, training};
use precomp::print::training as print;
use precomp::read;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use serde_json::{Value, json};

use crate::compensate::{Compensated, Job};
use crate::errors::{OrRaise, UsageError};
use crate::log;
use crate::machine::{LearnedMachine, MachineSpec, spec};
use crate::measurement::{Measurement, log_to_measure, measure};
use crate::options::{self, CompensateOptions, LogOptions, PredictOptions};
use crate::progress::{self, Failure};
use crate::report::Report;
use crate::run::{Run, predict};
use crate::{frames, json as objects, path};

/// A model of a machine.
#[pyclass(frozen, module = "precomp")]
pub struct Model {
    pub bundle: Bundle,
    /// What the training reported; `None` of a model from a file.
    pub report: Option<Report>,
}

#[pymethods]
impl Model {
    /// Reads a model file.
    #[staticmethod]
    fn load(path: PathBuf) -> PyResult<Self> {
        Ok(Self { bundle: read::model(&path).or_raise()?, report: None })
    }

    /// A model from the bytes of its file.
    #[staticmethod]
    fn from_bytes(content: &[u8]) -> PyResult<Self> {
        Ok(Self { bundle: Bundle::from_bytes(content).or_raise()?, report: None })
    }

    /// The bytes of the model's file; the same log, seed and version give the same bytes.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, &self.bundle.to_bytes().or_raise()?))
    }

    /// Writes the model's file: complete or not at all.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        log::write(path, self.bundle.to_bytes().or_raise()?)
    }

    /// Names of the axes.
    #[getter]
    fn axes(&self) -> Vec<String> {
        self.bundle.manifest.axes.iter().map(|axis| axis.name.clone()).collect()
    }

    /// Sampling period, s.
    #[getter]
    fn period_s(&self) -> f64 {
        self.bundle.manifest.period_s
    }

    /// Description of the machine.
    #[getter]
    fn machine(&self) -> PyResult<MachineSpec> {
        Ok(MachineSpec(machine_of(&self.bundle).or_raise()?))
    }

    /// Errors on held-out runs by axis, µm or µrad: `rms`, `max`, `linear_rms`, `raw_rms`.
    #[getter]
    fn held_out<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let axes = self.bundle.manifest.axes.iter().map(|axis| {
            let held = &axis.held_out;
            let figures = json!({
                "rms": held.rms * 1e3, "max": held.max * 1e3, "linear_rms": held.linear_rms * 1e3, "raw_rms": held.raw_rms * 1e3,
            });
            let micro = if axis.rotary { 1e3 } else { 1.0 };
            (axis.name.clone(), scaled(figures, micro))
        });
        objects::object(py, &Value::Object(axes.collect()))
    }

    /// The figures of the training, as the command writes them by `--json`; `None` of a model from a file.
    #[getter]
    fn figures<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.report.as_ref().map(|report| objects::object(py, &report.figures)).transpose()
    }

    /// What the command prints of the training; empty of a model from a file.
    #[getter]
    fn report(&self) -> String {
        self.report.as_ref().map(Report::text).unwrap_or_default()
    }

    /// The lines of the report that warn.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.report.as_ref().map(Report::warnings).unwrap_or_default()
    }

    /// The machine as the model knows it.
    fn learned_machine(&self) -> PyResult<LearnedMachine> {
        let machine = Mutex::new(self.bundle.machine().or_raise()?);
        Ok(LearnedMachine { spec: machine_of(&self.bundle).or_raise()?, machine })
    }

    /// Adapts the model with a short new log: another machine of its kind, another day.
    #[pyo3(signature = (frames, *, seed = 1, **options))]
    fn adapt(&self, py: Python<'_>, frames: &Bound<'_, PyAny>, seed: u64, options: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let options: LogOptions = options::read(options)?;
        let (logs, warnings) = frames::fit(frames::runs(frames, &options.columns.options())?)?;
        progress::run(py, None, &Failure::default(), |_| {
            let started = std::time::Instant::now();
            let (logs, _) = datasets::joined(logs);
            let today = precomp::date::today()?;
            let mut adapted = training::adapt(&self.bundle, &logs, seed)?;
            adapted.bundle.manifest.date = Some(today);
            let figures = print::adapted_json(&adapted, started.elapsed().as_secs_f64(), &warnings);
            let lines = warnings.into_iter().chain([print::adapted(&adapted)]).collect();
            Ok(Self { bundle: adapted.bundle, report: Some(Report { figures, lines }) })
        })
    }

    /// The forecast for a path.
    #[pyo3(signature = (path, **options))]
    fn predict(&self, py: Python<'_>, path: &Bound<'_, PyAny>, options: Option<&Bound<'_, PyDict>>) -> PyResult<Run> {
        let options: PredictOptions = options::read(options)?;
        let setup = Setup::of_model(&self.bundle).or_raise()?;
        let source = path::source(path, setup.period_s, setup.kinematics.axes())?;
        progress::run(py, None, &Failure::default(), |_| predict(&self.bundle, source, &setup, &options))
    }

    /// Shifts a path's points so that the machine cuts what it asks for.
    #[pyo3(signature = (path, *, law = None, machine = None, reference = None, progress = None, **options))]
    #[allow(clippy::too_many_arguments)] // keyword arguments
    fn compensate(
        &self,
        py: Python<'_>,
        path: &Bound<'_, PyAny>,
        law: Option<&Bound<'_, PyAny>>,
        machine: Option<&Bound<'_, PyAny>>,
        reference: Option<&Bound<'_, PyAny>>,
        progress: Option<Py<PyAny>>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Compensated> {
        let given = PyDict::new(py);
        if let Some(options) = options {
            given.update(options.as_mapping())?;
        }
        if let Some(law) = law {
            given.set_item("law", law_name(law)?)?;
        }
        let options: CompensateOptions = options::read(Some(&given))?;
        let own_machine = machine.is_none();
        let machine = machine.map_or_else(|| machine_of(&self.bundle).or_raise(), spec)?;
        let setup = options.output.setup(&machine).or_raise()?;
        let source = path::source(path, setup.period_s, setup.kinematics.axes())?;
        let recorded: Option<Recorded> =
            reference.map(|log| log_to_measure(log, &options.columns.options()).map(|(log, _)| log)).transpose()?;
        progress::run(py, progress, &Failure::default(), |progress| {
            let job = Job { model: &self.bundle, setup, options: &options, recorded, own_machine };
            // Among the threads that share the work: whoever waits for a part does another one meanwhile. A training, which waits for
            // threads of its own, would keep one of them from working.
            rayon::scope(|_| job.compensate(source, progress))
        })
    }

    /// Tracking and contour error of a run on this machine, and whether the model still fits it.
    #[pyo3(signature = (log, desired = None, **options))]
    fn measure(
        &self,
        py: Python<'_>,
        log: &Bound<'_, PyAny>,
        desired: Option<&Bound<'_, PyAny>>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Measurement> {
        measure(py, log, desired, None, Some(&self.bundle), options)
    }

    /// For copies and pickles; the report of the training stays behind.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyBytes>,))> {
        Ok((slf.get_type().getattr("from_bytes")?, (slf.get().to_bytes(slf.py())?,)))
    }

    fn __repr__(&self) -> String {
        let manifest = &self.bundle.manifest;
        let axes: Vec<String> = manifest.axes.iter().map(|axis| format!("{} {}", axis.name, axis.predictor)).collect();
        format!("Model({}, {} ms)", axes.join(", "), manifest.period_s * 1e3)
    }
}

/// Numbers of an object, each times a factor.
fn scaled(figures: Value, factor: f64) -> Value {
    match figures {
        Value::Object(entries) => Value::Object(entries.into_iter().map(|(key, value)| (key, scaled(value, factor))).collect()),
        Value::Number(number) => json!(number.as_f64().map(|number| number * factor)),
        other => other,
    }
}

/// The name of a law of `Model.compensate`, given by its name or as an object of `precomp.laws`.
fn law_name<'py>(law: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    match law.getattr("on_model") {
        Ok(name) if !name.is_none() => Ok(name),
        Ok(_) => Err(UsageError::new_err("this law learns on a machine: precomp.learn(path, machine, law)")),
        Err(_) => Ok(law.clone()),
    }
}
