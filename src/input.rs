//! What the commands read: part programs, references, built-in curves, machines and models.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use anyhow::{Context, Result};
use datasets::{Log, Purpose, ReadOptions, Report, assess, read_log};
use gcode::{Dialect, Options, PassiveCodes, Program};
use machine::{AxisSpec, ControllerSpec, MachineSpec, ProgramDialect, ProgramWords, SimulatedMachine};
use models::Bundle;
use motion::curves::library;
use motion::{Cartesian, DesiredPath, Kinematics, Limits, PlanSettings, Trajectory, plan_curve_on};
use training::Recipe;

use crate::cli::{DialectName, LogArgs, ProgramArgs, Switch};
use crate::output::{Printer, Refusal, Usage, read_file};
use crate::pipeline::{Part, WorkOffsets};
use crate::travel;

/// The prefix of built-in test curves.
pub const CURVE: &str = "curve:";

/// The prefix of machines drawn at random, before their seed.
const RANDOM: &str = "random:";

/// A path to be run: its name and what it is.
#[derive(Debug)]
pub struct Input {
    /// Name for tables.
    pub name: String,
    /// What the part needs.
    pub desired: DesiredPath,
    /// The program that it was planned from.
    pub part: Option<Part>,
}

/// What a path is read from, before the machine that runs it is known.
#[derive(Debug)]
pub struct Source {
    name: String,
    content: Content,
}

#[derive(Debug)]
enum Content {
    Curve,
    Reference(Trajectory),
    Program(Program),
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
            Content::Program(gcode::parse(bytes))
        };
        Ok(Self { name, content })
    }

    /// The path on a machine.
    ///
    /// # Errors
    /// When the content is refused, or the machine cannot run it.
    pub fn on(self, frame: &Frame, args: &ProgramArgs) -> Result<Input> {
        let input = self.planned(frame, args)?;
        travel::check(&input, frame)?;
        Ok(input)
    }

    /// The reference that it is: a path already, which no machine has to plan.
    ///
    /// # Errors
    /// Gives back a program or curve.
    pub fn into_reference(self) -> Result<Trajectory, Self> {
        match self.content {
            Content::Reference(reference) => Ok(reference),
            content => Err(Self { content, ..self }),
        }
    }

    fn planned(self, frame: &Frame, args: &ProgramArgs) -> Result<Input> {
        let Self { name, content } = self;
        match content {
            Content::Curve => Input::curve(&name, args.feed, frame),
            Content::Reference(reference) => {
                let kinematics: Arc<dyn Kinematics> = if frame.kinematics.axes() == reference.axes() {
                    Arc::clone(&frame.kinematics)
                } else {
                    Arc::new(Cartesian::new(reference.axes().to_vec()))
                };
                Ok(Input { name, desired: DesiredPath::new(reference, kinematics)?, part: None })
            }
            Content::Program(program) => {
                let asked = args.dialect.map(|dialect| match dialect {
                    DialectName::Fanuc => Dialect::Fanuc,
                    DialectName::Linuxcnc => Dialect::LinuxCnc,
                });
                let options = options(&program, asked.or(frame.dialect), args);
                let settings = PlanSettings { corner_tolerance_mm: args.corner_tolerance, ..frame.plan_settings() };
                if frame.kinematics.turns() && args.tool_length != 0.0 {
                    return Err(Usage(
                        "--tool-length is for machines that do not turn tool or part; here the machine file says it (kinematics.tool_length_mm), \
                         as the positions of all axes go by it"
                            .to_owned(),
                    )
                    .into());
                }
                let given = WorkOffsets::new(&args.work_offset, &frame.work_offsets, args.tool_length);
                let offsets = if args.simulated { given.or_zero() } else { given };
                let part = Part::read(&name, program, Some(&options), &offsets, frame, &settings)?;
                Ok(Input { name, desired: part.plan.desired.clone(), part: Some(part) })
            }
        }
    }
}

/// How a program is read.
fn options(program: &gcode::Program, dialect: Option<Dialect>, args: &ProgramArgs) -> Options {
    let dialect = dialect.unwrap_or_else(|| Dialect::detect(program));
    let passive = args.passive.iter().fold(PassiveCodes::default(), |passive, number| passive.with(*number));
    Options { passive, block_delete: args.block_delete.map(|switch| switch == Switch::On), ..dialect.into() }
}

/// A machine's limits, kinematics and sampling, without its drives.
#[derive(Debug, Clone)]
pub struct Frame {
    /// How the axes place the tool.
    pub kinematics: Arc<dyn Kinematics>,
    /// What the words of a program mean while it does not say so itself.
    pub words: ProgramWords,
    /// What the axes and the path are allowed to do.
    pub limits: Limits,
    /// Sampling period, s.
    pub period_s: f64,
    /// How programs are planned, but for the sampling period.
    pub plan: PlanSettings,
    /// What its control's programs are written in, where its profile says so.
    pub dialect: Option<Dialect>,
    /// Lowest and highest position of every axis, mm or rad, where they are limited.
    pub travel: Vec<Option<[f64; 2]>>,
    /// Its work offsets by coordinate system, mm, where its description says so.
    pub work_offsets: BTreeMap<String, [f64; 3]>,
}

