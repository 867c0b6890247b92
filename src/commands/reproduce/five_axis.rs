//! Paper C, tables I to III: spatial and tracking-error ILC of a five-axis machine, and what a model of the machine makes of the first run.

use anyhow::Result;
use compensation::laws::{Gain, SpatialIlc, TrackingIlc};
use compensation::{CompensationLaw, Guard, LowPass, StopRule, learn};
use machine::{Machine, MachineSpec};
use models::Bundle;
use motion::DesiredPath;
use motion::contour::MovingWindow;
use serde_json::{Value, json};
use training::Recipe;

use super::Reproduce;
use crate::comparison::floor;
use crate::evaluate::{self, Figures};
use crate::input::{self, Frame, Input};
use crate::learning::{self, Settings};
use crate::output::{Printer, table, um};
use crate::recording::{TRAVEL_MM, record};
use crate::training_run::{TrainSettings, train};

/// The paper's learning rate.
const ALPHA: f64 = 0.5;
/// Paths as the paper runs them: table, curve, feed in mm/min, learning runs.
const PATHS: [(&str, &str, f64, usize); 3] =
    [("I", "saddle", 1000.0, 7), ("II", "saddle-butterfly", 1500.0, 7), ("III", "saddle-butterfly", 3000.0, 6)];

/// What the paper prints: table, method, tip MAX and RMS in µm, direction MAX and RMS in µrad.
const PRINTED: [(&str, &str, [Option<f64>; 4]); 6] = [
    ("I", UNCOMPENSATED, [Some(8.656), Some(5.380), Some(329.0), Some(299.3)]),
    ("I", SPATIAL, [Some(2.399), Some(0.755), Some(25.12), Some(6.845)]),
    ("II", UNCOMPENSATED, [Some(49.633), Some(26.664), Some(745.0), Some(313.9)]),
    ("II", SPATIAL, [Some(15.376), Some(0.896), Some(259.0), Some(12.85)]),
    ("II", TRACKING, [Some(36.992), Some(2.591), None, None]),
    ("III", SPATIAL, [Some(36.244), Some(3.149), None, None]),
];

const UNCOMPENSATED: &str = "uncompensated";
const SPATIAL: &str = "spatial ILC";
const SPATIAL_FILTERED: &str = "spatial ILC, low-pass 100 Hz";
const TRACKING: &str = "tracking-error ILC";
const TRACKING_FILTERED: &str = "tracking-error ILC, low-pass 100 Hz";
const FIRST_RUN: &str = "first run, compensated by the model";
const FLOOR: &str = "floor: a run around the mean of runs";

struct Row {
    table: &'static str,
    curve: &'static str,
    feed_mm_min: f64,
    method: &'static str,
    runs: usize,
    figures: Figures,
}

impl Reproduce {
    /// Paper C's two paths on the machine `bc`, unless another five-axis machine is named.
    pub(super) fn five_axis(&self, printer: &Printer) -> Result<Vec<Value>> {
        let named = input::machine(&self.machine.machine)?;
        let spec = if named.kinematics()?.turns() { named } else { MachineSpec::builtin("bc")? };
        let logs = record(&spec, self.seconds, TRAVEL_MM, self.common.seed)?;
        let recipe = Recipe::builtin("staged")?;
        let trained = train(&logs, Some(&spec), &TrainSettings::of(recipe, self.common.seed))?;
        let mut rows = Vec::new();
        for (table, curve, feed_mm_min, runs) in PATHS {
            let desired = Input::curve(curve, feed_mm_min / 60.0, &Frame::of(&spec)?)?.desired;
            for (method, runs, figures) in self.methods(&spec, &trained.bundle, &desired, runs)? {
                rows.push(Row { table, curve, feed_mm_min, method, runs, figures });
            }
        }
        Ok(say(printer, &rows))
    }

