//! `precomp init`: a commented machine file.

use std::io::{BufRead, IsTerminal, Write};
use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Args;
use machine::{AxisSpec, Draft, Known, Missing, MissingValue};
use pipeline::training::limits_of_logs;
use serde_json::{Value, json};

use crate::args::{Common, LogArgs};
use crate::files::Files;
use crate::kind::Kind;
use crate::numbers::{self, Travel};
use crate::output::{Outputs, Usage, read_file};
use crate::read;
use crate::same_file::note_called;

/// Write a commented machine file, from the control's own settings, from logs, or from answers
///
/// What options state comes first, then the settings, then what the logs reached. On a terminal it asks for the rest.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  precomp init my-mill.ini -o mill.toml
  precomp init grbl-settings.txt --period 2 -o router.toml
  precomp init --log runs/*.csv -o mill.toml
  precomp init --axes xyz --velocity 250 --acceleration 1500 --period 2 --travel x=0..500 -o mill.toml")]
pub struct Init {
    /// Settings of the control: a LinuxCNC INI file, what Grbl prints for `$$`, or a Klipper printer.cfg
    settings: Option<PathBuf>,
    #[command(flatten)]
    common: Common,
    /// The machine file
    #[arg(short, long, value_name = "TOML")]
    out: PathBuf,
    /// Logs of the machine, for what nothing else says: sampling period, and the largest speeds and accelerations in them
    #[arg(long = "log", value_name = "LOG", num_args = 1..)]
    logs: Vec<PathBuf>,
    #[command(flatten)]
    columns: LogArgs,
    /// Name of the machine
    #[arg(long)]
    name: Option<String>,
    /// Its axes, as letters out of x y z a b c
    #[arg(long, value_parser = numbers::axes)]
    axes: Option<String>,
    /// Largest speed of every axis, mm/s, of rotary ones °/s
    #[arg(long, value_name = "MM_S", value_parser = numbers::speed)]
    velocity: Option<f64>,
    /// Largest acceleration of every axis, mm/s², of rotary ones °/s²
    #[arg(long, value_name = "MM_S2", value_parser = numbers::acceleration)]
    acceleration: Option<f64>,
    /// Travel of an axis, mm or degrees, for example x=-250..250
    #[arg(long, value_name = "AXIS=LOW..HIGH", value_parser = numbers::axis_travel)]
    travel: Vec<Travel>,
    /// Profile of the control: generic, linuxcnc, fanuc, siemens, grbl
    #[arg(long, value_name = "NAME")]
    controller: Option<String>,
}

impl Init {
    pub fn files(&self) -> Files {
        let files = Files::of(self.common.json.as_deref()).reads("SETTINGS", self.settings.as_deref());
        files.reads_logs("--log", &self.logs).writes("-o", &*self.out, Kind::Toml)
    }

    pub fn run(&self) -> Result<()> {
        let printer = self.common.printer();
        let mut draft = self.draft()?;
        self.complete_by_logs(&mut draft)?;
        let missing = draft.missing();
        if !missing.is_empty() && std::io::stdin().is_terminal() && std::io::stderr().is_terminal() {
            ask(&mut draft)?;
        } else if !missing.is_empty() {
            return Err(lacking(&missing).into());
        }
        let text = draft.to_toml()?;
        let mut outputs = Outputs::default();
        outputs.add(&self.out, text.into_bytes());
        printer.line(format!("machine file of {} in {}", axes_of(&draft), self.out.display()));
        draft.notes.iter().for_each(|note| printer.line(format!("note: {note}")));
        printer.line("look through it, then: precomp excite --machine FILE -o excitation");
        outputs.write(self.common.json.as_deref(), &figures(&draft))
    }

    /// What options and settings say.
    fn draft(&self) -> Result<Draft> {
        let mut draft = match &self.settings {
            Some(path) => {
                let name =
                    path.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned());
                let beside = |included: &str| {
                    let path = path.parent().unwrap_or(Path::new("")).join(included);
                    let content = read_file(&path).ok()?;
                    note_called(&path);
                    Some(String::from_utf8_lossy(&content).into_owned())
                };
                machine::draft(&name, &String::from_utf8_lossy(&read_file(path)?), &beside)?
            }
            None => Draft { name: "mill".into(), origin: "options and answers".into(), ..Draft::default() },
        };
        if let Some(name) = &self.name {
            draft.name.clone_from(name);
        }
        if let Some(controller) = &self.controller {
            read::controller(controller)?;
            draft.controller = Some(controller.clone());
        }
        if let (Some(settings), Some(axes)) = (&self.settings, &self.axes) {
            let why =
                format!("--axes {axes} beside {}: the axes are those of the settings, {}", settings.display(), axes_of(&draft));
            return Err(Usage(why).into());
        }
        for letter in self.axes.iter().flat_map(|axes| axes.chars()) {
            draft.axis(&letter.to_string());
        }
        if let Some(period_s) = self.columns.options().period_s {
            draft.period_ms = Some(Known::new(1e3 * period_s, "--period"));
        }
        for axis in &mut draft.axes {
            let stated = |value: Option<f64>, option: &str| value.map(|value| Known::new(value, option));
            axis.velocity = stated(self.velocity, "--velocity").or(axis.velocity.take());
            axis.acceleration = stated(self.acceleration, "--acceleration").or(axis.acceleration.take());
        }
        // What the settings say of the path follows from their axes.
        if self.acceleration.is_some() {
            (draft.path_acceleration_mm_s2, draft.centripetal_mm_s2, draft.arc_acceleration_mm_s2) = (None, None, None);
            draft.axes.iter_mut().for_each(|axis| axis.jerk = None);
        }
        for Travel { axis, range } in &self.travel {
            if !draft.axes.iter().any(|known| known.name == *axis) {
                return Err(Usage(format!("--travel names axis {axis}; the machine has {}", axes_of(&draft))).into());
            }
            draft.axis(axis).travel = Some(Known::new(*range, "--travel"));
        }
        Ok(draft)
    }

    /// Fills in what the logs reached.
    fn complete_by_logs(&self, draft: &mut Draft) -> Result<()> {
        let runs = self.logs.iter().map(|path| Ok(read::runs(path, &self.columns.options())?.0)).collect::<Result<Vec<_>>>()?;
        let logs = runs.concat();
        if logs.is_empty() {
            return Ok(());
        }
        let reached = limits_of_logs(&logs.iter().collect::<Vec<_>>())?;
        let source = "reached in the logs";
        draft.period_ms.get_or_insert(Known::new(reached.sampling_period_ms, "of the logs"));
        if draft.axes.is_empty() {
            draft.origin = "logs: the limits are what they reached, the machine may be able to do more".into();
            for axis in &reached.axes {
                draft.axis(axis.name());
            }
        }
        for axis in &reached.axes {
            let Some(known) = draft.axes.iter_mut().find(|known| known.name == axis.name()) else { continue };
            let [velocity, acceleration, jerk] = match axis {
                AxisSpec::Linear(axis) => [axis.velocity_mm_s, axis.acceleration_mm_s2, axis.jerk_mm_s3],
                AxisSpec::Rotary(axis) => [axis.velocity_rad_s, axis.acceleration_rad_s2, axis.jerk_rad_s3].map(f64::to_degrees),
            };
            known.velocity.get_or_insert(Known::new(velocity, source));
            if known.acceleration.is_none() {
                (known.acceleration, known.jerk) = (Some(Known::new(acceleration, source)), Some(Known::new(jerk, source)));
            }
        }
        Ok(())
    }
}

fn axes_of(draft: &Draft) -> String {
    draft.axes.iter().map(|axis| axis.name.as_str()).collect::<Vec<_>>().join(" ")
}

/// All that is missing, each with its option.
fn lacking(missing: &[Missing]) -> Usage {
    let option = |missing: &Missing| match missing.value {
        MissingValue::Axes => "--axes xyz",
        MissingValue::Period => "--period MS",
        MissingValue::Velocity => "--velocity MM_S",
        MissingValue::Acceleration => "--acceleration MM_S2",
    };
    let each: Vec<String> = missing.iter().map(|missing| format!("{} ({})", missing.what, option(missing))).collect();
    Usage(format!("not known: {}; state them, or give --log LOG", each.join("; ")))
}

/// Asks for what is missing.
fn ask(draft: &mut Draft) -> Result<()> {
    if draft.axes.is_empty() {
        let letters = answer("axes of the machine, for example xyz", &numbers::axes)?;
        for letter in letters.chars() {
            draft.axis(&letter.to_string());
        }
    }
    for missing in draft.missing() {
        let source = "as answered";
        match (missing.value, &missing.axis) {
            (MissingValue::Period, _) => {
                draft.period_ms = Some(Known::new(answer(&format!("{}, ms", missing.what), &numbers::period_ms)?, source));
            }
            (MissingValue::Velocity, Some(axis)) => {
                let value = answer(&format!("{}, mm/s (a rotary axis: °/s)", missing.what), &numbers::speed)?;
                draft.axis(axis).velocity = Some(Known::new(value, source));
            }
            (MissingValue::Acceleration, Some(axis)) => {
                let value = answer(&format!("{}, mm/s² (a rotary axis: °/s²)", missing.what), &numbers::acceleration)?;
                draft.axis(axis).acceleration = Some(Known::new(value, source));
            }
            _ => {}
        }
    }
    Ok(())
}

/// An answer that `read` takes; the question is repeated until there is one.
fn answer<T>(question: &str, read: &dyn Fn(&str) -> Result<T, String>) -> Result<T> {
    loop {
        write!(std::io::stderr(), "{question}: ")?;
        let mut line = String::new();
        if std::io::stdin().lock().read_line(&mut line)? == 0 {
            return Err(Usage("no answer; state the values as options".into()).into());
        }
        match read(line.trim()) {
            Ok(value) => return Ok(value),
            Err(why) => writeln!(std::io::stderr(), "{why}")?,
        }
    }
}

fn figures(draft: &Draft) -> Value {
    let axes = draft.axes.iter().map(|axis| {
        let unit = if axis.is_rotary { "deg" } else { "mm" };
        let value = |known: &Option<Known<f64>>| known.as_ref().map(|known| known.value);
        json!({
            "name": axis.name,
            format!("velocity_{unit}_s"): value(&axis.velocity),
            format!("acceleration_{unit}_s2"): value(&axis.acceleration),
            format!("travel_{unit}"): axis.travel.as_ref().map(|known| known.value),
        })
    });
    json!({
        "name": draft.name,
        "sampling_period_ms": draft.period_ms.as_ref().map(|known| known.value),
        "axes": axes.collect::<Vec<_>>(),
        "notes": draft.notes,
    })
}
