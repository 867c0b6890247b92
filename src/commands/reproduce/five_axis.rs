//! Paper C, tables I to III: spatial and tracking-error ILC of a five-axis machine, and what a model of the machine makes of the first run.
//!
//! Once with references that keep their time sample by sample, and once as the paper has it: every reference is a program of short lines, whose
//! time the control plans itself.

use anyhow::Result;
use compensation::laws::{Gain, SpatialIlc, TrackingIlc};
use compensation::{CompensationLaw, CorrectionLimits, LowPass, StopRule, learn};
use machine::{Machine, MachineError, MachineSpec, SimulatedMachine};
use models::Bundle;
use motion::contour::MovingWindow;
use pipeline::compare::floor;
use pipeline::control::{MOVE_POINTS, Pairing, ProgramRun, curve_program, learn_program, run_program};
use pipeline::excitation::{TRAVEL_MM, record};
use pipeline::model_based_ilc::Settings;
use pipeline::statistics::Figures;
use pipeline::training::{TrainSettings, train};
use pipeline::units::um;
use pipeline::{Input, SILENT, Setup, model_based_ilc};
use serde_json::{Value, json};
use training::Recipe;

use super::Reproduce;
use super::found::{Entry, Found, Section};
use super::s_piece::{self, SPiece};
use crate::output::{Printer, table};
use crate::read;

/// The paper's learning rate.
const ALPHA: f64 = 0.5;
/// Paths as the paper runs them: table, curve, feed in mm/min, learning runs.
const PATHS: [(&str, &str, f64, usize); 3] =
    [("I", "saddle", 1000.0, 7), ("II", "saddle-butterfly", 1500.0, 7), ("III", "saddle-butterfly", 3000.0, 6)];

/// Length of a program's lines, mm. Paper C does not say; Paper A's step of 0.005 in a curve's parameter is this on the saddle.
const SPACING_MM: f64 = 0.2;

/// What the paper prints: table, method, tip MAX and RMS in µm, direction MAX and RMS in µrad.
const PRINTED: [(&str, &str, [f64; 4]); 7] = [
    ("I", UNCOMPENSATED, [8.656, 5.380, 329.0, 299.3]),
    ("I", SPATIAL, [2.399, 0.755, 25.12, 6.845]),
    ("I", TRACKING, [2.628, 0.830, 30.0, 7.043]),
    ("II", UNCOMPENSATED, [49.633, 26.664, 745.0, 313.9]),
    ("II", SPATIAL, [15.376, 0.896, 259.0, 12.85]),
    ("II", TRACKING, [36.992, 2.591, 445.0, 37.82]),
    ("III", SPATIAL, [36.244, 3.149, 610.4, 47.27]),
];

const UNCOMPENSATED: &str = "uncompensated";
const SPATIAL: &str = "spatial ILC";
const SPATIAL_FILTERED: &str = "spatial ILC, low-pass 100 Hz";
const TRACKING: &str = "tracking-error ILC";
const TRACKING_FILTERED: &str = "tracking-error ILC, low-pass 100 Hz";
const OWN: &str = "tracking-error ILC, behind each run's own command";
const OWN_FILTERED: &str = "tracking-error ILC, behind each run's own command, low-pass 100 Hz";
const FIRST_RUN: &str = "first run, compensated by the model";
const FLOOR: &str = "floor: a run around the mean of runs";

/// What the machine is given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Given {
    /// Positions, one a sample.
    Samples,
    /// Programs, planned anew by the control.
    Programs,
}

impl Given {
    fn name(self) -> &'static str {
        match self {
            Self::Samples => "samples",
            Self::Programs => "programs",
        }
    }

    fn text(self) -> String {
        match self {
            Self::Samples => "references that keep their time".to_owned(),
            Self::Programs => format!("as G-code, lines of {SPACING_MM} mm, planned anew by the control"),
        }
    }
}

struct Row {
    table: &'static str,
    curve: &'static str,
    feed_mm_min: f64,
    given: Given,
    method: &'static str,
    runs: usize,
    figures: Figures,
}

