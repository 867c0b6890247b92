//! Tracking and contour error of recorded runs.

use datasets::{Log as Recorded, Purpose, ReadOptions, assess};
use machine::MachineSpec;
use models::Bundle;
use pipeline::{Input, Setup, machine_of};
use precomp::output::{Printer, Refusal};
use precomp::print::measurement as print;
use precomp::read::Source;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::{Error, OrRaise, UsageError};
use crate::machine::{setup, spec};
use crate::options::{self, MeasureOptions};
use crate::progress::{self, Failure};
use crate::report::Report;
use crate::{json as objects, log, path};

/// What was measured of a run.
#[pyclass(frozen, module = "precomp")]
pub struct Measurement(Report);

#[pymethods]
impl Measurement {
    /// The figures that the command writes by `--json`.
    #[getter]
    fn figures<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        objects::object(py, &self.0.figures)
    }

    /// What the command prints.
    #[getter]
    fn report(&self) -> String {
        self.0.text()
    }

    /// The lines of the report that warn, or say what is not known.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.0.warnings()
    }
}

/// A log that is fit for measuring, and what was found in it.
pub fn log_to_measure(log: &Bound<'_, PyAny>, options: &ReadOptions) -> PyResult<(Recorded, Vec<String>)> {
    let (log, mut report) = log::run(log, 0, options)?;
    report.extend(assess(&log, Purpose::Measuring));
    let findings: Vec<String> = report.findings.iter().map(ToString::to_string).collect();
    if report.is_refused() {
        return Err(Error::new_err(format!("{}: {} is not fit for measuring", findings.join("\n"), log.name)));
    }
    Ok((log, findings))
}

/// Measures a run, as the command `measure` does. The machine is the model's where none is given.
pub fn measure(
    py: Python<'_>,
    log: &Bound<'_, PyAny>,
    desired: Option<&Bound<'_, PyAny>>,
    machine: Option<&Bound<'_, PyAny>>,
    model: Option<&Bundle>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<Measurement> {
    let options: MeasureOptions = options::read(options)?;
    if options.readback && desired.is_none() {
        return Err(UsageError::new_err("readback needs desired: the program that ran"));
    }
    let (log, findings) = log_to_measure(log, &options.columns.options())?;
    let machine: Option<MachineSpec> = match (machine, model) {
        (Some(machine), _) => Some(spec(machine)?),
        (None, Some(model)) => Some(machine_of(model).or_raise()?),
        (None, None) => None,
    };
    let setup = machine.as_ref().map(setup).transpose()?;
    let desired = desired.map(|desired| desired_source(desired, setup.as_ref(), &log)).transpose()?;
    progress::run(py, None, &Failure::default(), move |_| {
        let printer = Printer::keeping();
        findings.iter().for_each(|finding| printer.line(finding));
        let input = input(desired, &log, setup, &options, &printer)?;
        measured(&log, &input, model, &options, printer)
    })
}

/// The path that was desired. Without a machine an array has the axes and the period of the log; what is no reference is refused later.
fn desired_source(desired: &Bound<'_, PyAny>, setup: Option<&Setup>, log: &Recorded) -> PyResult<Source> {
    match setup {
        Some(setup) => path::source(desired, setup.period_s, setup.kinematics.axes()),
        None => path::source(desired, log.period_s(), log.axes()),
    }
}

fn input(
    desired: Option<Source>,
    log: &Recorded,
    setup: Option<Setup>,
    options: &MeasureOptions,
    printer: &Printer,
) -> anyhow::Result<Input> {
    let Some(source) = desired else {
        return Ok(Input::reference("command", log.reference.clone(), setup.as_ref())?);
    };
    let input = match (source.into_reference(), setup) {
        (Ok(reference), setup) => Input::reference("desired", reference, setup.as_ref())?,
        (Err(source), Some(setup)) => {
            printer.line(format!("desired is planned for the machine `{}`", setup.name));
            // Planned at the log's own rate, so that samples pair up.
            let setup = Setup { period_s: log.period_s(), ..setup };
            source.on(&setup, &options.program.settings(), options.program.feed)?
        }
        (Err(_), None) => return Err(precomp::read::machine_wanted("desired has to be planned for a machine")),
    };
    input
        .trajectory()
        .check_axes(log.axes())
        .map_err(|error| Refusal(format!("path and log: {error}; give the machine that has the log's axes with --machine")))?;
    Ok(input)
}

fn measured(
    log: &Recorded,
    desired: &Input,
    model: Option<&Bundle>,
    options: &MeasureOptions,
    printer: Printer,
) -> anyhow::Result<Measurement> {
    use pipeline::measure;
    let (log, cut_s) = measure::without_approach(log, desired.desired())?;
    if cut_s[0] + cut_s[1] > 0.0 {
        printer.line(format!("the way to the path and from it was left out: {:.3} s and {:.3} s", cut_s[0], cut_s[1]));
    }
    if options.readback {
        let (found, _) = measure::readback(&log, desired, options.estimator.estimator().as_mut())?;
        print::show_readback(&printer, &found);
        return Ok(Measurement(Report::new(print::readback_json(&found), printer)));
    }
    let found = measure::measure(&log, desired, options.estimator.estimator().as_mut())?;
    print::show(&printer, &found, desired.name() != "command");
    let mut figures = print::json(&found);
    if let Some(model) = model {
        let fits = measure::fits(model, &log)?;
        print::show_fits(&printer, &fits);
        figures["model"] = print::fits_json(&fits);
    }
    Ok(Measurement(Report::new(figures, printer)))
}