impl Frame {
    /// The frame of a machine description.
    ///
    /// # Errors
    /// When its axes cannot place a tool.
    pub fn of(spec: &MachineSpec) -> Result<Self> {
        let kinematics = spec.kinematics().map_err(|error| Refusal(error.to_string()))?;
        let words = spec.program_words();
        let dialect = spec.controller.and_then(|controller| controller.dialect).map(|dialect| match dialect {
            ProgramDialect::Fanuc => Dialect::Fanuc,
            ProgramDialect::LinuxCnc => Dialect::LinuxCnc,
        });
        Ok(Self {
            kinematics,
            words,
            limits: spec.limits(),
            period_s: spec.sampling_period_s(),
            plan: spec.plan_settings(),
            dialect,
            travel: spec.axes.iter().map(AxisSpec::travel).collect(),
            work_offsets: spec.work_offsets.clone(),
        })
    }

    /// How programs are planned.
    #[must_use]
    pub fn plan_settings(&self) -> PlanSettings {
        PlanSettings { period_s: self.period_s, ..self.plan.clone() }
    }
}

impl Input {
    /// Reads `input`, as [`Source::open`] does, as a path of a machine.
    ///
    /// # Errors
    /// When the file cannot be read, or its content is refused.
    pub fn read(input: &Path, frame: &Frame, args: &ProgramArgs) -> Result<Self> {
        Source::open(input)?.on(frame, args)
    }

    /// Largest difference of an axis's position from the path, mm or rad.
    #[must_use]
    pub fn largest_shift(&self, reference: &Trajectory) -> f64 {
        let columns = self.desired.trajectory().columns().iter().zip(reference.columns());
        columns.flat_map(|(d, r)| d.iter().zip(r).map(|(d, r)| (r - d).abs())).fold(0.0, f64::max)
    }

    /// The built-in test curve `name`, at `feed_mm_s`.
    ///
    /// # Errors
    /// When there is no such curve.
    pub fn curve(name: &str, feed_mm_s: f64, frame: &Frame) -> Result<Self> {
        let curve = library::by_name(name).map_err(|error| Usage(error.to_string()))?;
        let desired = plan_curve_on(curve, feed_mm_s, &frame.kinematics, &frame.limits, &frame.plan_settings())?;
        Ok(Self { name: name.to_owned(), desired, part: None })
    }
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

/// The machine that real data belongs to: the one `named`, else that of a model; and a line that says which one and from where. `None` where
/// neither is given: a built-in machine is no stand-in for a real one.
///
/// # Errors
/// When there is no such machine, or its description is not sound.
pub fn real_machine(named: Option<&str>, model: Option<(&Path, &Bundle)>) -> Result<Option<(MachineSpec, String)>> {
    let (spec, from) = match (named, model) {
        (Some(named), _) => (machine(named)?, format!("--machine {named}")),
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
    let text = std::fs::read_to_string(name).with_context(|| format!("cannot read {name}"))?;
    from_toml(&text).map_err(|error| Refusal(format!("{name}: {error}")).into())
}

/// The simulated machine of a description; refused where it has no drives.
///
/// # Errors
/// When an axis has no drive.
pub fn simulated(spec: &MachineSpec, seed: u64) -> Result<SimulatedMachine> {
    SimulatedMachine::new(spec, seed).map_err(|error| Refusal(error.to_string()).into())
}

/// A log, and what reading it found.
///
/// # Errors
/// When the file cannot be read or is not a log.
pub fn log(path: &Path, args: &LogArgs) -> Result<(Log, Report)> {
    if !path.is_file() {
        return Err(Usage(format!("cannot read {}: there is no such file", path.display())).into());
    }
    let options = ReadOptions { columns: args.columns.clone(), period_s: args.period.map(|ms| ms * 1e-3) };
    read_log(path, &options).map_err(|error| Refusal(error.to_string()).into())
}

/// A log that is fit for measuring a run; what was found in it is printed.
///
/// # Errors
/// As [`log`], and when the log is not fit.
pub fn log_to_measure(path: &Path, args: &LogArgs, printer: &Printer) -> Result<Log> {
    let (log, mut report) = log(path, args)?;
    report.extend(assess(&log, Purpose::Measuring));
    for finding in &report.findings {
        printer.line(finding);
    }
    if report.is_refused() {
        return Err(Refusal(format!("{} is not fit for measuring", path.display())).into());
    }
    Ok(log)
}

/// The model in a bundle file.
///
/// # Errors
/// When the file cannot be read, is damaged, or of another format.
pub fn model(path: &Path) -> Result<Bundle> {
    let bytes = read_file(path)?;
    Bundle::from_bytes(&bytes).map_err(|error| Refusal(format!("{}: {error}", path.display())).into())
}

/// The machine that a model was trained for.
///
/// # Errors
/// When the description in the bundle is not sound.
pub fn machine_of(bundle: &Bundle) -> Result<MachineSpec> {
    MachineSpec::from_toml(&bundle.manifest.machine_toml).map_err(|error| Refusal(format!("the model's machine: {error}")).into())
}
