//! `compare`: every method on the same unseen paths.

use machine::{Machine, MachineSpec};
use pipeline::compare::{CompareSettings, OwnMachine, Plant, compare as run, compare_programs};
use pipeline::model_based_ilc::Settings;
use pipeline::{Input, Setup};
use precomp::output::Printer;
use precomp::print::comparison as print;
use precomp::read::{CURVE, Source};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyString, PyTuple};

use crate::errors::OrRaise;
use crate::machine::{PythonMachine, SimulatedMachine, setup, spec, spec_of};
use crate::model::Model;
use crate::options::{self, CompareOptions};
use crate::progress::{self, Failure};
use crate::report::Report;
use crate::{json as objects, path, tables};

/// What a comparison came to.
#[pyclass(frozen, module = "precomp")]
pub struct Comparison(Report);

#[pymethods]
impl Comparison {
    /// The figures that the command writes by `--json`.
    #[getter]
    fn figures<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        objects::object(py, &self.0.figures)
    }

    /// The tables that the command prints.
    #[getter]
    fn report(&self) -> String {
        self.0.text()
    }
}

/// The machine of a comparison.
enum Given<'py> {
    Simulated(MachineSpec),
    Learned(Bound<'py, Model>, MachineSpec),
    Own(Py<PyAny>, MachineSpec),
}

impl<'py> Given<'py> {
    fn of(machine: Option<&Bound<'py, PyAny>>, spec_given: Option<&Bound<'py, PyAny>>) -> PyResult<Self> {
        let Some(machine) = machine else { return Ok(Self::Simulated(MachineSpec::builtin("ballscrew").or_raise()?)) };
        if let Ok(model) = machine.cast::<Model>() {
            let spec = pipeline::machine_of(&model.get().bundle).or_raise()?;
            return Ok(Self::Learned(model.clone(), spec));
        }
        if let Ok(simulated) = machine.cast::<SimulatedMachine>() {
            return Ok(Self::Simulated(simulated.get().spec.clone()));
        }
        if tables::path(machine)?.is_some() || !machine.hasattr("run")? {
            return Ok(Self::Simulated(spec(machine)?));
        }
        Ok(Self::Own(machine.clone().unbind(), spec_of(machine, spec_given)?))
    }

    fn spec(&self) -> &MachineSpec {
        match self {
            Self::Simulated(spec) | Self::Learned(_, spec) | Self::Own(_, spec) => spec,
        }
    }
}

/// A machine written in Python, as comparisons make copies of it.
#[derive(Debug)]
struct Own {
    object: Py<PyAny>,
    setup: Setup,
    failure: Failure,
}

impl Own {
    /// `seeded(seed)` where the object has it, else a deep copy.
    fn copy(&self, seed: u64) -> PyResult<Py<PyAny>> {
        Python::attach(|py| {
            let object = self.object.bind(py);
            let copy = if object.hasattr("seeded")? {
                object.call_method1("seeded", (seed,))?
            } else {
                py.import("copy")?.call_method1("deepcopy", (object,))?
            };
            Ok(copy.unbind())
        })
    }
}

impl OwnMachine for Own {
    fn setup(&self) -> pipeline::Result<Setup> {
        Ok(self.setup.clone())
    }

    fn machine(&self, seed: u64) -> pipeline::Result<Box<dyn Machine>> {
        let object = self.copy(seed).map_err(|error| {
            let text = error.to_string();
            self.failure.set(error);
            machine::MachineError::Misfit(text)
        })?;
        Ok(Box::new(PythonMachine { object, failure: self.failure.clone() }))
    }
}

/// Compares first runs with iterative learning on a simulated or learned machine, or on one written in Python.
#[pyfunction]
#[pyo3(signature = (paths = None, *, machine = None, model = None, spec = None, seed = 1, progress = None, **options))]
#[allow(clippy::too_many_arguments)] // keyword arguments
pub fn compare(
    py: Python<'_>,
    paths: Option<&Bound<'_, PyAny>>,
    machine: Option<&Bound<'_, PyAny>>,
    model: Option<&Bound<'_, Model>>,
    spec: Option<&Bound<'_, PyAny>>,
    seed: u64,
    progress: Option<Py<PyAny>>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<Comparison> {
    let options: CompareOptions = options::read(options)?;
    let given = Given::of(machine, spec)?;
    let setup = setup(given.spec())?;
    let sources = sources(py, paths, &setup)?;
    let failure = Failure::default();
    let own = match &given {
        Given::Own(object, _) => Some(Own { object: object.clone_ref(py), setup: setup.clone(), failure: failure.clone() }),
        _ => None,
    };
    let learned = match &given {
        Given::Learned(model, _) => Some(&model.get().bundle),
        _ => None,
    };
    let (bundle, machine) = (model.map(|model| &model.get().bundle), given.spec());
    progress::run(py, progress, &failure, move |progress| {
        let plant = match (&own, learned) {
            (Some(own), _) => Plant::Own(own),
            (None, Some(bundle)) => Plant::Learned(bundle),
            (None, None) => Plant::Simulated(machine),
        };
        let input = |source: Source| source.on(&setup, &options.program.simulated(), options.program.feed);
        let paths: Vec<Input> = sources.into_iter().map(input).collect::<anyhow::Result<_>>()?;
        let settings = settings(&options, seed);
        let results = run(&paths, plant, bundle, &settings, progress)?;
        let printer = Printer::keeping();
        printer.line(print::render(&results, &settings));
        let mut figures = print::json(&results, &settings);
        if options.programs {
            let (programs, tuned) = compare_programs(paths, plant, bundle, &settings, &results.tuned, progress)?;
            printer.line(print::render_programs(&programs, &tuned, &settings));
            figures["programs"] = print::programs_json(&programs, &tuned, &settings);
        }
        Ok(Comparison(Report::new(figures, printer)))
    })
}

/// The paths that are given, one or a list, else the unseen curves.
fn sources(py: Python<'_>, paths: Option<&Bound<'_, PyAny>>, setup: &Setup) -> PyResult<Vec<Source>> {
    let source = |path: &Bound<'_, PyAny>| path::source(path, setup.period_s, setup.kinematics.axes());
    match paths {
        Some(paths) if paths.is_instance_of::<PyList>() || paths.is_instance_of::<PyTuple>() => {
            paths.try_iter()?.map(|one| source(&one?)).collect()
        }
        Some(path) => Ok(vec![source(path)?]),
        None => {
            let curves = precomp::unseen(setup).iter().map(|name| PyString::new(py, &format!("{CURVE}{name}")));
            curves.map(|curve| source(curve.as_any())).collect()
        }
    }
}

fn settings(options: &CompareOptions, seed: u64) -> CompareSettings {
    CompareSettings {
        seeds: options.seeds,
        ilc_runs: options.runs,
        ilc_gain: options.gain,
        ilc_low_pass_hz: options.low_pass,
        simulation: options.simulation.into(),
        learning: Settings { law: options.law.into(), iterations: options.iterations, ..Settings::default() },
        seed,
    }
}
