//! `excite`: motions that teach a machine's axes.

use std::path::PathBuf;

use datasets::{ExcitationPlan, excite as plan_runs, reference_content, write_all};
use motion::Trajectory;
use numpy::{PyArray1, PyArray2};
use pipeline::excitation::{self, ControlProgram, Style, control_test, in_program_words, next_excitation, program, travel};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays;
use crate::errors::{OrRaise, UsageError};
use crate::log::Log;
use crate::machine::spec;
use crate::model::Model;
use crate::options::{self, ExciteOptions};
use crate::path;
use crate::progress::{self, Failure};

/// One run of an excitation: a reference, and the same as a program.
#[pyclass(frozen, module = "precomp")]
#[derive(Clone)]
pub struct ExcitationRun {
    pub name: String,
    pub reference: Trajectory,
    program: String,
}

#[pymethods]
impl ExcitationRun {
    /// Name of the run.
    #[getter]
    fn name(&self) -> &str {
        &self.name
    }

    /// Names of the axes.
    #[getter]
    fn axes(&self) -> Vec<String> {
        arrays::names(self.reference.axes())
    }

    /// Time between samples, s.
    #[getter]
    fn period_s(&self) -> f64 {
        self.reference.period_s()
    }

    /// Instants of the samples, s.
    #[getter]
    fn time_s<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        arrays::times(py, &self.reference)
    }

    /// Positions to command, mm or rad.
    #[getter]
    fn reference<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        arrays::array(py, &self.reference)
    }

    /// The run as a part program.
    #[getter]
    fn program(&self) -> &str {
        &self.program
    }
}

/// An excitation: runs that teach the axes, and a test that shows how the control plans.
#[pyclass(frozen, module = "precomp")]
pub struct Excitation {
    runs: Vec<ExcitationRun>,
    control_test: Option<String>,
}

#[pymethods]
impl Excitation {
    /// The runs.
    #[getter]
    fn runs(&self) -> Vec<ExcitationRun> {
        self.runs.clone()
    }

    /// The control test as a part program; `None` where the travel is too small for it.
    #[getter]
    fn control_test(&self) -> Option<&str> {
        self.control_test.as_deref()
    }

    /// Seconds of motion of the runs.
    #[getter]
    fn seconds(&self) -> f64 {
        self.runs.iter().map(|run| run.reference.duration_s()).sum()
    }

    /// Writes the files that the command writes: a CSV and a program for each run, and the control test.
    fn save(&self, folder: PathBuf) -> PyResult<()> {
        let mut files = Vec::new();
        for run in &self.runs {
            let table = folder.join(format!("{}.csv", run.name));
            let content = reference_content(&table, &run.reference).or_raise()?;
            files.push((table, content));
            files.push((folder.join(format!("{}.nc", run.name)), run.program.as_bytes().to_vec()));
        }
        if let Some(test) = &self.control_test {
            files.push((folder.join(format!("{}.nc", ControlProgram::NAME)), test.as_bytes().to_vec()));
        }
        let shown = folder.display().to_string();
        write_all(&files).map_err(|error| UsageError::new_err(format!("cannot write {shown}: {error}")))
    }
}

/// Random-spline excitation to run on a machine, as the command `excite` writes it.
#[pyfunction]
#[pyo3(signature = (machine, *, seed = 1, after = None, part = None, **options))]
pub fn excite(
    py: Python<'_>,
    machine: &Bound<'_, PyAny>,
    seed: u64,
    after: Option<PyRef<'_, Model>>,
    part: Option<&Bound<'_, PyAny>>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<Excitation> {
    let (machine, options) = (spec(machine)?, options::read::<ExciteOptions>(options)?);
    let setup = options.output.setup(&machine).or_raise()?;
    let part = part.map(|part| path::source(part, setup.period_s, setup.kinematics.axes())).transpose()?;
    if part.is_some() && after.is_none() {
        return Err(UsageError::new_err("`part` needs `after`, a model"));
    }
    let model = after.as_ref().map(|model| &model.bundle);
    progress::run(py, None, &Failure::default(), move |_| {
        let region = options.region.region(&machine);
        let (plan, travel) = match model {
            Some(model) => {
                let part = part.map(|part| part.on(&setup, &options.program.settings(), options.program.feed)).transpose()?;
                let next = next_excitation(model, (&machine, &setup), &region, part.as_ref(), options.seconds, seed)?;
                (next.plan, next.travel)
            }
            None => (ExcitationPlan::of_seconds(options.seconds), travel(&machine, &region)?),
        };
        let runs = plan_runs(&plan, &setup.limits, setup.kinematics.axes(), &travel, setup.period_s, seed)?;
        let spacing_s = options.output.spacing.map(|spacing_ms| spacing_ms * 1e-3);
        let style = Style::of(&options.output.settings(&setup).refit(), spacing_s, &setup);
        let control_test = control_test(runs.len(), &setup, &travel, &style, seed)?.map(|test| test.text);
        let run = |(number, (name, reference)): (usize, (String, Trajectory))| -> anyhow::Result<ExcitationRun> {
            let program = program(&name, number, &in_program_words(&reference, &setup)?, &style)?;
            Ok(ExcitationRun { name, reference, program })
        };
        Ok(Excitation { runs: runs.into_iter().enumerate().map(run).collect::<anyhow::Result<_>>()?, control_test })
    })
}

/// Logs of excitation on a simulated machine: what recording it on a real one gives.
#[pyfunction]
#[pyo3(signature = (machine, *, seconds = 60.0, travel = 60.0, seed = 1))]
pub fn record(py: Python<'_>, machine: &Bound<'_, PyAny>, seconds: f64, travel: f64, seed: u64) -> PyResult<Vec<Log>> {
    let given = PyDict::new(py);
    given.set_item("seconds", seconds)?;
    given.set_item("travel", travel)?;
    let (machine, options) = (spec(machine)?, options::read::<ExciteOptions>(Some(&given))?);
    let logs = progress::run(py, None, &Failure::default(), move |_| {
        Ok(excitation::record(&machine, options.seconds, options.region.travel, seed)?)
    })?;
    Ok(logs.into_iter().map(Log::from).collect())
}
