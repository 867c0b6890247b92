//! `train`: from logs to a model.

use std::path::PathBuf;
use std::time::Instant;

use anyhow::Result;
use datasets::{Log, Severity};
use machine::MachineSpec;
use pipeline::Progress;
use pipeline::identification::{Identified, KnownRun, identify};
use pipeline::training::{self, TrainSettings};
use precomp::output::{Printer, Usage};
use precomp::print::{identification, training as print};
use precomp::read;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyString};
use serde_json::{Value, json};

use crate::errors::{OrRaise, UsageError};
use crate::frames;
use crate::machine::spec;
use crate::model::Model;
use crate::options::{self, TrainOptions};
use crate::progress::{self, Failure};
use crate::report::Report;

/// A program that ran while a log was recorded.
struct Known {
    name: String,
    program: Vec<u8>,
    log: Log,
}

/// Learns a machine from its logs, as the command `train` does.
#[pyfunction]
#[pyo3(signature = (frames, *, machine = None, programs = None, seed = 1, progress = None, **options))]
pub fn train(
    py: Python<'_>,
    frames: &Bound<'_, PyAny>,
    machine: Option<&Bound<'_, PyAny>>,
    programs: Option<&Bound<'_, PyAny>>,
    seed: u64,
    progress: Option<Py<PyAny>>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<Model> {
    let options: TrainOptions = options::read(options)?;
    let machine = machine.map(spec).transpose()?;
    let (logs, warnings) = frames::fit(frames::runs(frames, &options.columns.options())?)?;
    let known = programs.map_or(Ok(Vec::new()), |programs| known_programs(programs, &logs))?;
    let settings = TrainSettings {
        recipe: read::recipe(&options.predictor).or_raise()?.with_features(options.features.into()),
        held_out: options.held_out,
        most_samples: options.most_samples,
        seed,
        checkpoints: options.checkpoints,
    };
    progress::run(py, progress, &Failure::default(), move |progress| {
        trained(logs, warnings, &known, machine.as_ref(), &settings, progress)
    })
}

fn trained(
    logs: Vec<Log>,
    mut warnings: Vec<String>,
    known: &[Known],
    machine: Option<&MachineSpec>,
    settings: &TrainSettings,
    progress: Progress<'_>,
) -> Result<Model> {
    let (started, printer) = (Instant::now(), Printer::keeping());
    let (logs, joined) = datasets::joined(logs);
    warnings.extend(joined.iter().map(ToString::to_string));
    let found = training::check(&logs).findings;
    warnings.extend(found.iter().filter(|f| f.severity != Severity::Refuse).map(ToString::to_string));
    warnings.iter().for_each(|warning| printer.line(warning));
    let control = control(known, machine, progress)?;
    let identified_s = started.elapsed().as_secs_f64();
    if let Some(control) = &control {
        identification::show(&printer, control, identified_s);
    }
    let machine = control.as_ref().map(|control| &control.machine).or(machine);
    let today = precomp::date::today()?;
    let mut trained = training::train(&logs, machine, settings, progress)?;
    trained.bundle.manifest.date = Some(today);
    trained.bundle.manifest.control = control.as_ref().map(Identified::summary);
    let seconds = started.elapsed().as_secs_f64();
    printer.line(print::held_out(&trained.bundle));
    trained.notes.iter().for_each(|note| printer.line(note));
    printer.line(print::lags(&trained));
    print::coverage(&trained.bundle).iter().for_each(|line| printer.line(line));
    let doubts: Vec<String> = trained.doubts()?.iter().map(ToString::to_string).collect();
    doubts.iter().for_each(|doubt| printer.line(format!("warning: {doubt}")));
    warnings.extend(doubts);
    let mut figures = print::json(&trained, seconds);
    figures["warnings"] = json!(warnings);
    figures["control"] = control.as_ref().map_or(Value::Null, |control| identification::json(control, identified_s));
    Ok(Model { bundle: trained.bundle, report: Some(Report::new(figures, printer)) })
}

/// The control that ran the programs.
fn control(known: &[Known], machine: Option<&MachineSpec>, progress: Progress<'_>) -> Result<Option<Identified>> {
    if known.is_empty() {
        return Ok(None);
    }
    let runs: Vec<KnownRun<'_>> = known
        .iter()
        .map(|known| KnownRun { name: known.name.clone(), program: known.program.clone(), log: &known.log })
        .collect();
    Ok(Some(identify(&runs, machine, progress)?))
}

/// Every program with the log of its run: of a dictionary by the name of the log, of a list of files by their names.
fn known_programs(programs: &Bound<'_, PyAny>, logs: &[Log]) -> PyResult<Vec<Known>> {
    if let Ok(named) = programs.cast::<PyDict>() {
        let one = |(name, program): (Bound<'_, PyAny>, Bound<'_, PyAny>)| known_program(name.extract()?, &program, logs);
        return named.iter().map(one).collect();
    }
    let one = |program: PyResult<Bound<'_, PyAny>>| {
        let program = program?;
        let path: PathBuf = program.extract().map_err(|_| {
            UsageError::new_err("programs are a list of files, or a dictionary from the names of logs to programs")
        })?;
        let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        known_program(stem, &program, logs)
    };
    programs.try_iter()?.map(one).collect()
}

/// The program of the log called `name`: a file, or the text or bytes of a program.
fn known_program(name: String, program: &Bound<'_, PyAny>, logs: &[Log]) -> PyResult<Known> {
    let log = logs.iter().find(|log| log.name == name).ok_or_else(|| {
        let names: Vec<&str> = logs.iter().map(|log| log.name.as_str()).collect();
        let why = format!("no log is called {name}: the logs are {}", names.join(", "));
        UsageError::new_err(format!("{why}; give the log of the program's run the same name"))
    })?;
    let program = if let Ok(bytes) = program.cast::<PyBytes>() {
        bytes.as_bytes().to_vec()
    } else {
        let text = program.cast::<PyString>().map(|text| text.to_string_lossy().into_owned()).unwrap_or_default();
        if text.contains('\n') { text.into_bytes() } else { file(&program.extract()?).or_raise()? }
    };
    Ok(Known { program, log: log.clone(), name })
}

fn file(path: &PathBuf) -> Result<Vec<u8>> {
    std::fs::read(path).map_err(|error| Usage(format!("cannot read {}: {error}", path.display())).into())
}
