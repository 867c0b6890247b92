//! Keyword arguments as options of the command line, with its names, ranges and texts.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::error::ErrorKind;
use clap::{Arg, ArgAction, Args, CommandFactory, Parser};
use compensation::CorrectionLimits;
use pipeline::model_based_ilc::Settings;
use pipeline::training::MOST_SAMPLES;
use precomp::args::{LawArg, LogArgs, OutputArgs, ProgramArgs};
use precomp::{Effort, EstimatorName, FeatureName, FeedArgs, RegionArgs, SensorName, numbers};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyList, PyString, PyTuple};

use crate::errors::UsageError;

/// A command line of options alone.
#[derive(Debug, Parser)]
#[command(no_binary_name = true, disable_help_flag = true)]
struct Line<O: Args> {
    #[command(flatten)]
    options: O,
}

/// The options that keyword arguments state: `max_shift=0.2` is `--max-shift 0.2`. `None` states nothing.
///
/// # Errors
/// A `TypeError` for a name that is no option; [`UsageError`] for a value that the command line refuses.
pub fn read<O: Args>(given: Option<&Bound<'_, PyDict>>) -> PyResult<O> {
    let command = Line::<O>::command();
    let mut words = Vec::new();
    for (key, value) in given.into_iter().flat_map(|given| given.iter()) {
        let key: String = key.extract()?;
        let name = key.replace('_', "-");
        let Some(argument) = command.get_arguments().find(|argument| argument.get_long() == Some(&name)) else {
            return Err(PyTypeError::new_err(format!("unexpected keyword argument `{key}`")));
        };
        push(argument, &name, &value, &mut words)?;
    }
    Line::<O>::try_parse_from(words).map(|line| line.options).map_err(|error| refused(&error))
}

/// The error of the command line without its hints at `--help`.
fn refused(error: &clap::Error) -> PyErr {
    let text = error.to_string();
    let text = text.strip_prefix("error: ").unwrap_or(&text);
    let end = ["\n\nUsage", "\n\nFor more"].iter().filter_map(|hint| text.find(hint)).min().unwrap_or(text.len());
    let text = text[..end].trim_end().to_owned();
    if error.kind() == ErrorKind::UnknownArgument { PyTypeError::new_err(text) } else { UsageError::new_err(text) }
}

/// Appends what states `value`.
fn push(argument: &Arg, name: &str, value: &Bound<'_, PyAny>, words: &mut Vec<OsString>) -> PyResult<()> {
    if value.is_none() {
        return Ok(());
    }
    if matches!(argument.get_action(), ArgAction::SetTrue) {
        if value.extract::<bool>()? {
            words.push(format!("--{name}").into());
        }
        return Ok(());
    }
    let values = if let Ok(entries) = value.cast::<PyDict>() {
        let entry = |(key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>)| -> PyResult<String> {
            Ok(format!("{}={}", key.str()?, text(&value)?))
        };
        entries.iter().map(entry).collect::<PyResult<Vec<_>>>()?
    } else if is_list(value) && value.get_item(0).is_ok_and(|first| first.is_instance_of::<PyString>()) {
        value.try_iter()?.map(|one| text(&one?)).collect::<PyResult<_>>()?
    } else {
        vec![text(value)?]
    };
    let many = matches!(argument.get_action(), ArgAction::Append);
    let values = if many { values } else { vec![values.join(",")] };
    words.extend(values.into_iter().map(|value| format!("--{name}={value}").into()));
    Ok(())
}

fn is_list(value: &Bound<'_, PyAny>) -> bool {
    value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>()
}

/// A value as on the command line: numbers of a list with commas between them, `on` and `off` for a switch.
fn text(value: &Bound<'_, PyAny>) -> PyResult<String> {
    if let Ok(switch) = value.cast::<PyBool>() {
        return Ok(if switch.is_true() { "on" } else { "off" }.to_owned());
    }
    if is_list(value) {
        let all = value.try_iter()?.map(|one| text(&one?)).collect::<PyResult<Vec<_>>>()?;
        return Ok(all.join(","));
    }
    Ok(value.str()?.to_cow()?.into_owned())
}

/// Options of `Model.predict`.
#[derive(Debug, Args)]
pub struct PredictOptions {
    #[command(flatten)]
    pub program: ProgramArgs,
}

/// Options of `Model.compensate`.
#[derive(Debug, Args)]
pub struct CompensateOptions {
    #[command(flatten)]
    pub program: ProgramArgs,
    #[command(flatten)]
    pub output: OutputArgs,
    #[command(flatten)]
    pub columns: LogArgs,
    #[arg(long, value_enum, default_value = "model-based")]
    pub law: LawArg,
    #[arg(long, value_enum, default_value = "normal")]
    effort: Effort,
    #[arg(long, value_parser = numbers::iterations, conflicts_with = "effort")]
    iterations: Option<usize>,
    #[arg(long, value_parser = numbers::not_negative)]
    max_shift: Option<f64>,
    #[arg(long, default_value_t = CorrectionLimits::MAX_ROTATION_DEG, value_parser = numbers::not_negative)]
    max_rotation: f64,
    #[arg(long)]
    pub strict: bool,
    #[arg(long, value_parser = numbers::not_negative)]
    cycle_limit: Option<f64>,
    #[arg(long)]
    keep_stops: bool,
    #[command(flatten)]
    pub feeds: FeedArgs,
}

