//! `excite`: motions that teach a machine's axes.

use datasets::{ExcitationPlan, excite as plan_runs};
use motion::Trajectory;
use pipeline::excitation::{Style, control_test, in_program_words, next_excitation, program, record as record_runs, travel};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::{OrRaise, UsageError};
use crate::excitation::{Excitation, ExcitationRun};
use crate::log::Log;
use crate::machine::spec;
use crate::model::Model;
use crate::options::{self, ExciteOptions};
use crate::path;
use crate::progress::{self, Failure};

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
        Ok(record_runs(&machine, options.seconds, options.region.travel, seed)?)
    })?;
    Ok(logs.into_iter().map(Log::from).collect())
}
