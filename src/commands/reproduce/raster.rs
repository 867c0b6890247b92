//! Paper E on the simulated drives, which stand in for its experiment (figures 4, 5, 7 and 8): norm-optimal ILC of a raster scan, from single axes
//! (`a = 0`) to the contour alone (`a = 1`).

use std::sync::Arc;

use anyhow::Result;
use compensation::{CorrectionLimits, ImpulseResponse, StopRule, learn};
use machine::{MachineSpec, SimulatedMachine};
use motion::{Axis, DesiredPath, Kinematics, Trajectory};
use pipeline::model_based_ilc::{PROBE, RESPONSE_S, norm_optimal};
use pipeline::units::um;
use pipeline::{Setup, statistics};
use serde_json::{Value, json};

use super::Reproduce;
use super::corner::{self, Corner, Shown};
use super::found::{Entry, Found, Printed, Section};
use crate::output::{Printer, table};
use crate::read;

/// Samples of the scan, as in the paper.
pub(super) const SAMPLES: usize = 1050;
/// Rest before and after the scan, samples.
const REST: usize = 5;
/// Length of a line, distance of two, and step of a sample, mm. With the rests, five lines and four turns make the paper's number of samples.
const LINE_MM: f64 = 10.0;
const SPACING_MM: f64 = 0.5;
const STEP_MM: f64 = 0.05;
/// Shares of the contour error.
pub(super) const SHARES: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];
/// Learning runs; the figures are means over the last ones.
pub(super) const RUNS: usize = 12;
const CONVERGED: usize = 4;
/// What figure 7 is made on.
const CORNER: Shown = Shown { figure: 7, machine: "experiment: the simulated drives", file: "e-figure-7" };

/// Sample of the first corner of the scan.
pub(super) fn first_corner() -> usize {
    REST + (LINE_MM / STEP_MM).round() as usize
}

/// Converged figures of one weighting; mm.
pub(super) struct Row {
    pub a: f64,
    pub contour_rms: f64,
    pub across_rms: f64,
    pub axis_rms: f64,
    pub effort_rms: f64,
    /// Relative error of the responses up to which learning converges monotonically, where it is asked for.
    pub permitted: Option<f64>,
}

impl Row {
    pub(super) fn new(a: f64) -> Self {
        Self { a, contour_rms: 0.0, across_rms: 0.0, axis_rms: 0.0, effort_rms: 0.0, permitted: None }
    }

    /// Adds the means of the last runs, references and actual positions, with this weight.
    pub(super) fn add<'a>(
        &mut self,
        desired: &DesiredPath,
        runs: impl DoubleEndedIterator<Item = (&'a Trajectory, &'a Trajectory)>,
        weight: f64,
    ) -> Result<()> {
        let share = weight / CONVERGED as f64;
        for (reference, actual) in runs.rev().take(CONVERGED) {
            self.contour_rms += share * statistics::contour(desired, None, actual)?.rms_mm;
            self.across_rms += share * across_rms(desired.trajectory(), actual)?;
            self.axis_rms += share * rms(desired.trajectory(), actual)?;
            self.effort_rms += share * rms(reference, desired.trajectory())?;
        }
        Ok(())
    }
}

impl Reproduce {
    pub(super) fn raster(&self, printer: &Printer) -> Result<Found> {
        let spec = read::machine(&self.machine.machine)?;
        let setup = Setup::new(&spec, None)?;
        let desired = raster(setup.period_s, &spec.motion_axes(), setup.kinematics)?;
        let (mut rows, mut corners) = (Vec::new(), Vec::new());
        for a in SHARES {
            let mut row = Row::new(a);
            for seed in self.seeds_used() {
                let last = self.scan(&spec, &desired, seed, &mut row)?;
                if seed == self.common.seed && (a == 0.0 || a == 1.0) {
                    corners.push(Corner::new(a, first_corner(), &across(desired.trajectory(), &last)?, &last));
                }
            }
            rows.push(row);
        }
        let path = desired.trajectory();
        let tables = vec![
            show(printer, "on the simulated drives", 27, &rows),
            corner::show(printer, CORNER, path, first_corner(), &corners),
        ];
        let title = "Figures 4, 5 and 8, experiment: the scan on the simulated drives";
        let note = format!("{} Means of the last {CONVERGED} of {RUNS} runs with noise and friction.", note(setup.period_s));
        let sections = vec![section(title, note, 27.0, &rows, DRIVES), corner::section(CORNER, path, first_corner(), &corners)];
        Ok(Found { tables, sections })
    }