impl CompensateOptions {
    /// Settings of learning.
    pub fn settings(&self) -> Settings {
        Settings {
            law: self.law.into(),
            iterations: self.iterations.unwrap_or(self.effort.updates()),
            worth: self.effort.worth(),
            tries_larger_limit: self.effort.tries_larger_limit(),
            max_shift: self.max_shift,
            max_rotation_rad: self.max_rotation.to_radians(),
            slow_stops: !self.keep_stops,
            ..self.output.learning(self.cycle_limit)
        }
    }
}

/// Options of `train`.
#[derive(Debug, Args)]
pub struct TrainOptions {
    #[command(flatten)]
    pub columns: LogArgs,
    #[arg(long, default_value = "staged")]
    pub predictor: String,
    #[arg(long, value_enum, default_value_t = FeatureName::Iii)]
    pub features: FeatureName,
    #[arg(long, default_value_t = 0.2, value_parser = numbers::held_out)]
    pub held_out: f64,
    #[arg(long, default_value_t = MOST_SAMPLES, value_parser = numbers::samples)]
    pub most_samples: usize,
    #[arg(long)]
    pub checkpoints: Option<PathBuf>,
}

/// Options of `Model.adapt` and `Log.read`.
#[derive(Debug, Args)]
pub struct LogOptions {
    #[command(flatten)]
    pub columns: LogArgs,
}

/// Options of a simulated machine.
#[derive(Debug, Clone, Copy, Args)]
pub struct SimulationOptions {
    #[arg(long, value_enum)]
    sensor: Option<SensorName>,
    #[arg(long, default_value_t = 1.0, value_parser = numbers::noise)]
    noise: f64,
}

impl From<SimulationOptions> for machine::SimulationOptions {
    fn from(options: SimulationOptions) -> Self {
        Self { sensor: options.sensor.map(Into::into), noise_scale: options.noise, ..Self::default() }
    }
}

/// Options of `simulate`.
#[derive(Debug, Args)]
pub struct SimulateOptions {
    #[command(flatten)]
    pub program: ProgramArgs,
    #[command(flatten)]
    pub simulation: SimulationOptions,
}

/// Options of `measure`.
#[derive(Debug, Args)]
pub struct MeasureOptions {
    #[command(flatten)]
    pub program: ProgramArgs,
    #[command(flatten)]
    pub columns: LogArgs,
    #[arg(long, value_enum, default_value_t = EstimatorName::Exact)]
    pub estimator: EstimatorName,
    #[arg(long)]
    pub readback: bool,
}

/// Options of `excite`.
#[derive(Debug, Args)]
pub struct ExciteOptions {
    #[command(flatten)]
    pub output: OutputArgs,
    #[arg(long, default_value_t = 60.0, value_parser = numbers::excitation_s)]
    pub seconds: f64,
    #[command(flatten)]
    pub region: RegionArgs,
    #[command(flatten)]
    pub program: ProgramArgs,
}

/// Options of `compare`.
#[derive(Debug, Args)]
pub struct CompareOptions {
    #[command(flatten)]
    pub program: ProgramArgs,
    #[command(flatten)]
    pub simulation: SimulationOptions,
    #[arg(long, default_value_t = 1, value_parser = numbers::count)]
    pub seeds: u64,
    #[arg(long, default_value_t = 8, value_parser = numbers::iterations)]
    pub runs: usize,
    #[arg(long, value_parser = numbers::gain)]
    pub gain: Option<f64>,
    #[arg(long, value_parser = numbers::low_pass_hz)]
    pub low_pass: Option<f64>,
    #[arg(long, value_enum, default_value = "model-based")]
    pub law: LawArg,
    #[arg(long, default_value_t = 4, value_parser = numbers::iterations)]
    pub iterations: usize,
    #[arg(long)]
    pub programs: bool,
}

/// Options of `learn`.
#[derive(Debug, Args)]
pub struct LearnOptions {
    #[command(flatten)]
    pub program: ProgramArgs,
    #[arg(long, default_value_t = 8, value_parser = numbers::iterations)]
    pub runs: usize,
    #[arg(long, value_parser = numbers::not_negative)]
    pub max_shift: Option<f64>,
    #[arg(long, default_value_t = CorrectionLimits::MAX_ROTATION_DEG, value_parser = numbers::not_negative)]
    pub max_rotation: f64,
}
