//! Runs of a path on a simulated machine, and forecasts of a model.

use std::path::PathBuf;

use anyhow::Result;
use datasets::{Log as Recorded, log_content};
use machine::{Machine, SimulatedMachine as Simulated};
use models::Bundle;
use numpy::{PyArray1, PyArray2};
use pipeline::statistics::{contour_errors_along, figures_along};
use pipeline::{Expectation, PositionTerms, Setup, machine_for};
use precomp::output::Printer;
use precomp::print::compensation as print;
use precomp::print::figures::{contour_json, orientation_json, text, tracking_json};
use precomp::read::Source;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::json;

use crate::contour::{errors_mm, micrometres};
use crate::errors::OrRaise;
use crate::log::{self, Log};
use crate::machine::{SimulatedMachine, setup, spec};
use crate::options::{self, PredictOptions, SimulateOptions};
use crate::progress::{self, Failure};
use crate::report::Report;
use crate::{arrays, json as objects, path};

/// A run of a path: on a simulated machine, or as a model expects it.
#[pyclass(frozen, module = "precomp")]
pub struct Run {
    log: Recorded,
    /// Contour error of every sample, mm.
    errors_mm: Vec<f64>,
    report: Report,
}

#[pymethods]
impl Run {
    /// The run as a log.
    #[getter]
    fn log(&self) -> Log {
        self.log.clone().into()
    }

    /// Name of the path.
    #[getter]
    fn name(&self) -> &str {
        &self.log.name
    }

    /// Names of the axes.
    #[getter]
    fn axes(&self) -> Vec<String> {
        arrays::names(self.log.axes())
    }

    /// Time between samples, s.
    #[getter]
    fn period_s(&self) -> f64 {
        self.log.period_s()
    }

    /// Instants of the samples, s.
    #[getter]
    fn time_s<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        arrays::times(py, &self.log.reference)
    }

    /// Commanded positions, mm or rad.
    #[getter]
    fn reference<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        arrays::array(py, &self.log.reference)
    }

    /// Actual positions, mm or rad.
    #[getter]
    fn actual<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        arrays::array(py, &self.log.actual)
    }

    /// Contour error of every sample, µm; rapids included, which the figures leave out.
    #[getter]
    fn contour_error_um<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        micrometres(py, &self.errors_mm)
    }

    /// The figures that the command writes by `--json`.
    #[getter]
    fn figures<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        objects::object(py, &self.report.figures)
    }

    /// What the command prints.
    #[getter]
    fn report(&self) -> String {
        self.report.text()
    }

    /// The lines of the report that warn, or say what is not known.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.report.warnings()
    }

    /// Writes the run as a log: CSV, or Parquet where the path ends in `.parquet`.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        log::write(path.clone(), log_content(&path, &self.log).or_raise()?)
    }

    fn __len__(&self) -> usize {
        self.log.len()
    }
}

/// Runs a path on the simulated machine, as the command `simulate` does.
#[pyfunction]
#[pyo3(signature = (path, machine = None, *, against = None, seed = 1, **options))]
pub fn simulate(
    py: Python<'_>,
    path: &Bound<'_, PyAny>,
    machine: Option<&Bound<'_, PyAny>>,
    against: Option<&Bound<'_, PyAny>>,
    seed: u64,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<Run> {
    let options: SimulateOptions = options::read(options)?;
    let given = machine.map(|machine| machine.cast::<SimulatedMachine>());
    let (spec, seed, simulation) = match (given, machine) {
        (Some(Ok(machine)), _) => (machine.get().spec.clone(), machine.get().seed, machine.get().options),
        (_, Some(machine)) => (spec(machine)?, seed, options.simulation),
        (_, None) => (machine::MachineSpec::builtin("ballscrew").or_raise()?, seed, options.simulation),
    };
    let setup = setup(&spec)?;
    let source = path::source(path, setup.period_s, setup.kinematics.axes())?;
    let against = against.map(|against| path::source(against, setup.period_s, setup.kinematics.axes())).transpose()?;
    progress::run(py, None, &Failure::default(), move |_| {
        let read = |source: Source| source.on(&setup, &options.program.simulated(), options.program.feed);
        let input = read(source)?;
        let mut simulated = Simulated::new(&spec, seed)?.with_options(simulation.into())?;
        let reference = input.command();
        let actual = simulated.run(reference)?;
        let against = against.map(read).transpose()?;
        let needed = against.as_ref().unwrap_or(&input);
        let figures = figures_along(needed.desired(), needed.part(), reference, &actual)?;
        let (errors, _) = contour_errors_along(needed.desired(), reference, &actual)?;
        let printer = Printer::keeping();
        let (name, seconds) = (&spec.name, reference.duration_s());
        printer.line(format!("{} on the machine `{name}`: {seconds:.2} s; {}", input.name(), text(&figures)));
        let json = json!({
            "seconds": reference.duration_s(),
            "contour_um": contour_json(&figures.tip),
            "orientation_urad": orientation_json(figures.orientation.as_ref()),
            "tracking_um": tracking_json(reference, &actual)?,
        });
        Ok(Run {
            log: Recorded::new(input.name(), reference.clone(), actual.clone())?,
            errors_mm: errors.iter().map(|error| error.magnitude_mm).collect(),
            report: Report::new(json, printer),
        })
    })
}

/// The forecast of a model for a path, as the command `predict` makes it.
pub fn predict(model: &Bundle, source: Source, setup: &Setup, options: &PredictOptions) -> Result<Run> {
    let input = source.on(setup, &options.program.settings(), options.program.feed)?;
    let reference = input.command();
    let actual = machine_for(model, input.part())?.run(reference)?;
    let figures = input.figures(&actual)?;
    let terms = PositionTerms::of(model, &input)?;
    let expected = Expectation::of(model, &input, reference, &actual)?;
    let printer = Printer::keeping();
    print::show_unknown(&printer, &input, setup, terms.as_ref());
    printer.line(format!("{}: {:.2} s; predicted {}", input.name(), reference.duration_s(), text(&figures)));
    if let Some(expected) = &expected {
        print::show_expectation(&printer, expected);
    }
    let json = json!({
        "contour_um": contour_json(&figures.tip),
        "expected_contour_um": expected.as_ref().map(print::expectation_json),
        "expected_orientation_urad": print::expected_orientation_json(expected.as_ref()),
        "orientation_urad": orientation_json(figures.orientation.as_ref()),
        "tracking_um": tracking_json(reference, &actual)?,
        "left_out": terms.as_ref().map(print::position_terms_json),
    });
    Ok(Run {
        errors_mm: errors_mm(input.desired(), &actual)?,
        log: Recorded::new(input.name(), reference.clone(), actual)?,
        report: Report::new(json, printer),
    })
}
