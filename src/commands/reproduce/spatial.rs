//! Paper A: spatial ILC of the fourth-order ellipse and the five-petalled flower, and tracking-error ILC whose feed is planned anew.

use std::sync::Arc;

use anyhow::Result;
use compensation::laws::{Gain, SpatialIlc, TrackingIlc};
use compensation::{CompensationLaw, CorrectionLimits, StopRule, learn};
use machine::{Machine, MachineSpec, SimulatedMachine};
use motion::curves::Line;
use motion::{DesiredPath, Piece, ToolPath, Trajectory, Vec3};
use pipeline::control::in_step;
use pipeline::units::um;
use pipeline::{Input, Setup, statistics};
use serde_json::{Value, json};

use super::Reproduce;
use crate::output::{Printer, table};
use crate::read;

/// 1000 mm/min.
const FEED_MM_S: f64 = 1000.0 / 60.0;
/// Learning gains.
const GAINS: [f64; 4] = [0.3, 0.8, 1.5, 2.2];
/// Curves and learning runs.
const CURVES: [(&str, usize); 2] = [("ellipse", 5), ("five-petals", 8)];
/// What the paper prints: curve, gain, MAX and RMS of the first run and of the converged one, µm. With the gain 2.2 it only says that the errors
/// diverge.
const PRINTED: [(&str, f64, [f64; 4]); 4] = [
    ("ellipse", 0.3, [6.002, 3.7387, 0.6410, 0.1846]),
    ("ellipse", 0.8, [6.00, 3.74, 0.75, 0.205]),
    ("ellipse", 1.5, [6.002, 3.7387, 0.9820, 0.2686]),
    ("five-petals", 0.8, [25.0, 3.82, 5.0, 0.290]),
];
/// Runs with a feed that is planned anew.
const REPLANNED_RUNS: usize = 3;

/// RMS and MAX of every run, mm.
type Runs = Vec<(f64, f64)>;

impl Reproduce {
    pub(super) fn spatial(&self, printer: &Printer) -> Result<Vec<Value>> {
        let spec = read::machine(&self.machine.machine)?;
        let mut rows: Vec<(String, Option<[f64; 4]>, Runs)> = Vec::new();
        for (curve, updates) in CURVES {
            let desired = Input::curve(curve, FEED_MM_S, &Setup::new(&spec, None)?)?;
            for gain in GAINS {
                let printed = PRINTED.iter().find(|(of, at, _)| (*of, *at) == (curve, gain)).map(|(.., figures)| *figures);
                rows.push((
                    format!("{curve}, spatial, Q = {gain}"),
                    printed,
                    self.learned(&spec, desired.desired(), gain, updates)?,
                ));
            }
        }
        let desired = Input::curve("ellipse", FEED_MM_S, &Setup::new(&spec, None)?)?;
        let laws: [(&str, Box<dyn CompensationLaw>); 2] = [
            ("spatial", Box::new(SpatialIlc::new(Gain::Constant(0.8), None)?)),
            ("tracking error", Box::new(TrackingIlc::new(Gain::Constant(0.8), None))),
        ];
        for (name, mut law) in laws {
            let printed = (name != "spatial").then_some([6.0, f64::NAN, 170.0, f64::NAN]);
            rows.push((
                format!("ellipse, feed planned anew, {name}"),
                printed,
                self.replanned(&spec, desired.desired(), law.as_mut())?,
            ));
        }
        Ok(vec![show(printer, &rows)])
    }

    fn learned(&self, spec: &MachineSpec, desired: &DesiredPath, gain: f64, updates: usize) -> Result<Runs> {
        let mut machine = SimulatedMachine::new(spec, self.common.seed)?;
        let mut law = SpatialIlc::new(Gain::Constant(gain), None)?;
        let stop = StopRule::after(updates);
        let learned = learn(&mut machine, &mut law, desired, None, &CorrectionLimits::default(), &stop, &mut |_, _| 0.0)?;
        learned.iterations.iter().map(|round| figures(desired, &round.actual)).collect()
    }

    /// Each run's reference is a program through the shifted points, whose time the control plans itself.
    fn replanned(&self, spec: &MachineSpec, desired: &DesiredPath, law: &mut dyn CompensationLaw) -> Result<Runs> {
        let mut machine = SimulatedMachine::new(spec, self.common.seed)?;
        let mut points = desired.trajectory().clone();
        let mut runs = Runs::new();
        for _ in 0..=REPLANNED_RUNS {
            let command = planned(&desired.tips_of(&points)?, &Setup::new(spec, None)?)?;
            let actual = machine.run(&command)?;
            // The law sees the run sample by sample beside the points, as if it had kept their time.
            let actual = in_step(&actual, points.len())?;
            runs.push(figures(desired, &actual)?);
            points = law.update(desired, &points, &actual)?;
        }
        Ok(runs)
    }
}

fn figures(desired: &DesiredPath, actual: &Trajectory) -> Result<(f64, f64)> {
    let figures = statistics::contour(desired, None, actual)?;
    Ok((figures.rms_mm, figures.max_mm))
}

/// Straight lines through the points at the programmed feed.
fn planned(points: &[Vec3], setup: &Setup) -> Result<Trajectory> {
    let mut path = ToolPath::default();
    for pair in points.windows(2).filter(|pair| (pair[1] - pair[0]).norm() > 1e-6) {
        path.push(Piece::whole(Arc::new(Line { start: pair[0], end: pair[1] }), FEED_MM_S));
    }
    let settings = setup.plan_settings();
    Ok(motion::plan(&path, &setup.kinematics, &setup.limits, &settings)?.desired.trajectory().clone())
}

fn show(printer: &Printer, rows: &[(String, Option<[f64; 4]>, Runs)]) -> Value {
    printer.line(
        "Paper A: contour error from the first run to the last, feed 1000 mm/min (the paper's law and estimator, no low-pass)",
    );
    let arrow = |first: f64, last: f64| format!("{} → {}", um(first), um(last));
    let lines: Vec<Vec<String>> = rows
        .iter()
        .filter_map(|(name, printed, runs)| {
            let ((rms, max), (last_rms, last_max)) = (runs.first()?, runs.last()?);
            let printed = |first: usize, last: usize| {
                printed.filter(|p| p[first].is_finite()).map_or("–".to_owned(), |p| format!("{} → {}", p[first], p[last]))
            };
            let updates = runs.len() - 1;
            Some(vec![
                name.clone(),
                updates.to_string(),
                printed(1, 3),
                printed(0, 2),
                arrow(*rms, *last_rms),
                arrow(*max, *last_max),
            ])
        })
        .collect();
    printer.line(table(&["curve, law", "updates", "printed RMS µm", "printed MAX µm", "RMS µm", "MAX µm"], &lines));
    let rows: Vec<Value> = rows
        .iter()
        .map(|(name, printed, runs)| {
            let column = |pick: fn(&(f64, f64)) -> f64| runs.iter().map(|run| pick(run) * 1e3).collect::<Vec<f64>>();
            let printed = printed.map(|[max, rms, last_max, last_rms]| {
                let figure = |value: f64| value.is_finite().then_some(value);
                json!({
                    "max_first_um": figure(max), "rms_first_um": figure(rms),
                    "max_converged_um": figure(last_max), "rms_converged_um": figure(last_rms),
                })
            });
            json!({ "name": name, "printed": printed, "rms_by_run_um": column(|run| run.0), "max_by_run_um": column(|run| run.1) })
        })
        .collect();
    json!({ "paper": "A", "table": "ellipse and flower", "rows": rows })
}