    /// Learns the scan with the share of `row`, to which it adds the figures, and returns the last run.
    fn scan(&self, spec: &MachineSpec, desired: &DesiredPath, seed: u64, row: &mut Row) -> Result<Trajectory> {
        let mut machine = SimulatedMachine::new(spec, seed)?;
        let responses = ImpulseResponse::probe(&mut machine, desired.trajectory(), PROBE, RESPONSE_S)?;
        let mut law = norm_optimal(row.a, responses)?;
        let weight = 1.0 / self.seeds as f64;
        row.permitted = Some(row.permitted.unwrap_or_default() + weight * law.permitted_model_error(desired)?);
        let stop = StopRule::after(RUNS);
        let learned = learn(&mut machine, &mut law, desired, None, &CorrectionLimits::default(), &stop, &mut |_, _| 0.0)?;
        row.add(desired, learned.iterations.iter().map(|round| (&round.reference, &round.actual)), weight)?;
        Ok(learned.last().map_or(desired.trajectory(), |last| &last.actual).clone())
    }
}

const DRIVES: &str = "Drives with friction and backlash stand in for the testbed, whose responses the law measures first. How much the contour gains follows \
                      from how far the turns lie above the axes' bandwidth, which the paper does not print.";

/// The scan in words.
pub(super) fn note(period_s: f64) -> String {
    format!(
        "Lines of {LINE_MM} mm, {SPACING_MM} mm apart, at {} mm/s with instant turns, {SAMPLES} samples; S = R = 1e-3 (eq. 21).",
        STEP_MM / period_s
    )
}

/// The rows as a section; `gain` is the printed reduction of the contour error, %.
pub(super) fn section(title: &str, note: String, gain: f64, rows: &[Row], why: &'static str) -> Section {
    const CURVES: &str = "The paper shows the curve without values.";
    let first = &rows[0];
    let mut entries = Vec::new();
    for row in rows {
        let name = |what: &str| format!("a = {}: {what}", row.a);
        let words = |words: &str| if row.a == 0.0 { Printed::None } else { Printed::Words(words.into()) };
        entries.push(Entry::um(name("contour error RMS (eq. 1)"), words("smaller than a = 0"), row.across_rms, CURVES));
        entries.push(Entry::um(name("axes' error RMS"), words("larger than a = 0"), row.axis_rms, CURVES));
        entries.push(Entry::um(name("shift of the reference RMS"), words("smaller than a = 0"), row.effort_rms, CURVES));
    }
    if let Some(last) = rows.last() {
        let change = 100.0 * (last.across_rms / first.across_rms - 1.0);
        entries.push(Entry::of("contour error RMS, a = 1 against a = 0", "%", Printed::Value(-gain), change, why));
        let change = 100.0 * (last.contour_rms / first.contour_rms - 1.0);
        let space =
            "Not in the paper, which measures across the path's direction at the same instant; here the distance in space.";
        entries.push(Entry::of("distance to the path RMS, a = 1 against a = 0", "%", Printed::None, change, space));
    }
    Section { paper: 'E', title: title.into(), note, entries, pictures: Vec::new() }
}

/// Root mean square difference of two runs over the axes and samples, mm.
pub(super) fn rms(a: &Trajectory, b: &Trajectory) -> Result<f64> {
    let difference: Vec<f64> = a.tracking_error(b)?.concat();
    Ok((difference.iter().map(|d| d * d).sum::<f64>() / difference.len().max(1) as f64).sqrt())
}

