//! `learn`: iterative learning control on any machine.

use std::ops::ControlFlow;

use compensation::{StopRule, learn as iterate};
use machine::{Machine, MachineError};
use motion::{DesiredPath, Trajectory};
use numpy::PyArray2;
use pipeline::model_based_ilc::{Settings, on_machine};
use pipeline::{Event, Input, Progress};
use precomp::print::figures::{contour_json, orientation_json, tracking_json};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::{Value, json};

use crate::laws::Law;
use crate::machine::{PythonMachine, setup, spec_of};
use crate::options::{self, LearnOptions};
use crate::progress::{self, Failure};
use crate::{arrays, json as objects, path};

/// Largest correction of the tool tip where none is given, mm: the largest one that `compensate` takes by itself.
const MAX_SHIFT_MM: f64 = 1.0;

/// One run of a machine during learning.
#[pyclass(frozen, module = "precomp")]
#[derive(Clone)]
pub struct Iteration {
    reference: Trajectory,
    actual: Trajectory,
    figures: Value,
    cost_mm: f64,
}

impl Iteration {
    fn of(input: &Input, reference: Trajectory, actual: Trajectory) -> anyhow::Result<Self> {
        let found = input.figures(&actual)?;
        let figures = json!({
            "contour_um": contour_json(&found.tip),
            "orientation_urad": orientation_json(found.orientation.as_ref()),
            "tracking_um": tracking_json(&reference, &actual)?,
        });
        Ok(Self { reference, actual, figures, cost_mm: found.cost_mm() })
    }
}

#[pymethods]
impl Iteration {
    /// Commanded positions, mm or rad.
    #[getter]
    fn reference<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        arrays::array(py, &self.reference)
    }

    /// Actual positions, mm or rad.
    #[getter]
    fn actual<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        arrays::array(py, &self.actual)
    }

    /// Contour error against the desired path, and tracking error against this run's command.
    #[getter]
    fn figures<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        objects::object(py, &self.figures)
    }
}

/// All runs of learning on a machine; the first one is uncompensated.
#[pyclass(frozen, module = "precomp")]
pub struct Learned {
    desired: Trajectory,
    iterations: Vec<Iteration>,
}

#[pymethods]
impl Learned {
    /// The runs in order.
    #[getter]
    fn iterations(&self) -> Vec<Iteration> {
        self.iterations.clone()
    }

    /// The run with the smallest error.
    #[getter]
    fn best(&self) -> Option<Iteration> {
        self.iterations.iter().min_by(|one, other| one.cost_mm.total_cmp(&other.cost_mm)).cloned()
    }

    /// Desired positions, mm or rad.
    #[getter]
    fn desired<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        arrays::array(py, &self.desired)
    }

    /// Names of the axes.
    #[getter]
    fn axes(&self) -> Vec<String> {
        arrays::names(self.desired.axes())
    }

    /// Time between samples, s.
    #[getter]
    fn period_s(&self) -> f64 {
        self.desired.period_s()
    }
}

/// Learns the reference of a path on a machine, run by run.
///
/// Without a law, Gauss-Newton steps on the contour error; where the tool turns, spatial ILC with the best of several cut-offs: many runs, for
/// machines that repeat exactly.
#[pyfunction]
#[pyo3(signature = (path, machine, law = None, *, spec = None, progress = None, **options))]
pub fn learn(
    py: Python<'_>,
    path: &Bound<'_, PyAny>,
    machine: &Bound<'_, PyAny>,
    law: Option<&Bound<'_, PyAny>>,
    spec: Option<&Bound<'_, PyAny>>,
    progress: Option<Py<PyAny>>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<Learned> {
    let options: LearnOptions = options::read(options)?;
    let setup = setup(&spec_of(machine, spec)?)?;
    let source = path::source(path, setup.period_s, setup.kinematics.axes())?;
    let law = law.map(Law::of).transpose()?;
    let failure = Failure::default();
    let mut machine = PythonMachine { object: machine.clone().unbind(), failure: failure.clone() };
    let called = failure.clone();
    progress::run(py, progress, &failure, move |progress| {
        let input = source.on(&setup, &options.program.simulated(), options.program.feed)?;
        let iterations = runs_of(&input, &mut machine, law, &options, &called, progress)?;
        Ok(Learned { desired: input.trajectory().clone(), iterations })
    })
}

/// The runs of a law on a machine.
fn runs_of(
    input: &Input,
    machine: &mut PythonMachine,
    law: Option<Law>,
    options: &LearnOptions,
    failure: &Failure,
    progress: Progress<'_>,
) -> anyhow::Result<Vec<Iteration>> {
    let LearnOptions { runs, max_shift, .. } = *options;
    let max_rotation_rad = options.max_rotation.to_radians();
    let most = runs + 1;
    let mut machine = Watched { machine, input, runs: 0, most, progress };
    let Some(law) = law else {
        let uncompensated = machine.run(input.trajectory())?;
        let settings = Settings { max_shift, max_rotation_rad, ..Settings::default() };
        let reference = on_machine(&mut machine, input, &settings)?.reference;
        let actual = machine.run(&reference)?;
        let first = Iteration::of(input, input.trajectory().clone(), uncompensated)?;
        return Ok(vec![first, Iteration::of(input, reference, actual)?]);
    };
    let limits = input.correction_limits(max_shift.unwrap_or(MAX_SHIFT_MM), max_rotation_rad, Vec::new());
    let mut law = law.on(&mut machine, input.trajectory(), failure)?;
    let mut measure = |_: &DesiredPath, _: &Trajectory| 0.0;
    let learned = iterate(&mut machine, law.as_mut(), input.desired(), None, &limits, &StopRule::after(runs), &mut measure)?;
    learned.iterations.into_iter().map(|run| Iteration::of(input, run.reference, run.actual)).collect()
}

/// A machine whose runs are reported; it does not run on after the job was cancelled.
struct Watched<'a> {
    machine: &'a mut PythonMachine,
    input: &'a Input,
    runs: usize,
    /// Runs that are expected.
    most: usize,
    progress: Progress<'a>,
}

impl Machine for Watched<'_> {
    fn run(&mut self, reference: &Trajectory) -> Result<Trajectory, MachineError> {
        let actual = self.machine.run(reference)?;
        self.runs += 1;
        let cost_mm = self.input.figures(&actual).map_or(f64::INFINITY, |figures| figures.cost_mm());
        let event = Event::Forecast { number: self.runs, most: self.most.max(self.runs), cost_mm };
        match (self.progress)(event) {
            ControlFlow::Continue(()) => Ok(actual),
            ControlFlow::Break(()) => Err(MachineError::Misfit("cancelled".to_owned())),
        }
    }
}
