//! `precomp excite`: motions that teach a machine's axes.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use datasets::{ExcitationPlan, excite, reference_content};
use machine::MachineSpec;
use models::{Bundle, OperatingRange, REGIME_NAMES};
use motion::{AxisKind, Trajectory};
use pipeline::excitation::{
    ControlProgram, NextAxis, NextExcitation, Region, Style, control_test, in_program_words, is_placed, next_excitation,
    possible_names, program, travel, without_words,
};
use pipeline::units::ErrorUnit;
use pipeline::units::in_programs;
use pipeline::{Part, ReadSettings, Setup, machine_of};
use serde_json::{Map, Value, json};

use crate::args::{Common, OutputArgs, ProgramArgs};
use crate::files::Files;
use crate::kind::Kind;
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
///
/// With --after the runs are those that a model needs most: of the kinds of motion that add most to its expected error, in general or on the part of
/// --for. Train on the old and the new logs together.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  precomp excite --machine mill.toml -o excitation\n  precomp excite --machine mill.toml --origin x=150,y=100,z=-40 --travel 50 -o excitation\n  precomp excite --after mill.model --for part.nc --work-offset 120,80,-30 -o more"
)]
pub struct Excite {
    #[command(flatten)]
    common: Common,
    /// Machine description: a TOML file, a built-in machine (ballscrew, maxwell, worn, bc, xyzac), or a random one (random:SEED). When left out,
    /// the machine of --after, else ballscrew
    #[arg(long, value_name = "TOML")]
    machine: Option<String>,
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
    /// Model after which to excite: more of the motion that adds most to its expected error
    #[arg(long, value_name = "MODEL")]
    after: Option<PathBuf>,
    /// Part program or reference whose motion counts, and around which the axes move, where it is known where the part lies
    #[arg(long = "for", value_name = "INPUT", requires = "after")]
    part: Option<PathBuf>,
    #[command(flatten, next_help_heading = "Options of the program of --for")]
    program: ProgramArgs,
}

/// Time of the programs, as a multiple of that of their references, from which on it is reported.
const SLOWER: f64 = 1.3;

