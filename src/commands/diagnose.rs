//! `precomp diagnose`: what logs say about the machine.

use std::path::PathBuf;

use anyhow::Result;
use clap::{Args, ValueEnum};
use datasets::Log;
use diagnosis::{Sensor, Settings, diagnose, linuxcnc};
use machine::{AxisSpec, MachineSpec};

use crate::args::{Common, LogArgs, ReportArgs};
use crate::files::Files;
use crate::kind::Kind;
use crate::output::{Outputs, Printer};
use crate::print::diagnosis as print;
use crate::read;
use crate::report::{Group, diagnosis as sections, nothing, suggestion};

/// What logs say about the machine: gains, feed-forward, friction, backlash, reversal peaks, each with interval, verdict and remedy
///
/// Commanded and actual positions are enough; the runs of `precomp excite` show most. Nothing is sent to the machine.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  precomp diagnose runs/*.csv
  precomp diagnose runs/*.csv --sensor table --json diagnosis.json
  precomp diagnose runs/*.csv -m mill.model --report machine.html
  precomp diagnose runs/*.log --controller linuxcnc -o suggestion.ini")]
pub struct Diagnose {
    /// Logs, one a run: CSV, Parquet, JSON, NumPy, MATLAB, LabVIEW, halsampler, halscope, TwinCAT Scope, SINUMERIK Edge or trace
    #[arg(required = true)]
    logs: Vec<PathBuf>,
    #[command(flatten)]
    common: Common,
    /// A model of the machine: it says where the sensor is, and what of the error no model predicts
    #[arg(short, long, value_name = "MODEL")]
    model: Option<PathBuf>,
    /// Machine that made the logs: a TOML file, a built-in one, or random:SEED; the model's when left out
    #[arg(long, value_name = "TOML")]
    machine: Option<String>,
    /// Where the logged actual position is measured: only a scale at the table sees backlash. The machine's when left out
    #[arg(long, value_enum)]
    sensor: Option<SensorName>,
    /// Also suggest settings of this control, each with the following error that the servo model forecasts; for review, nothing is sent
    #[arg(long, value_enum)]
    controller: Option<ControllerName>,
    /// Write the suggestion to this file instead of printing it
    #[arg(short, long, value_name = "INI", requires = "controller")]
    out: Option<PathBuf>,
    #[command(flatten)]
    columns: LogArgs,
    #[command(flatten)]
    report: ReportArgs,
}

/// A control whose settings can be suggested.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ControllerName {
    /// LinuxCNC: FF1, FF2 and BACKLASH in the INI file
    Linuxcnc,
}

/// A place of a position sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum SensorName {
    /// The encoder of the motor
    Motor,
    /// A scale at the table
    Table,
}

impl From<SensorName> for Sensor {
    fn from(name: SensorName) -> Self {
        match name {
            SensorName::Motor => Self::Motor,
            SensorName::Table => Self::Table,
        }
    }
}

impl Diagnose {
    pub fn files(&self) -> Files {
        Files::of(self.common.json.as_deref())
            .reads_logs("LOG", &self.logs)
            .reads("-m", self.model.as_deref())
            .reads_machine(self.machine.as_deref())
            .writes("-o", self.out.as_deref(), Kind::Settings)
            .writes("--report", self.report.report.as_deref(), Kind::Report)
    }

    pub fn run(&self) -> Result<()> {
        let printer = self.common.printer();
        let model = self.model.as_deref().map(read::model).transpose()?;
        let machine = read::real_machine(self.machine.as_deref(), self.model.as_deref().zip(model.as_ref()))?;
        let sensor = self.sensor.map_or_else(|| sensor_of(machine.as_ref().map(|(machine, _)| machine)), Into::into);
        let logs = self.logs(&printer)?;
        let found = diagnose(&logs, &Settings { sensor, circle: None })?;
        print::show(&printer, &found);
        let mut figures = print::json(&found)?;
        let mut outputs = Outputs::default();
        let joints = match self.controller {
            Some(ControllerName::Linuxcnc) => linuxcnc::suggest(&found, &logs)?,
            None => Vec::new(),
        };
        if !joints.is_empty() {
            figures["linuxcnc"] = serde_json::to_value(&joints)?;
            let text = linuxcnc::ini(&joints);
            match &self.out {
                Some(path) => {
                    outputs.add(path, text.into_bytes());
                    printer.line(format!("suggestion in {}", path.display()));
                }
                None => printer.line(text),
            }
        }
        let title = format!("Diagnosis of {}", names(&logs));
        self.report.add(&mut outputs, &printer, (&title, LEAD), || {
            let mut all = sections(&found);
            all.extend((!joints.is_empty()).then(|| suggestion(&joints)));
            Ok(vec![Group { name: title.clone(), sections: all }])
        })?;
        outputs.write(self.common.json.as_deref(), &figures)
    }

    fn logs(&self, printer: &Printer) -> Result<Vec<Log>> {
        let mut logs = Vec::new();
        for path in &self.logs {
            logs.extend(read::runs_to_measure(path, &self.columns.options(), printer)?);
        }
        let (logs, joined) = datasets::joined(logs);
        joined.iter().for_each(|finding| printer.line(finding));
        Ok(logs)
    }
}

/// What the report shows.
const LEAD: &str = "What commanded and actual positions say about the drives: gains, friction, backlash, ripple, each with its interval, a verdict \
                    and what to do.";

/// The diagnosis of the logs of a training, as a part of its report. Where there is none the group says why.
pub fn group(logs: &[Log], machine: Option<&MachineSpec>) -> Group {
    let found = diagnose(logs, &Settings { sensor: sensor_of(machine), circle: None });
    let all = match found {
        Ok(found) => sections(&found),
        Err(error) => vec![nothing("What the logs say about the machine", format!("There is no diagnosis: {error}."))],
    };
    Group { name: "Diagnosis".to_owned(), sections: all }
}

/// The name of a log, or how many there are.
fn names(logs: &[Log]) -> String {
    match logs {
        [log] => log.name.clone(),
        _ => format!("{} logs", logs.len()),
    }
}

/// The sensor by the machine. A real machine's file that does not name a scale leaves it open.
fn sensor_of(machine: Option<&MachineSpec>) -> Sensor {
    let is_simulated =
        |machine: &MachineSpec| machine.axes.iter().any(|axis| matches!(axis, AxisSpec::Linear(axis) if axis.drive.is_some()));
    match machine {
        Some(machine) if machine.sensor == machine::Sensor::Table => Sensor::Table,
        Some(machine) if is_simulated(machine) => Sensor::Motor,
        _ => Sensor::Unknown,
    }
}
