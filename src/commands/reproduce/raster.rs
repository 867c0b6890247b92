//! Paper E, figures 4 to 6: norm-optimal ILC of a raster scan, from single axes (`a = 0`) to the contour alone (`a = 1`).

use anyhow::Result;
use compensation::{CorrectionLimits, ImpulseResponse, StopRule, learn};
use machine::{MachineSpec, SimulatedMachine};
use motion::{DesiredPath, Trajectory};
use pipeline::model_based_ilc::{PROBE, RESPONSE_S, norm_optimal};
use pipeline::units::um;
use pipeline::{Setup, statistics};
use serde_json::{Value, json};

use super::Reproduce;
use crate::output::{Printer, table};
use crate::read;

/// Samples of the scan, as in the paper.
const SAMPLES: usize = 1050;
/// Rest before and after the scan, samples.
const REST: usize = 13;
/// Length of a line and distance of two, mm.
const LINE_MM: f64 = 12.0;
const SPACING_MM: f64 = 2.0;
/// Learning runs; the figures are means over the last ones.
const RUNS: usize = 12;
const CONVERGED: usize = 4;

/// Converged figures of one weighting; mm.
struct Row {
    a: f64,
    contour_rms: f64,
    across_rms: f64,
    axis_rms: f64,
    effort_rms: f64,
    permitted: f64,
}

impl Reproduce {
    pub(super) fn raster(&self, printer: &Printer) -> Result<Vec<Value>> {
        let spec = read::machine(&self.machine.machine)?;
        let desired = raster(&spec)?;
        let mut rows = Vec::new();
        for a in [0.0, 0.25, 0.5, 0.75, 1.0] {
            let mut row = Row { a, contour_rms: 0.0, across_rms: 0.0, axis_rms: 0.0, effort_rms: 0.0, permitted: 0.0 };
            for seed in self.seeds_used() {
                self.scan(&spec, &desired, seed, &mut row)?;
            }
            rows.push(row);
        }
        Ok(vec![show(printer, &rows)])
    }

    fn scan(&self, spec: &MachineSpec, desired: &DesiredPath, seed: u64, row: &mut Row) -> Result<()> {
        let mut machine = SimulatedMachine::new(spec, seed)?;
        let responses = ImpulseResponse::probe(&mut machine, desired.trajectory(), PROBE, RESPONSE_S)?;
        let mut law = norm_optimal(row.a, responses)?;
        row.permitted += law.permitted_model_error(desired)? / self.seeds as f64;
        let stop = StopRule::after(RUNS);
        let learned = learn(&mut machine, &mut law, desired, None, &CorrectionLimits::default(), &stop, &mut |_, _| 0.0)?;
        let share = 1.0 / (CONVERGED as f64 * self.seeds as f64);
        for round in learned.iterations.iter().rev().take(CONVERGED) {
            row.contour_rms += share * statistics::contour(desired, None, &round.actual)?.rms_mm;
            row.across_rms += share * across(desired.trajectory(), &round.actual)?;
            row.axis_rms += share * rms(desired.trajectory(), &round.actual)?;
            row.effort_rms += share * rms(&round.reference, desired.trajectory())?;
        }
        Ok(())
    }
}

/// Root mean square difference of two runs over the axes and samples, mm.
fn rms(a: &Trajectory, b: &Trajectory) -> Result<f64> {
    let difference: Vec<f64> = a.tracking_error(b)?.concat();
    Ok((difference.iter().map(|d| d * d).sum::<f64>() / difference.len().max(1) as f64).sqrt())
}

/// Root mean square of the paper's contour error (eq. 1): the tracking error across the path's direction at its instant; mm.
fn across(desired: &Trajectory, actual: &Trajectory) -> Result<f64> {
    let error = desired.tracking_error(actual)?;
    let squares = (0..desired.len()).map(|k| {
        let direction = |column: &Vec<f64>| column[(k + 1).min(desired.len() - 1)] - column[k.saturating_sub(1)];
        let tangent: Vec<f64> = desired.columns().iter().map(direction).collect();
        let length: f64 = tangent.iter().map(|t| t * t).sum();
        let along: f64 = tangent.iter().zip(&error).map(|(t, e)| t * e[k]).sum();
        error.iter().map(|e| e[k] * e[k]).sum::<f64>() - if length > 0.0 { along * along / length } else { 0.0 }
    });
    Ok((squares.sum::<f64>() / desired.len() as f64).sqrt())
}

/// Lines to and fro at one speed, with instant turns, which no axis can follow.
fn raster(spec: &MachineSpec) -> Result<DesiredPath> {
    let setup = Setup::new(spec, None)?;
    let step_mm = 40.0 * setup.period_s;
    let (mut points, mut at, mut direction) = (vec![[0.0, 0.0]; REST], [0.0, 0.0], 1.0);
    'scan: loop {
        for (axis, length) in [(0, LINE_MM * direction), (1, SPACING_MM)] {
            let steps = (length.abs() / step_mm).round();
            for _ in 0..steps as usize {
                at[axis] += length / steps;
                points.push(at);
                if points.len() == SAMPLES - REST {
                    break 'scan;
                }
            }
        }
        direction = -direction;
    }
    points.resize(SAMPLES, at);
    let columns = (0..spec.motion_axes().len())
        .map(|axis| points.iter().map(|point| point.get(axis).copied().unwrap_or(0.0)).collect())
        .collect();
    Ok(DesiredPath::new(Trajectory::new(setup.period_s, spec.motion_axes(), columns)?, setup.kinematics)?)
}

fn show(printer: &Printer, rows: &[Row]) -> Value {
    printer.line(format!(
        "Paper E, figures 4 to 6: raster scan ({SAMPLES} samples, 40 mm/s, instant turns), S = R = 1e-3, means of the last {CONVERGED} of {RUNS} runs"
    ));
    let first = rows.first().map_or((f64::NAN, f64::NAN), |row| (row.across_rms, row.contour_rms));
    let against = |value: f64, first: f64| format!("{} ({:+.1} %)", um(value), 100.0 * (value / first - 1.0));
    let lines: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            let printed = if row.a == 1.0 { "−28 % (simulation), −27 % (experiment)" } else { "" };
            vec![
                format!("{:.2}", row.a),
                against(row.across_rms, first.0),
                printed.into(),
                against(row.contour_rms, first.1),
                um(row.axis_rms),
                um(row.effort_rms),
                format!("{:.2}", row.permitted),
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
    json!({ "paper": "E", "table": "figures 4-6", "rows": rows })
}
