//! `precomp excite`: motions that teach a machine's axes.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use datasets::{ExcitationPlan, excite, reference_content};
use machine::MachineSpec;
use models::OperatingRange;
use motion::{AxisKind, Trajectory};
use pipeline::Setup;
use pipeline::excitation::{ControlProgram, Region, Style, control_test, in_program_words, program, travel};
use pipeline::units::in_programs;
use serde_json::{Map, Value, json};

use crate::args::{Common, MachineArgs, OutputArgs};
use crate::files::Files;
use crate::numbers;
use crate::output::{Outputs, Printer};
use crate::read;

/// Share of an axis's travel that is enough to be silent about.
const COVERED: f64 = 0.9;

/// Write random-NURBS excitation to run on a machine: a reference CSV and a part program for each run, and a control test
///
/// The programs are in the words of the machine's control: its dialect, decimals, point spacing and output format (`keep` puts a feed on every line).
/// Each lifts Z to the highest point of its run, goes over its first point, and lowers Z at a feed.
///
/// `control-test.nc` shows how the control plans: single moves, corners, arcs, short lines and rapids at its own acceleration, in under two minutes.
/// It has no reference, since its times are those of the control.
///
/// Record commanded and actual positions of every run and of the control test, one log each, and hand the logs to `precomp train`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  precomp excite --machine mill.toml -o excitation\n  precomp excite --machine mill.toml --origin x=150,y=100,z=-40 --travel 50 -o excitation"
)]
pub struct Excite {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    machine: MachineArgs,
    /// Folder for the references and programs
    #[arg(short, long, value_name = "DIR")]
    out: PathBuf,
    /// Seconds of motion in all, up to 4000
    #[arg(long, default_value_t = 60.0, value_parser = numbers::excitation_s)]
    seconds: f64,
    #[command(flatten)]
    region: RegionArgs,
    #[command(flatten)]
    output: OutputArgs,
}

/// Where excitation moves.
#[derive(Debug, Args)]
pub struct RegionArgs {
    /// Linear axes keep within ± this range about the origin, mm, and within their own travel
    #[arg(long, value_name = "MM", default_value_t = 60.0, value_parser = numbers::travel_mm)]
    pub travel: f64,
    /// Rotary axes keep within ± this range about the origin, degrees, and within their own travel
    #[arg(long, alias = "turn", value_name = "DEG", default_value_t = 180.0, value_parser = numbers::rotation_deg)]
    rotation: f64,
    /// Middle of the motion by axis, mm or degrees; an axis that is not named moves about 0, or as near to it as its travel allows
    #[arg(long, value_name = "AXIS=POS", value_delimiter = ',', value_parser = numbers::axis_position)]
    origin: Vec<numbers::Position>,
}

impl RegionArgs {
    /// The region on `machine`.
    #[must_use]
    pub fn region(&self, machine: &MachineSpec) -> Region {
        let is_rotary = |name: &str| machine.motion_axes().iter().any(|axis| axis.name == name && axis.kind == AxisKind::Rotary);
        let position = |at: &numbers::Position| (at.axis.clone(), if is_rotary(&at.axis) { at.at.to_radians() } else { at.at });
        Region {
            travel_mm: self.travel,
            turn_rad: self.rotation.to_radians(),
            origin: self.origin.iter().map(position).collect(),
        }
    }
}

impl Excite {
    pub fn files(&self) -> Files {
        let files = Files::of(self.common.json.as_deref())
            .reads_machine(&*self.machine.machine)
            .reads_controller(self.output.controller.as_deref())
            .writes_in("-o", &*self.out);
        let names = ExcitationPlan::of_seconds(self.seconds).names();
        let files = files.writes("-o", &*self.control_test());
        names
            .iter()
            .flat_map(|name| ["csv", "nc"].map(|ending| self.out.join(format!("{name}.{ending}"))))
            .fold(files, |files, path| files.writes("-o", &*path))
    }

    fn control_test(&self) -> PathBuf {
        self.out.join(format!("{}.nc", ControlProgram::NAME))
    }

    pub fn run(&self) -> Result<()> {
        let machine = read::machine(&self.machine.machine)?;
        let setup = self.output.setup(&machine)?;
        let plan = ExcitationPlan::of_seconds(self.seconds);
        let travel = travel(&machine, &self.region.region(&machine))?;
        let runs = excite(&plan, &setup.limits, setup.kinematics.axes(), &travel, setup.period_s, self.common.seed)?;
        let printer = self.common.printer();
        let mut outputs = Outputs::default();
        let spacing_s = self.output.spacing.map(|spacing_ms| spacing_ms * 1e-3);
        let style = Style::of(&self.output.settings(&setup).refit(), spacing_s, &setup);
        for (number, (name, reference)) in runs.iter().enumerate() {
            let table = self.out.join(format!("{name}.csv"));
            outputs.add(&table, reference_content(&table, reference)?);
            let program = program(name, number, &in_program_words(reference, &setup)?, &style)?;
            outputs.add(&self.out.join(format!("{name}.nc")), program);
        }
        let test = control_test(runs.len(), &setup, &travel, &style, self.common.seed)?;
        if let Some(test) = &test {
            outputs.add(&self.control_test(), test.text.as_bytes().to_vec());
        }
        if setup.dialect.is_none() {
            printer.line("note: no dialect is stated; programs use words that most controls share (--controller, or dialect in [controller])");
        }
        let seconds: f64 = runs.iter().map(|(_, reference)| reference.duration_s()).sum();
        let (name, folder) = (&machine.name, self.out.display());
        printer.line(format!("for the machine `{name}`: {} runs, {seconds:.1} s, in {folder}", runs.len()));
        if let Some(test) = &test {
            printer.line(format!("{}: {:.1} s, to learn how the control plans", self.control_test().display(), test.seconds));
        }
        let covered = show_covered(&printer, &setup, &travel, &runs);
        let names: Vec<&str> = runs.iter().map(|(name, _)| name.as_str()).collect();
        let control_test = test.map(|test| json!({ "seconds": test.seconds }));
        let figures = json!({ "runs": names, "seconds": seconds, "covered": covered, "control_test": control_test });
        outputs.write(self.common.json.as_deref(), &figures)
    }
}

/// Says how far every axis goes of what it may, and returns it by axis.
fn show_covered(printer: &Printer, setup: &Setup, travel: &[(f64, f64)], runs: &[(String, Trajectory)]) -> Map<String, Value> {
    let (mut covered, mut enough) = (Map::new(), true);
    for (index, (axis, &(lowest, highest))) in setup.kinematics.axes().iter().zip(travel).enumerate() {
        let positions = runs.iter().map(|(_, run)| run.columns()[index].as_slice());
        let (low, high) = OperatingRange::of(positions, setup.period_s).position;
        let (scale, unit) = in_programs(axis.kind);
        let [from, to, lowest_shown, highest_shown] = [low, high, lowest, highest].map(|position| position * scale);
        printer.line(format!("{}: {from:.1} to {to:.1} of {lowest_shown:.1} to {highest_shown:.1} {unit}", axis.name));
        enough &= high - low >= COVERED * (highest - lowest);
        covered.insert(axis.name.clone(), json!([low, high]));
    }
    if !enough {
        printer.line("for parts that go further: a larger --travel, more --seconds, or a second excitation of another --seed");
    }
    covered
}