/// Root mean square of [`across`], mm.
fn across_rms(desired: &Trajectory, actual: &Trajectory) -> Result<f64> {
    let errors = across(desired, actual)?;
    Ok((errors.iter().map(|error| error * error).sum::<f64>() / errors.len().max(1) as f64).sqrt())
}

/// The paper's contour error (eq. 1) of every sample: the tracking error across the path's direction at its instant, mm; the whole tracking
/// error at standstill.
pub(super) fn across(desired: &Trajectory, actual: &Trajectory) -> Result<Vec<f64>> {
    let error = desired.tracking_error(actual)?;
    let of = |k: usize| {
        let direction = |column: &Vec<f64>| column[(k + 1).min(desired.len() - 1)] - column[k.saturating_sub(1)];
        let tangent: Vec<f64> = desired.columns().iter().map(direction).collect();
        let length: f64 = tangent.iter().map(|t| t * t).sum();
        let along: f64 = tangent.iter().zip(&error).map(|(t, e)| t * e[k]).sum();
        let square = error.iter().map(|e| e[k] * e[k]).sum::<f64>() - if length > 0.0 { along * along / length } else { 0.0 };
        square.max(0.0).sqrt()
    };
    Ok((0..desired.len()).map(of).collect())
}

/// Lines to and fro at one speed, with instant turns, which no axis can follow.
pub(super) fn raster(period_s: f64, axes: &[Axis], kinematics: Arc<dyn Kinematics>) -> Result<DesiredPath> {
    let (mut points, mut at, mut direction) = (vec![[0.0, 0.0]; REST + 1], [0.0, 0.0], 1.0);
    'scan: loop {
        for (axis, length) in [(0, LINE_MM * direction), (1, SPACING_MM)] {
            let steps = (length.abs() / STEP_MM).round();
            for _ in 0..steps as usize {
                at[axis] += length / steps;
                points.push(at);
                if points.len() == SAMPLES - REST + 1 {
                    break 'scan;
                }
            }
        }
        direction = -direction;
    }
    points.resize(SAMPLES, at);
    let columns =
        (0..axes.len()).map(|axis| points.iter().map(|point| point.get(axis).copied().unwrap_or(0.0)).collect()).collect();
    Ok(DesiredPath::new(Trajectory::new(period_s, axes.to_vec(), columns)?, kinematics)?)
}

pub(super) fn show(printer: &Printer, machine: &str, gain: u32, rows: &[Row]) -> Value {
    printer.line(format!(
        "Paper E, figures 4, 5 and 8, {machine}: raster scan ({SAMPLES} samples, instant turns), S = R = 1e-3, means of the last {CONVERGED} of {RUNS} runs"
    ));
    let first = rows.first().map_or((f64::NAN, f64::NAN), |row| (row.across_rms, row.contour_rms));
    let against = |value: f64, first: f64| format!("{} ({:+.1} %)", um(value), 100.0 * (value / first - 1.0));
    let lines: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            let printed = if row.a == 1.0 { format!("−{gain} %") } else { String::new() };
            vec![
                format!("{:.2}", row.a),
                against(row.across_rms, first.0),
                printed,
                against(row.contour_rms, first.1),
                um(row.axis_rms),
                um(row.effort_rms),
                row.permitted.map_or("–".to_owned(), |permitted| format!("{permitted:.2}")),
            ]
        })
        .collect();
    let header = [
        "a",
        "paper's contour error RMS µm",
        "printed",
        "distance to the path RMS µm",
        "axes' error RMS µm",
        "shift RMS µm",
        "permitted model error",
    ];
    printer.line(table(&header, &lines));
    let rows: Vec<Value> = rows
        .iter()
        .map(|row| {
            json!({
                "a": row.a, "contour_rms_um": row.contour_rms * 1e3, "across_rms_um": row.across_rms * 1e3, "axis_rms_um": row.axis_rms * 1e3,
                "effort_rms_um": row.effort_rms * 1e3, "permitted_model_error": row.permitted,
            })
        })
        .collect();
    json!({ "paper": "E", "table": "figures 4, 5, 8", "machine": machine, "rows": rows })
}
