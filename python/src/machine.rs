//! Machines: descriptions, simulated and learned ones, and those written in Python.

use std::sync::{Mutex, PoisonError};

use machine::{Machine, MachineError};
use models::LearnedMachine as Learned;
use motion::{Axis, Trajectory};
use numpy::PyArray2;
use pipeline::Setup;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString, PyType};

use crate::errors::{OrRaise, UsageError};
use crate::options::{self, SimulationOptions};
use crate::progress::Failure;
use crate::{arrays, tables};

/// Description of a machine: axes, limits, kinematics, control, and the drives of a simulated one.
#[pyclass(frozen, module = "precomp")]
pub struct MachineSpec(pub machine::MachineSpec);

#[pymethods]
impl MachineSpec {
    /// A built-in machine, `random:SEED`, a TOML file, or its text.
    #[new]
    fn new(machine: &Bound<'_, PyAny>) -> PyResult<Self> {
        Ok(Self(spec(machine)?))
    }

    /// Name of the machine.
    #[getter]
    fn name(&self) -> &str {
        &self.0.name
    }

    /// Names of the axes.
    #[getter]
    fn axes(&self) -> Vec<String> {
        self.0.axes.iter().map(|axis| axis.axis().name).collect()
    }

    /// Sampling period of references, s.
    #[getter]
    fn period_s(&self) -> f64 {
        self.0.sampling_period_s()
    }

    /// The description as the text of a machine file.
    fn to_toml(&self) -> PyResult<String> {
        self.0.to_toml().or_raise()
    }

    /// For copies and pickles.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyType>, (String,))> {
        Ok((slf.get_type(), (slf.get().to_toml()?,)))
    }

    fn __repr__(&self) -> String {
        format!("MachineSpec({:?}, axes {})", self.0.name, self.axes().join(" "))
    }
}

/// The description that `machine` is or names.
pub fn spec(machine: &Bound<'_, PyAny>) -> PyResult<machine::MachineSpec> {
    if let Ok(spec) = machine.cast::<MachineSpec>() {
        return Ok(spec.get().0.clone());
    }
    if let Ok(text) = machine.cast::<PyString>() {
        let text = text.to_cow()?;
        if text.contains('\n') {
            return machine::MachineSpec::from_toml(&text).or_raise();
        }
    }
    match tables::path(machine)? {
        Some(path) => precomp::read::machine(&path.to_string_lossy()).or_raise(),
        None => {
            Err(UsageError::new_err("a machine is given by its name, the path or text of its machine file, or a MachineSpec"))
        }
    }
}

/// A machine of simulated drives. Its noise goes on from run to run.
#[pyclass(frozen, module = "precomp")]
pub struct SimulatedMachine {
    pub spec: machine::MachineSpec,
    pub seed: u64,
    pub options: SimulationOptions,
    machine: Mutex<machine::SimulatedMachine>,
}

impl SimulatedMachine {
    /// The machine before its first run, with the noise of a seed.
    pub fn fresh(&self, seed: u64) -> Result<machine::SimulatedMachine, MachineError> {
        machine::SimulatedMachine::new(&self.spec, seed)?.with_options(self.options.into())
    }
}

#[pymethods]
impl SimulatedMachine {
    #[new]
    #[pyo3(signature = (machine, *, seed = 1, **options))]
    fn new(machine: &Bound<'_, PyAny>, seed: u64, options: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let (spec, options) = (spec(machine)?, options::read::<SimulationOptions>(options)?);
        let machine = machine::SimulatedMachine::new(&spec, seed).or_raise()?.with_options(options.into()).or_raise()?;
        Ok(Self { spec, seed, options, machine: Mutex::new(machine) })
    }

    /// Description of the machine.
    #[getter]
    fn spec(&self) -> MachineSpec {
        MachineSpec(self.spec.clone())
    }

    /// Runs a reference, and returns the actual positions.
    #[pyo3(signature = (reference, period_s = None))]
    fn run<'py>(
        &self,
        py: Python<'py>,
        reference: &Bound<'py, PyAny>,
        period_s: Option<f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let axes: Vec<Axis> = self.spec.axes.iter().map(machine::AxisSpec::axis).collect();
        let reference = arrays::trajectory(reference, period_s.unwrap_or(self.spec.sampling_period_s()), &axes)?;
        let run = || self.machine.lock().unwrap_or_else(PoisonError::into_inner).run(&reference);
        arrays::array(py, &py.detach(run).or_raise()?)
    }
}

/// A machine as a model knows it. Its runs have no noise.
#[pyclass(frozen, module = "precomp")]
pub struct LearnedMachine {
    pub spec: machine::MachineSpec,
    pub machine: Mutex<Learned>,
}

#[pymethods]
impl LearnedMachine {
    /// Description of the machine.
    #[getter]
    fn spec(&self) -> MachineSpec {
        MachineSpec(self.spec.clone())
    }

    /// Predicts the actual positions in a run of a reference.
    #[pyo3(signature = (reference, period_s = None))]
    fn run<'py>(
        &self,
        py: Python<'py>,
        reference: &Bound<'py, PyAny>,
        period_s: Option<f64>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let (axes, own_s) = {
            let machine = self.machine.lock().unwrap_or_else(PoisonError::into_inner);
            (machine.axes().to_vec(), machine.period_s())
        };
        let reference = arrays::trajectory(reference, period_s.unwrap_or(own_s), &axes)?;
        let run = || self.machine.lock().unwrap_or_else(PoisonError::into_inner).run(&reference);
        arrays::array(py, &py.detach(run).or_raise()?)
    }
}

/// A machine that is an object of Python with `run(reference, period_s)`.
#[derive(Debug)]
pub struct PythonMachine {
    pub object: Py<PyAny>,
    pub failure: Failure,
}

impl PythonMachine {
    fn columns(&self, reference: &Trajectory) -> PyResult<Vec<Vec<f64>>> {
        Python::attach(|py| {
            let given = (arrays::array(py, reference)?, reference.period_s());
            let actual = self.object.bind(py).call_method1("run", given)?;
            let columns = arrays::columns(&actual, reference.axes().len())?;
            match columns.first().map_or(0, Vec::len) {
                rows if rows == reference.len() => Ok(columns),
                rows => {
                    let why = format!("`run` returned {rows} samples for a reference of {}", reference.len());
                    Err(UsageError::new_err(format!("{why}; it has to return one for each")))
                }
            }
        })
    }
}

impl Machine for PythonMachine {
    fn run(&mut self, reference: &Trajectory) -> Result<Trajectory, MachineError> {
        let columns = self.columns(reference).map_err(|error| {
            let text = error.to_string();
            self.failure.set(error);
            MachineError::Misfit(text)
        })?;
        Ok(reference.with_columns(columns)?)
    }
}

/// The description of the machine that `object` is: `given`, or its own `spec`.
pub fn spec_of(object: &Bound<'_, PyAny>, given: Option<&Bound<'_, PyAny>>) -> PyResult<machine::MachineSpec> {
    match given {
        Some(given) => spec(given),
        None => match object.getattr("spec") {
            Ok(own) => spec(&own),
            Err(_) => Err(UsageError::new_err(
                "the machine does not say what it is: give it an attribute `spec`, or the argument `spec`, with its axes and limits",
            )),
        },
    }
}

/// The setup of a description.
pub fn setup(spec: &machine::MachineSpec) -> PyResult<Setup> {
    Setup::new(spec, None).or_raise()
}
