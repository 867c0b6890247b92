//! What the commands read: part programs, references, built-in curves, machines and models.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, Result};
use datasets::formats::{Json, NumpyArray};
use datasets::{Inspection, Log, LogFormat, LongFile, Purpose, ReadOptions, Report, assess, inspect, read_log, read_runs};
use gcode::{Dialect, Program};
use machine::{ControllerSpec, MachineSpec};
use models::Bundle;
use motion::Trajectory;
use motion::curves::library;
use pipeline::part::Subprograms;
use pipeline::training::check_machine;
use pipeline::windows::LongProgram;
use pipeline::{Input, Part, ReadSettings, Setup, machine_of, travel};
use training::Recipe;

use crate::kind::Kind;
use crate::output::{Printer, Refusal, Usage, read_file, read_file_up_to};
use crate::same_file::note_called;

/// The prefix of built-in test curves.
pub const CURVE: &str = "curve:";

/// The prefix of machines drawn at random, before their seed.
const RANDOM: &str = "random:";

/// The content of an input, before the machine is known.
#[derive(Debug)]
pub struct Source {
    name: String,
    content: Content,
}

#[derive(Debug)]
enum Content {
    Curve,
    Reference(Trajectory),
    Program { program: Arc<Program>, folder: PathBuf },
}

impl Source {
    /// Opens `input`: `curve:NAME`, a reference (`.csv`, `.parquet`), or else a part program.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn open(input: &Path) -> Result<Self> {
        if let Some(name) = input.to_string_lossy().strip_prefix(CURVE) {
            return Ok(Self { name: name.to_owned(), content: Content::Curve });
        }
        let name = input.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let content = if is_reference(input) {
            if !input.is_file() {
                return Err(Usage(format!("cannot read {}: there is no such file", input.display())).into());
            }
            let (reference, _) =
                datasets::read_reference(input, &ReadOptions::default()).map_err(|error| Refusal(error.to_string()))?;
            Content::Reference(reference)
        } else {
            let bytes = read_file(input)?;
            if bytes.starts_with(datasets::formats::ARCHIVE) {
                let why =
                    format!("{} is an archive, as models are, and no part program; a model goes behind -m", input.display());
                return Err(Usage(why).into());
            }
            if Json.recognises(&bytes) || NumpyArray.recognises(&bytes) {
                let why =
                    format!("{} holds samples, and no part program; references are read as CSV or Parquet", input.display());
                return Err(Usage(why).into());
            }
            let folder = input.parent().map(Path::to_path_buf).unwrap_or_default();
            Content::Program { program: Arc::new(gcode::parse(bytes)), folder }
        };
        Ok(Self { name, content })
    }

    /// A reference of this name.
    #[must_use]
    pub fn of_reference(name: impl Into<String>, reference: Trajectory) -> Self {
        Self { name: name.into(), content: Content::Reference(reference) }
    }

    /// A part program of this name, with subprograms in `folder`.
    #[must_use]
    pub fn of_program(name: impl Into<String>, bytes: impl Into<Vec<u8>>, folder: PathBuf) -> Self {
        Self { name: name.into(), content: Content::Program { program: Arc::new(gcode::parse(bytes)), folder } }
    }

    /// The path on a machine; built-in curves at `feed_mm_s`.
    ///
    /// # Errors
    /// When the content is refused, or the machine cannot run it.
    pub fn on(self, setup: &Setup, settings: &ReadSettings, feed_mm_s: f64) -> Result<Input> {
        let Self { name, content } = self;
        let input = match content {
            Content::Curve => curve(&name, feed_mm_s, setup)?,
            Content::Reference(reference) => Input::reference(name, reference, Some(setup))?,
            Content::Program { program, folder } => {
                let dialect = dialect_of(&name, &program, setup, settings);
                let settings = ReadSettings { dialect, subprograms: beside(folder), ..settings.clone() };
                Part::of(&name, Arc::unwrap_or_clone(program), setup, &settings)?.into()
            }
        };
        travel::check(&input, setup)?;
        Ok(input)
    }

    /// The program, where it is long enough for windows.
    ///
    /// # Errors
    /// When the program is refused.
    pub fn long(&self, setup: &Setup, settings: &ReadSettings) -> Result<Option<LongProgram>> {
        let Content::Program { program, .. } = &self.content else { return Ok(None) };
        let settings = ReadSettings { dialect: dialect_of(&self.name, program, setup, settings), ..settings.clone() };
        Ok(LongProgram::new(&self.name, program, setup, &settings)?)
    }

    /// The reference, where the content is one: it needs no planning.
    ///
    /// # Errors
    /// Gives back a program or curve.
    pub fn into_reference(self) -> Result<Trajectory, Self> {
        match self.content {
            Content::Reference(reference) => Ok(reference),
            content => Err(Self { content, ..self }),
        }
    }
}

/// The dialect that an option states, or the name of the file where the setup has none.
fn dialect_of(name: &str, program: &Program, setup: &Setup, settings: &ReadSettings) -> Option<Dialect> {
    let of_name = || dialect_of_name(name).filter(|dialect| !dialect.is_ruled_out(program));
    settings.dialect.or_else(|| if setup.dialect.is_none() { of_name() } else { None })
}