/// The machine without `--machine` and `--after`.
const USUAL_MACHINE: &str = "ballscrew";

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
            .reads_machine(self.machine.as_deref())
            .reads("--after", self.after.as_deref())
            .reads("--for", self.part.as_deref())
            .reads_controller(self.output.controller.as_deref())
            .writes_in("-o", &*self.out);
        let usual = || ExcitationPlan::of_seconds(self.seconds).names();
        let names = if self.after.is_some() { possible_names(self.seconds) } else { usual() };
        let files = files.writes("-o", &*self.control_test(), Kind::Path);
        names
            .iter()
            .flat_map(|name| ["csv", "nc"].map(|ending| self.out.join(format!("{name}.{ending}"))))
            .fold(files, |files, path| files.writes("-o", &*path, Kind::Path))
    }

    fn control_test(&self) -> PathBuf {
        self.out.join(format!("{}.nc", ControlProgram::NAME))
    }

    pub fn run(&self) -> Result<()> {
        let model = self.after.as_deref().map(read::model).transpose()?;
        let machine = match (&self.machine, &model) {
            (Some(named), _) => read::machine(named)?,
            (None, Some(model)) => machine_of(model)?,
            (None, None) => read::machine(USUAL_MACHINE)?,
        };
        let setup = self.output.setup(&machine)?;
        let printer = self.common.printer();
        let Planned { plan, travel, expected } = self.plan(&printer, &machine, &setup, model.as_ref())?;
        let runs = excite(&plan, &setup.limits, setup.kinematics.axes(), &travel, setup.period_s, self.common.seed)?;
        let mut outputs = Outputs::default();
        let spacing_s = self.output.spacing.map(|spacing_ms| spacing_ms * 1e-3);
        let mut style = Style::of(&self.output.settings(&setup).refit(), spacing_s, &setup);
        if let Some(origin_mm) = self.program.settings().first_offset(&setup) {
            style.origin_mm = origin_mm;
            let [x, y, z] = origin_mm.map(|offset| format!("{offset:.3}"));
            printer.line(format!(
                "programs are for the work offset G54 with x {x}, y {y}, z {z} mm; the references are machine coordinates"
            ));
        }
        let mut planned_s = 0.0;
        for (number, (name, reference)) in runs.iter().enumerate() {
            let table = self.out.join(format!("{name}.csv"));
            outputs.add(&table, reference_content(&table, reference)?);
            if let Some(program) = program(name, number, &in_program_words(reference, &setup)?, &style)? {
                let file = format!("{name}.nc");
                let placed = ReadSettings { work_offsets: vec![(None, style.origin_mm)], ..ReadSettings::default() };
                let planned = Part::read(&file, program.as_bytes(), &setup, &placed);
                planned_s += planned.map_or(0.0, |part| part.plan.desired.trajectory().duration_s());
                outputs.add(&self.out.join(file), program);
            }
        }
        let test = control_test(runs.len(), &setup, &travel, &style, self.common.seed)?;
        if let Some(test) = &test {
            outputs.add(&self.control_test(), test.text.as_bytes().to_vec());
        }
        let unnamed = without_words(setup.kinematics.axes());
        if !unnamed.is_empty() {
            printer.line(format!(
                "note: no program has words for {}: the runs are written as references alone, for a control that takes positions at the times of the CSV",
                unnamed.join(", ")
            ));
        } else if setup.dialect.is_none() {
            printer.line("note: no dialect is stated; programs use words that most controls share (--controller, or dialect in [controller])");
        }
        let seconds: f64 = runs.iter().map(|(_, reference)| reference.duration_s()).sum();
        let (name, folder) = (&machine.name, self.out.display());
        printer.line(format!("for the machine `{name}`: {} runs, {seconds:.1} s, in {folder}", runs.len()));
        if planned_s > SLOWER * seconds {
            printer.line(format!(
                "note: as programs the runs take about {planned_s:.0} s by the limits of the machine, and the axes move the more gently: --seconds {:.0} makes up \
                 for it, or a control that takes positions at their times runs the references",
                self.seconds * planned_s / seconds
            ));
        }
        if let Some(test) = &test {
            printer.line(format!("{}: {:.1} s, to learn how the control plans", self.control_test().display(), test.seconds));
        }
        let covered = show_covered(&printer, &setup, &travel, &runs);
        let names: Vec<&str> = runs.iter().map(|(name, _)| name.as_str()).collect();
        let control_test = test.map(|test| json!({ "seconds": test.seconds }));
        let figures = json!({ "runs": names, "seconds": seconds, "program_seconds": planned_s, "covered": covered, "control_test": control_test, "expected": expected });
        outputs.write(self.common.json.as_deref(), &figures)
    }

    /// The runs and where they move; with a model, what is expected of it.
    fn plan(&self, printer: &Printer, machine: &MachineSpec, setup: &Setup, model: Option<&Bundle>) -> Result<Planned> {
        let region = self.region.region(machine);
        let Some(model) = model else {
            return Ok(Planned {
                plan: ExcitationPlan::of_seconds(self.seconds),
                travel: travel(machine, &region)?,
                expected: None,
            });
        };
        let read = |part| read::input(part, setup, &self.program.settings(), self.program.feed);
        let part = self.part.as_deref().map(read).transpose()?;
        if part.as_ref().is_some_and(|part| !is_placed(part)) {
            printer
                .line("note: it is not known where the part lies (--work-offset): the runs are of its motion, and not around it");
        }
        let next = next_excitation(model, (machine, setup), &region, part.as_ref(), self.seconds, self.common.seed)?;
        show_expected(printer, &next, part.as_ref().map(|part| part.name()));
        let expected = Some(expected_json(&next));
        Ok(Planned { plan: next.plan, travel: next.travel, expected })
    }
}

/// The runs of an excitation.
struct Planned {
    plan: ExcitationPlan,
    /// Lowest and highest position of every axis, mm or rad.
    travel: Vec<(f64, f64)>,
    /// Figures of what is expected.
    expected: Option<Value>,
}

/// Says which runs were chosen, why, and what they are expected to gain.
fn show_expected(printer: &Printer, next: &NextExcitation, part: Option<&str>) {
    let mut kinds: Vec<(&str, usize)> = Vec::new();
    for run in &next.plan.runs {
        match kinds.iter_mut().find(|(name, _)| *name == run.name) {
            Some((_, count)) => *count += 1,
            None => kinds.push((&run.name, 1)),
        }
    }
    let kinds: Vec<String> = kinds.iter().map(|(name, count)| format!("{count} {name}")).collect();
    printer.line(format!("runs: {}", kinds.join(", ")));
    for axis in &next.axes {
        let (unit, (regime, rms, known_s)) = (ErrorUnit::from(axis.kind), axis.weakest);
        let shown = |error: f64| format!("{:.3}", unit.value(error));
        printer.line(format!(
            "{}: expected error of the model{} {} → {} {} RMS with the new logs; most of it {} ({} over {known_s:.0} s of its log)",
            axis.name,
            part.map_or_else(String::new, |part| format!(" on {part}")),
            shown(axis.before),
            shown(axis.after),
            unit.sign(),
            REGIME_NAMES[regime],
            shown(rms),
        ));
    }
}

fn expected_json(next: &NextExcitation) -> Value {
    let axis = |axis: &NextAxis| {
        let (unit, (regime, rms, known_s)) = (ErrorUnit::from(axis.kind), axis.weakest);
        let weakest = json!({ "regime": REGIME_NAMES[regime], "rms": unit.value(rms), "seconds": known_s });
        (
            axis.name.clone(),
            json!({ "rms_before": unit.value(axis.before), "rms_after": unit.value(axis.after), "weakest": weakest }),
        )
    };
    Value::Object(next.axes.iter().map(axis).collect())
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