    /// Method, runs on the machine before the one that counts, and its figures; means over the seeds.
    fn methods(
        &self,
        spec: &MachineSpec,
        bundle: &Bundle,
        desired: &DesiredPath,
        runs: usize,
    ) -> Result<Vec<(&'static str, usize, Figures)>> {
        let low_pass = LowPass::new(100.0, desired.trajectory().period_s())?;
        let limits = spec.limits();
        let first_run = learning::compensate_with(bundle, &limits, desired, None, &Settings::default())?.reference;
        let mut found: Vec<(&'static str, usize, Vec<Figures>)> = Vec::new();
        for seed in 0..self.seeds {
            let mut machine = input::simulated(spec, self.common.seed.wrapping_add(1000 * (seed + 1)))?;
            let spatial = |low_pass| -> Result<Box<dyn CompensationLaw>> {
                Ok(Box::new(SpatialIlc::new(Gain::Constant(ALPHA), low_pass)?.with_estimator(Box::new(MovingWindow::default()))))
            };
            let tracking = |low_pass| TrackingIlc::new(Gain::Constant(ALPHA), low_pass);
            let laws: [(&'static str, Box<dyn CompensationLaw>); 4] = [
                (SPATIAL, spatial(None)?),
                (SPATIAL_FILTERED, spatial(low_pass)?),
                (TRACKING, Box::new(tracking(None))),
                (TRACKING_FILTERED, Box::new(tracking(low_pass))),
            ];
            let mut push = |method, runs, figures| match found.iter_mut().find(|(known, ..)| *known == method) {
                Some((.., all)) => all.push(figures),
                None => found.push((method, runs, vec![figures])),
            };
            push(UNCOMPENSATED, 0, evaluate::figures(desired, None, &machine.run(desired.trajectory())?)?);
            for (method, mut law) in laws {
                let stop = StopRule { updates: runs, stall: f64::NEG_INFINITY };
                let learned = learn(&mut machine, law.as_mut(), desired, None, &Guard::default(), &stop, &mut |_, _| 0.0)?;
                if let Some(last) = learned.last() {
                    push(method, runs, evaluate::figures(desired, None, &last.actual)?);
                }
            }
            push(FIRST_RUN, 0, evaluate::figures(desired, None, &machine.run(&first_run)?)?);
            push(FLOOR, 0, floor(&mut machine, desired)?);
        }
        Ok(found.into_iter().filter_map(|(method, runs, all)| Some((method, runs, Figures::mean(&all)?))).collect())
    }
}

fn say(printer: &Printer, rows: &[Row]) -> Vec<Value> {
    let mut tables = Vec::new();
    for rows in rows.chunk_by(|a, b| a.table == b.table) {
        let first = &rows[0];
        printer.line(format!("Paper C, table {}: {} at {} mm/min, α = {ALPHA}", first.table, first.curve, first.feed_mm_min));
        let lines: Vec<Vec<String>> = rows
            .iter()
            .map(|row| {
                let printed = printed(row).map(|value| value.map_or("–".to_owned(), |value| format!("{value}")));
                let [tip_max, tip_rms, turn_max, turn_rms] = printed;
                let orientation = row.figures.orientation;
                let urad = |rad: Option<f64>| rad.map_or("–".to_owned(), |rad| format!("{:.2}", rad * 1e6));
                vec![
                    row.method.to_owned(),
                    row.runs.to_string(),
                    format!("{tip_rms} / {tip_max}"),
                    format!("{} / {}", um(row.figures.tip.rms_mm), um(row.figures.tip.max_mm)),
                    format!("{turn_rms} / {turn_max}"),
                    format!("{} / {}", urad(orientation.map(|o| o.rms_rad)), urad(orientation.map(|o| o.max_rad))),
                ]
            })
            .collect();
        printer.line(table(
            &[
                "method",
                "learning runs",
                "printed tip RMS / MAX µm",
                "tip µm",
                "printed direction RMS / MAX µrad",
                "direction µrad",
            ],
            &lines,
        ));
        let lines: Vec<Value> = rows
            .iter()
            .map(|row| {
                let [tip_max, tip_rms, turn_max, turn_rms] = printed(row);
                json!({
                    "name": row.method,
                    "runs": row.runs,
                    "printed": { "rms_um": tip_rms, "max_um": tip_max, "orientation_rms_urad": turn_rms, "orientation_max_urad": turn_max },
                    "measured": {
                        "rms_um": row.figures.tip.rms_mm * 1e3,
                        "max_um": row.figures.tip.max_mm * 1e3,
                        "orientation_rms_urad": row.figures.orientation.map(|o| o.rms_rad * 1e6),
                        "orientation_max_urad": row.figures.orientation.map(|o| o.max_rad * 1e6),
                    },
                })
            })
            .collect();
        tables.push(json!({
            "paper": "C", "table": first.table, "curve": first.curve, "feed_mm_min": first.feed_mm_min, "rows": lines,
        }));
    }
    tables
}

/// Tip MAX and RMS, µm, direction MAX and RMS, µrad, as printed.
fn printed(row: &Row) -> [Option<f64>; 4] {
    PRINTED
        .iter()
        .find(|(table, method, _)| *table == row.table && *method == row.method)
        .map_or([None; 4], |(.., figures)| *figures)
}
