//! Excitation for Python: its runs, and their files.

use std::path::PathBuf;

use datasets::{reference_content, write_all};
use motion::Trajectory;
use numpy::{PyArray1, PyArray2};
use pipeline::excitation::ControlProgram;
use pyo3::prelude::*;

use crate::arrays;
use crate::errors::{OrRaise, UsageError};

/// One run of an excitation: a reference, and the same as a program.
#[pyclass(frozen, module = "precomp")]
#[derive(Clone)]
pub struct ExcitationRun {
    pub name: String,
    pub reference: Trajectory,
    pub program: Option<String>,
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

    /// The run as a part program; `None` where no word of a program states an axis.
    #[getter]
    fn program(&self) -> Option<&str> {
        self.program.as_deref()
    }
}

/// An excitation: runs that teach the axes, and a test that shows how the control plans.
#[pyclass(frozen, module = "precomp")]
pub struct Excitation {
    pub runs: Vec<ExcitationRun>,
    pub control_test: Option<String>,
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
            if let Some(program) = &run.program {
                files.push((folder.join(format!("{}.nc", run.name)), program.as_bytes().to_vec()));
            }
        }
        if let Some(test) = &self.control_test {
            files.push((folder.join(format!("{}.nc", ControlProgram::NAME)), test.as_bytes().to_vec()));
        }
        let shown = folder.display().to_string();
        write_all(&files).map_err(|error| UsageError::new_err(format!("cannot write {shown}: {error}")))
    }
}