/// The dialect of programs whose files end like this: main programs and subprograms of SINUMERIK.
fn dialect_of_name(name: &str) -> Option<Dialect> {
    let ending = Path::new(name).extension()?;
    ["mpf", "spf"].iter().any(|known| ending.eq_ignore_ascii_case(known)).then_some(Dialect::Sinumerik)
}

/// Subprograms in the files of a folder.
fn beside(folder: PathBuf) -> Subprograms {
    Subprograms::new(move |name| {
        // A name of a program is no path to elsewhere.
        let is_plain = Path::new(name).file_name().is_some_and(|file| file == name);
        let path = is_plain.then(|| folder.join(name))?;
        let content = std::fs::read(&path).ok()?;
        note_called(&path);
        Some(content)
    })
}

/// Reads `input`, as [`Source::open`] does, as a path of a machine; built-in curves at `feed_mm_s`.
///
/// # Errors
/// When the file cannot be read, or its content is refused.
pub fn input(input: &Path, setup: &Setup, settings: &ReadSettings, feed_mm_s: f64) -> Result<Input> {
    Source::open(input)?.on(setup, settings, feed_mm_s)
}

/// The built-in test curve `name`, at `feed_mm_s`.
///
/// # Errors
/// When there is no such curve, or the machine cannot run it.
pub fn curve(name: &str, feed_mm_s: f64, setup: &Setup) -> Result<Input> {
    library::by_name(name).map_err(|error| Usage(error.to_string()))?;
    Ok(Input::curve(name, feed_mm_s, setup)?)
}

/// Whether a file is a reference or log rather than a program, by its ending.
#[must_use]
pub fn is_reference(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ["csv", "parquet"].iter().any(|known| ending.eq_ignore_ascii_case(known)))
}

/// The machine called or described by `machine`: a built-in name, `random:SEED`, or a TOML file.
///
/// # Errors
/// When there is no such machine, or its description is not sound.
pub fn machine(machine: &str) -> Result<MachineSpec> {
    if let Some(seed) = machine.strip_prefix(RANDOM) {
        let seed =
            seed.parse().map_err(|_| Usage(format!("`{machine}`: a random machine has a whole number, as in {RANDOM}7")))?;
        return Ok(MachineSpec::random(seed)?);
    }
    let names = machine::BUILTIN_MACHINES.map(|(name, _)| name);
    described("machine", machine, &names, MachineSpec::builtin, MachineSpec::from_toml)
}

/// The machine of real data: the one `named`, else that of the model; with its name and origin as text. `None` where neither is given: no
/// built-in machine replaces a real one.
///
/// # Errors
/// When there is no such machine, or its description is not sound.
pub fn real_machine(named: Option<&str>, model: Option<(&Path, &Bundle)>) -> Result<Option<(MachineSpec, String)>> {
    let (spec, from) = match (named, model) {
        (Some(named), model) => {
            let spec = machine(named)?;
            model.map_or(Ok(()), |(_, bundle)| check_machine(bundle, &spec))?;
            (spec, format!("--machine {named}"))
        }
        (None, Some((path, bundle))) => (machine_of(bundle)?, format!("the model {}", path.display())),
        (None, None) => return Ok(None),
    };
    let line = format!("machine `{}`, from {from}", spec.name);
    Ok(Some((spec, line)))
}

/// The error where a machine is needed and none is given.
#[must_use]
pub fn machine_wanted(what: &str) -> anyhow::Error {
    Usage(format!("{what}: give --machine M.toml, or --model with a model of the machine that made the log")).into()
}

/// The controller profile called or described by `controller`: a built-in name or a TOML file.
///
/// # Errors
/// When there is no such profile, or it is not sound.
pub fn controller(controller: &str) -> Result<ControllerSpec> {
    let names = machine::BUILTIN_CONTROLLERS.map(|(name, _)| name);
    described("controller", controller, &names, ControllerSpec::builtin, ControllerSpec::from_toml)
}

/// The recipe called or described by `predictor`: a built-in name or a TOML file.
///
/// # Errors
/// When there is no such recipe, or it cannot be used.
pub fn recipe(predictor: &str) -> Result<Recipe> {
    let names: Vec<&str> = Recipe::names().collect();
    described("recipe", predictor, &names, Recipe::builtin, Recipe::from_toml)
}

/// The `kind` of thing that `name` calls, one of the built-in `names`, or describes, a TOML file.
fn described<T, E: std::error::Error + Send + Sync + 'static>(
    kind: &str,
    name: &str,
    names: &[&str],
    builtin: impl FnOnce(&str) -> Result<T, E>,
    from_toml: impl FnOnce(&str) -> Result<T, E>,
) -> Result<T> {
    if names.contains(&name) {
        return Ok(builtin(name)?);
    }
    if !Path::new(name).is_file() {
        let known = names.join(", ");
        return Err(Usage(format!("there is no {kind} file {name}, and the built-in ones are {known}")).into());
    }
    if let Some(other) = Kind::of(Path::new(name)).filter(|of| *of != Kind::Toml) {
        let what = other.what();
        let remedy = if other == Kind::Model { "; a model is given with -m" } else { "" };
        return Err(
            Usage(format!("{name}: by its name this is {what}, and a {kind} is described in a .toml file{remedy}")).into()
        );
    }
    let text = std::fs::read_to_string(name).with_context(|| format!("cannot read {name}"))?;
    from_toml(&text).map_err(|error| Refusal(format!("{name}: {error}")).into())
}