/// Methods in the order of the table, learning runs before the one that counts, and figures, one a seed.
#[derive(Default)]
struct Methods(Vec<(&'static str, usize, Vec<Figures>)>);

impl Methods {
    fn push(&mut self, method: &'static str, runs: usize, figures: Figures) {
        match self.0.iter_mut().find(|(known, ..)| *known == method) {
            Some((.., all)) => all.push(figures),
            None => self.0.push((method, runs, vec![figures])),
        }
    }

    fn means(self) -> impl Iterator<Item = (&'static str, usize, Figures)> {
        self.0.into_iter().filter_map(|(method, runs, all)| Some((method, runs, Figures::mean(&all)?)))
    }
}

fn spatial(low_pass: Option<LowPass>) -> Result<Box<dyn CompensationLaw>> {
    Ok(Box::new(SpatialIlc::new(Gain::Constant(ALPHA), low_pass)?.with_estimator(Box::new(MovingWindow::default()))))
}

fn tracking(low_pass: Option<LowPass>) -> Box<dyn CompensationLaw> {
    Box::new(TrackingIlc::new(Gain::Constant(ALPHA), low_pass))
}

impl Reproduce {
    /// Paper C's two paths on the machine `bc`, unless another five-axis machine is named.
    pub(super) fn five_axis(&self, printer: &Printer) -> Result<Found> {
        let named = read::machine(&self.machine.machine)?;
        let spec = if named.kinematics()?.has_rotary_axes() { named } else { MachineSpec::builtin("bc")? };
        let logs = record(&spec, self.seconds(), TRAVEL_MM, self.common.seed)?;
        let recipe = Recipe::builtin("staged")?;
        let trained = train(&logs, Some(&spec), &TrainSettings::of(recipe, self.common.seed), SILENT)?;
        let setup = Setup::new(&spec, None)?;
        let mut rows = Vec::new();
        for (table, curve, feed_mm_min, runs) in PATHS {
            let feed_mm_s = feed_mm_min / 60.0;
            let samples = Input::curve(curve, feed_mm_s, &setup)?;
            let program = Input::from(curve_program(curve, feed_mm_s, SPACING_MM, &setup)?);
            let found = [
                (Given::Samples, self.on_samples(&spec, &trained.bundle, &samples, runs)?),
                (Given::Programs, self.on_programs(&spec, &trained.bundle, &program, runs)?),
            ];
            for (given, found) in found {
                let row = |(method, runs, figures)| Row { table, curve, feed_mm_min, given, method, runs, figures };
                rows.extend(found.means().map(row));
            }
        }
        let mut found = Found { tables: show(printer, &rows, setup.period_s), sections: sections(&rows) };
        found.extend(self.s_piece(&spec, &trained.bundle, &setup)?.show(printer));
        Ok(found)
    }

    /// The S-shaped test piece, as a program, on the machine of the first seed.
    fn s_piece(&self, spec: &MachineSpec, bundle: &Bundle, setup: &Setup) -> Result<SPiece> {
        let program = Input::from(curve_program("s-piece", s_piece::FEED_MM_MIN / 60.0, SPACING_MM, setup)?);
        let found = self.program_runs(spec, bundle, &program, s_piece::RUNS)?;
        let of = |wanted: &str| found.iter().find(|(method, ..)| *method == wanted).map(|(.., run)| run);
        let ilc = found.iter().filter(|(method, ..)| ![UNCOMPENSATED, FIRST_RUN].contains(method));
        let best = ilc.min_by(|a, b| a.2.figures.cost_mm().total_cmp(&b.2.figures.cost_mm()));
        let (Some(uncompensated), Some((law, _, best_ilc)), Some(first_run)) = (of(UNCOMPENSATED), best, of(FIRST_RUN)) else {
            anyhow::bail!("no run of the S-shaped test piece");
        };
        SPiece::new(program.program()?, uncompensated, (law, best_ilc), first_run)
    }

    /// One machine a seed.
    fn machines(&self, spec: &MachineSpec) -> impl Iterator<Item = Result<SimulatedMachine, MachineError>> {
        (1..=self.seeds).map(|seed| SimulatedMachine::new(spec, self.common.seed.wrapping_add(1000 * seed)))
    }

    fn on_samples(&self, spec: &MachineSpec, bundle: &Bundle, input: &Input, runs: usize) -> Result<Methods> {
        let desired = input.desired();
        let low_pass = LowPass::new(100.0, desired.trajectory().period_s())?;
        let first_run = model_based_ilc(input, bundle, &Settings::default(), SILENT)?.reference;
        let mut found = Methods::default();
        for machine in self.machines(spec) {
            let mut machine = machine?;
            let laws = [
                (SPATIAL, spatial(None)?),
                (SPATIAL_FILTERED, spatial(low_pass)?),
                (TRACKING, tracking(None)),
                (TRACKING_FILTERED, tracking(low_pass)),
            ];
            found.push(UNCOMPENSATED, 0, input.figures(&machine.run(desired.trajectory())?)?);
            for (method, mut law) in laws {
                let stop = StopRule::after(runs);
                let learned =
                    learn(&mut machine, law.as_mut(), desired, None, &CorrectionLimits::default(), &stop, &mut |_, _| 0.0)?;
                if let Some(last) = learned.last() {
                    found.push(method, runs, input.figures(&last.actual)?);
                }
            }
            found.push(FIRST_RUN, 0, input.figures(&machine.run(&first_run)?)?);
            found.push(FLOOR, 0, floor(&mut machine, desired)?);
        }
        Ok(found)
    }

    fn on_programs(&self, spec: &MachineSpec, bundle: &Bundle, program: &Input, runs: usize) -> Result<Methods> {
        let mut found = Methods::default();
        for (method, runs, run) in self.program_runs(spec, bundle, program, runs)? {
            found.push(method, runs, run.figures);
        }
        Ok(found)
    }

    /// The last run of every method, with its name and learning runs, on the machine of every seed.
    fn program_runs(
        &self,
        spec: &MachineSpec,
        bundle: &Bundle,
        program: &Input,
        runs: usize,
    ) -> Result<Vec<(&'static str, usize, ProgramRun)>> {
        let part = program.program()?;
        let desired = &part.plan.desired;
        let low_pass = LowPass::new(100.0, desired.trajectory().period_s())?;
        let settings = Settings { written: Some(MOVE_POINTS), cycle_limit: f64::INFINITY, ..Settings::default() };
        let first_run = model_based_ilc(program, bundle, &settings, SILENT)?;
        let first_points = first_run.written.unwrap_or(MOVE_POINTS);
        let mut found = Vec::new();
        for machine in self.machines(spec) {
            let mut machine = machine?;
            let laws = [
                (SPATIAL, spatial(None)?, Pairing::Place),
                (SPATIAL_FILTERED, spatial(low_pass)?, Pairing::Place),
                (TRACKING, tracking(None), Pairing::Time),
                (TRACKING_FILTERED, tracking(low_pass), Pairing::Time),
                (OWN, tracking(None), Pairing::Place),
                (OWN_FILTERED, tracking(low_pass), Pairing::Place),
            ];
            found.push((UNCOMPENSATED, 0, run_program(part, &mut machine, desired.trajectory(), &MOVE_POINTS)?));
            for (method, mut law, pairing) in laws {
                let learned =
                    learn_program(part, &mut machine, law.as_mut(), (pairing, MOVE_POINTS), runs, &CorrectionLimits::default())?;
                found.extend(learned.into_iter().next_back().map(|last| (method, runs, last)));
            }
            found.push((FIRST_RUN, 0, run_program(part, &mut machine, &first_run.reference, &first_points)?));
        }
        Ok(found)
    }
}

fn show(printer: &Printer, rows: &[Row], period_s: f64) -> Vec<Value> {
    let say_table = |rows: &[Row]| {
        let first = &rows[0];
        let given = first.given.text();
        printer.line(format!(
            "Paper C, table {}: {} at {} mm/min, α = {ALPHA}; {given}",
            first.table, first.curve, first.feed_mm_min
        ));
        let lines: Vec<Vec<String>> = rows.iter().map(|row| row.cells(period_s)).collect();
        printer.line(table(&HEADER, &lines));
        json!({
            "paper": "C", "table": first.table, "curve": first.curve, "feed_mm_min": first.feed_mm_min, "given": first.given.name(),
            "rows": rows.iter().map(|row| row.json(period_s)).collect::<Vec<_>>(),
        })
    };
    rows.chunk_by(|a, b| (a.table, a.given) == (b.table, b.given)).map(say_table).collect()
}

const MACHINE: &str =
    "Another machine with the paper's position gains; the paper prints neither its friction nor the formula of the path.";
const BY_TIME: &str = "Tracking error of two readings: here sample by sample behind the first run's command. On references that keep their time it converges \
                       like spatial ILC; on programs, whose time the control plans anew in every run, it does not.";
const BY_OWN: &str = "Tracking error of two readings: here behind each run's own command. On the saddle this one, like the paper's, ends close to spatial ILC.";
const OURS: &str = "Not in the paper.";

fn sections(rows: &[Row]) -> Vec<Section> {
    let section = |rows: &[Row]| {
        let first = &rows[0];
        let (figures, note) = match first.table {
            "I" => ("9 to 11", ""),
            "II" => ("13 to 15", ""),
            _ => ("16", "The first row of the paper's table, 1500 mm/min uncompensated, is that of table II."),
        };
        Section {
            paper: 'C',
            title: format!(
                "Table {}: {} at {} mm/min, {} (and figures {figures})",
                first.table,
                first.curve,
                first.feed_mm_min,
                first.given.text()
            ),
            note: format!("α = {ALPHA}, {} updates. {note}", rows.iter().map(|row| row.runs).max().unwrap_or_default())
                .trim()
                .into(),
            entries: rows.iter().flat_map(Row::entries).collect(),
            pictures: Vec::new(),
        }
    };
    rows.chunk_by(|a, b| (a.table, a.given) == (b.table, b.given)).map(section).collect()
}

const HEADER: [&str; 7] = [
    "method",
    "learning runs",
    "printed tip RMS / MAX µm",
    "tip µm",
    "MAX at s",
    "printed direction RMS / MAX µrad",
    "direction µrad",
];

impl Row {
    fn entries(&self) -> Vec<Entry> {
        let [tip_max, tip_rms, turn_max, turn_rms] = printed(self);
        let why = match self.method {
            _ if tip_max.is_none() => OURS,
            TRACKING => BY_TIME,
            OWN => BY_OWN,
            _ => MACHINE,
        };
        let name = |figure: &str| format!("{}, {figure}", self.method);
        let mut entries = vec![
            Entry::um(name("tip MAX"), tip_max, self.figures.tip.max_mm, why),
            Entry::um(name("tip RMS"), tip_rms, self.figures.tip.rms_mm, why),
        ];
        if let Some(direction) = self.figures.orientation {
            entries.push(Entry::of(name("direction MAX"), "µrad", turn_max, direction.max_rad * 1e6, why));
            entries.push(Entry::of(name("direction RMS"), "µrad", turn_rms, direction.rms_rad * 1e6, why));
        }
        entries
    }

    fn cells(&self, period_s: f64) -> Vec<String> {
        let printed = printed(self).map(|value| value.map_or("–".to_owned(), |value| format!("{value}")));
        let [tip_max, tip_rms, turn_max, turn_rms] = printed;
        let (tip, orientation) = (&self.figures.tip, self.figures.orientation);
        let urad = |rad: Option<f64>| rad.map_or("–".to_owned(), |rad| format!("{:.2}", rad * 1e6));
        vec![
            self.method.to_owned(),
            self.runs.to_string(),
            format!("{tip_rms} / {tip_max}"),
            format!("{} / {}", um(tip.rms_mm), um(tip.max_mm)),
            format!("{:.2}", tip.max_at as f64 * period_s),
            format!("{turn_rms} / {turn_max}"),
            format!("{} / {}", urad(orientation.map(|o| o.rms_rad)), urad(orientation.map(|o| o.max_rad))),
        ]
    }

    fn json(&self, period_s: f64) -> Value {
        let [tip_max, tip_rms, turn_max, turn_rms] = printed(self);
        let (tip, orientation) = (&self.figures.tip, self.figures.orientation);
        json!({
            "name": self.method,
            "runs": self.runs,
            "printed": { "rms_um": tip_rms, "max_um": tip_max, "orientation_rms_urad": turn_rms, "orientation_max_urad": turn_max },
            "measured": {
                "rms_um": tip.rms_mm * 1e3,
                "max_um": tip.max_mm * 1e3,
                "max_at_s": tip.max_at as f64 * period_s,
                "orientation_rms_urad": orientation.map(|o| o.rms_rad * 1e6),
                "orientation_max_urad": orientation.map(|o| o.max_rad * 1e6),
            },
        })
    }
}

/// Tip MAX and RMS, µm, direction MAX and RMS, µrad, as printed. The paper does not say which of the two its tracking error is.
fn printed(row: &Row) -> [Option<f64>; 4] {
    let method = if row.method == OWN { TRACKING } else { row.method };
    PRINTED
        .iter()
        .find(|(table, known, _)| *table == row.table && *known == method)
        .map_or([None; 4], |(.., figures)| figures.map(Some))
}