/// A log that is one run, and what reading it found.
///
/// # Errors
/// When the file cannot be read or is not a log.
pub fn log(path: &Path, options: &ReadOptions) -> Result<(Log, Report)> {
    check_exists(path)?;
    read_log(path, options).map_err(|error| Refusal(error.to_string()).into())
}

/// The runs of a log, cut at the gaps of its time stamps, and what reading it found.
///
/// # Errors
/// As [`log`].
pub fn runs(path: &Path, options: &ReadOptions) -> Result<(Vec<Log>, Report)> {
    check_exists(path)?;
    read_runs(path, options).map_err(|error| Refusal(error.to_string()).into())
}

fn check_exists(path: &Path) -> Result<()> {
    let why = match Kind::of(path).filter(|kind| !matches!(kind, Kind::Table | Kind::Figures | Kind::Settings)) {
        _ if path.is_dir() => "it is a folder; name the logs in it, as in FOLDER/*.csv".to_owned(),
        Some(kind) if path.is_file() => {
            let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
            format!(".{ending} is {}, and no log; a log holds commanded and actual positions", kind.what())
        }
        _ if path.is_file() => return Ok(()),
        _ => "there is no such file".to_owned(),
    };
    Err(Usage(format!("cannot read {}: {why}", path.display())).into())
}

/// A log with what its columns are taken for.
///
/// # Errors
/// As [`log`].
pub fn inspection(path: &Path, options: &ReadOptions) -> Result<Inspection> {
    check_exists(path)?;
    inspect(path, options).map_err(|error| Refusal(error.to_string()).into())
}

/// A log that is fit for measuring a run; what was found in it is printed.
///
/// # Errors
/// As [`log`], and when the log is not fit.
pub fn log_to_measure(path: &Path, options: &ReadOptions, printer: &Printer) -> Result<Log> {
    let (log, mut report) = log(path, options)?;
    report.extend(assess(&log, Purpose::Measuring));
    fit_to_measure(path, &report, printer)?;
    Ok(log)
}

/// The runs of a log that are fit for measuring; what was found in them is printed.
///
/// # Errors
/// As [`log`], and when a run is not fit.
pub fn runs_to_measure(path: &Path, options: &ReadOptions, printer: &Printer) -> Result<Vec<Log>> {
    let (logs, mut report) = runs(path, options)?;
    for log in &logs {
        let mut own = assess(log, Purpose::Measuring);
        if logs.len() > 1 {
            own.findings.iter_mut().for_each(|finding| finding.place.run = Some(log.name.clone()));
        }
        report.extend(own);
    }
    fit_to_measure(path, &report, printer)?;
    Ok(logs)
}

/// Prints what was found in a log.
///
/// # Errors
/// When the log is not fit for measuring.
pub fn fit_to_measure(path: &Path, report: &Report, printer: &Printer) -> Result<()> {
    for finding in &report.findings {
        printer.line(finding);
    }
    if report.is_refused() {
        return Err(Refusal(format!("{} is not fit for measuring", path.display())).into());
    }
    Ok(())
}

/// Number of samples above which a log or reference is read in pieces: some 50 MB of positions, and 300 MB of what is computed from them.
const LONG_SAMPLES: usize = 500_000;

/// The log, where it is to be read in pieces.
///
/// # Errors
/// As [`log`].
pub fn long_log(path: &Path, options: &ReadOptions) -> Result<Option<LongFile>> {
    if !path.is_file() {
        return Ok(None);
    }
    LongFile::log(path, options, LONG_SAMPLES).map_err(|error| Refusal(error.to_string()).into())
}

/// The reference, where it is to be read in pieces.
///
/// # Errors
/// When the file cannot be read or is not a reference.
pub fn long_reference(path: &Path) -> Result<Option<LongFile>> {
    if !is_reference(path) || !path.is_file() {
        return Ok(None);
    }
    LongFile::reference(path, &ReadOptions::default(), LONG_SAMPLES).map_err(|error| Refusal(error.to_string()).into())
}

/// The model in a bundle file.
///
/// # Errors
/// When the file cannot be read, is damaged, or of another format.
pub fn model(path: &Path) -> Result<Bundle> {
    let bytes = read_file_up_to(path, models::LARGEST_BYTES)?;
    Bundle::from_bytes(&bytes).map_err(|error| {
        let path = path.display();
        let is_text = bytes.iter().take(512).all(|byte| !byte.is_ascii_control() || byte.is_ascii_whitespace());
        Refusal(if is_text {
            format!("{path} is a text and not a model: `precomp train` writes models")
        } else {
            format!("{path}: {error}")
        })
        .into()
    })
}
