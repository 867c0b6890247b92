//! Paper A: spatial ILC of the fourth-order ellipse and the five-petalled flower, and tracking-error ILC whose feed is planned anew.
//!
//! Once as the paper has it, with programs of G01 lines whose time the control plans itself, and once with references that keep their time.

use std::sync::Arc;

use anyhow::Result;
use compensation::laws::{Gain, SpatialIlc, TrackingIlc};
use compensation::{CompensationLaw, CorrectionLimits, StopRule, learn};
use machine::{Machine, MachineSpec, SimulatedMachine};
use motion::contour::{ContourError, summary_by_length};
use motion::curves::Line;
use motion::{DesiredPath, Piece, ToolPath, Trajectory, Vec3};
use pipeline::control::{MOVE_POINTS, Pairing, ProgramRun, curve_program_in_steps, in_step, learn_program};
use pipeline::part::Part;
use pipeline::statistics::{contour_errors, contour_errors_along, counts};
use pipeline::units::um;
use pipeline::{Input, Setup};
use serde_json::{Value, json};

use super::found::{Entry, Found, Printed, Section};
use super::{Reproduce, shapes};
use crate::output::{Printer, table};
use crate::read;

/// 1000 mm/min.
const FEED_MM_S: f64 = 1000.0 / 60.0;
/// Step of the curves' parameter between two points of a program.
const STEP: f64 = 0.005;
/// Curves, learning gains and learning runs.
const CURVES: [(&str, &[f64], usize); 2] = [("ellipse", &[0.3, 0.8, 1.5, 2.2], 5), ("five-petals", &[0.8], 8)];
/// What the paper prints: curve, gain, MAX and RMS of the first run and of the converged one, µm. With the gain 2.2 it only says that the errors
/// diverge.
const PRINTED: [(&str, f64, [f64; 4]); 4] = [
    ("ellipse", 0.3, [6.002, 3.7387, 0.6410, 0.1846]),
    ("ellipse", 0.8, [6.00, 3.74, 0.75, 0.205]),
    ("ellipse", 1.5, [6.002, 3.7387, 0.9820, 0.2686]),
    ("five-petals", 0.8, [25.0, 3.82, 5.0, 0.290]),
];
/// Curve, gain, file and numbers of the figures that show references.
const SHAPES: [(&str, f64, &str, &str); 2] =
    [("ellipse", 0.8, "a-figures-13-14", "13 and 14"), ("five-petals", 0.8, "a-figures-15-16", "15 and 16")];
/// Runs with a feed that is planned anew.
const REPLANNED_RUNS: usize = 3;

/// RMS over the path's length and MAX of every run, mm.
type Runs = Vec<(f64, f64)>;

/// What the machine is given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Given {
    /// Programs of G01 lines.
    Programs,
    /// Positions, one a sample.
    Samples,
}

/// A curve learned with one law.
struct Row {
    given: Given,
    name: String,
    printed: Option<[f64; 4]>,
    diverges: bool,
    runs: Runs,
}

impl Reproduce {
    pub(super) fn spatial(&self, printer: &Printer) -> Result<Found> {
        let spec = read::machine(&self.machine.machine)?;
        let (mut rows, mut pictures) = (Vec::new(), Vec::new());
        for given in [Given::Programs, Given::Samples] {
            for (curve, gains, updates) in CURVES {
                for &gain in gains {
                    let printed = PRINTED.iter().find(|(of, at, _)| (*of, *at) == (curve, gain)).map(|(.., figures)| *figures);
                    let runs = match given {
                        Given::Programs => {
                            let (part, runs) = self.learned_on_programs(&spec, curve, gain, updates)?;
                            if let Some((.., file, numbers)) = SHAPES.iter().find(|(of, at, ..)| (*of, *at) == (curve, gain)) {
                                pictures.push(shapes::picture(file, numbers, &part, &runs)?);
                            }
                            runs.iter().map(|run| figures_of_program(&part, run)).collect::<Result<_>>()?
                        }
                        Given::Samples => self.learned_on_samples(&spec, curve, gain, updates)?,
                    };
                    let name = format!("{curve}, spatial, Q = {gain}");
                    rows.push(Row { given, name, printed, diverges: gain > 2.0, runs });
                }
            }
        }
        let desired = Input::curve("ellipse", FEED_MM_S, &Setup::new(&spec, None)?)?;
        let laws: [(&str, Box<dyn CompensationLaw>); 2] = [
            ("spatial", Box::new(SpatialIlc::new(Gain::Constant(0.8), None)?)),
            ("tracking error", Box::new(TrackingIlc::new(Gain::Constant(0.8), None))),
        ];
        for (name, mut law) in laws {
            let printed = (name != "spatial").then_some([6.0, f64::NAN, 170.0, f64::NAN]);
            let runs = self.replanned(&spec, desired.desired(), law.as_mut())?;
            let name = format!("ellipse, every sample a line, paired by time, {name}");
            rows.push(Row { given: Given::Programs, name, printed, diverges: false, runs });
        }
        let mut sections = sections(&rows);
        sections[0].pictures = pictures;
        Ok(Found { tables: vec![show(printer, &rows)], sections })
    }

    fn learned_on_samples(&self, spec: &MachineSpec, curve: &str, gain: f64, updates: usize) -> Result<Runs> {
        let input = Input::curve(curve, FEED_MM_S, &Setup::new(spec, None)?)?;
        let desired = input.desired();
        let mut machine = SimulatedMachine::new(spec, self.common.seed)?;
        let mut law = SpatialIlc::new(Gain::Constant(gain), None)?;
        let stop = StopRule::after(updates);
        let learned = learn(&mut machine, &mut law, desired, None, &CorrectionLimits::default(), &stop, &mut |_, _| 0.0)?;
        learned.iterations.iter().map(|round| figures(desired, &round.actual)).collect()
    }

    fn learned_on_programs(&self, spec: &MachineSpec, curve: &str, gain: f64, updates: usize) -> Result<(Part, Vec<ProgramRun>)> {
        let part = curve_program_in_steps(curve, FEED_MM_S, STEP, &Setup::new(spec, None)?)?;
        let mut machine = SimulatedMachine::new(spec, self.common.seed)?;
        let mut law = SpatialIlc::new(Gain::Constant(gain), None)?;
        let runs =
            learn_program(&part, &mut machine, &mut law, (Pairing::Place, MOVE_POINTS), updates, &CorrectionLimits::default())?;
        Ok((part, runs))
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

/// RMS over the path's length and MAX of the feed moves; the rapid to the first point does not count.
fn figures_of_program(part: &Part, run: &ProgramRun) -> Result<(f64, f64)> {
    let desired = &part.plan.desired;
    let (errors, positions) = contour_errors_along(desired, &run.run.command, &run.run.actual)?;
    let tips = desired.tips_of(&run.run.actual)?;
    let feeds = |k: &usize| counts(Some(part), positions[*k].round() as usize);
    let (errors, tips): (Vec<_>, Vec<_>) = (0..tips.len()).filter(feeds).map(|k| (errors[k], tips[k])).unzip();
    by_length(&errors, &tips)
}

fn figures(desired: &DesiredPath, actual: &Trajectory) -> Result<(f64, f64)> {
    by_length(&contour_errors(desired, actual)?, &desired.tips_of(actual)?)
}

/// RMS over the length of the path, as Paper A defines it, and MAX.
fn by_length(errors: &[ContourError], tips: &[Vec3]) -> Result<(f64, f64)> {
    let Some(summary) = summary_by_length(errors, tips) else { anyhow::bail!("a run without samples has no error") };
    Ok((summary.rms_mm, summary.max_mm))
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

const MACHINE: &str = "Another machine: its drives, tuned to Paper D's errors at 80 mm/s, trail less at this feed.";
const NOISE: &str = "What remains is run-to-run noise, amplified by the gain; it has the size of the paper's.";
const FLOWER: &str =
    "The bends, which keep 5 µm on the paper's machine, err less from the start and are learned within the updates.";
const REPLANNED: &str = "Time-domain learning of a path whose time changes with every run: the error grows as in the paper. How much depends on how the \
                         control changes the time, here by far more.";
const DIVERGES: &str = "The paper prints no values, only that RMS and MAX diverge; their growth depends on the updates made.";

fn why(row: &Row, learned: bool) -> &'static str {
    match row.printed {
        _ if row.diverges => DIVERGES,
        None => "Not in the paper: the spatial law on the same lines.",
        Some([_, rms, ..]) if rms.is_nan() => REPLANNED,
        Some(_) if learned && row.name.starts_with("five") => FLOWER,
        Some(_) if learned => NOISE,
        Some(_) => MACHINE,
    }
}

fn entries(row: &Row) -> Vec<Entry> {
    let (Some((rms, max)), Some((last_rms, last_max))) = (row.runs.first(), row.runs.last()) else { return Vec::new() };
    let printed = |index: usize| match row.printed {
        _ if row.diverges && index > 1 => Printed::Words("diverges".into()),
        printed => Printed::from(printed.map(|values| values[index])),
    };
    let entry = |run: usize, figure: &str, index: usize, measured: f64| {
        Entry::um(format!("{}: {figure}, run {run}", row.name), printed(index), measured, why(row, index > 1))
    };
    let last = row.runs.len();
    vec![entry(1, "MAX", 0, *max), entry(1, "RMS", 1, *rms), entry(last, "MAX", 2, *last_max), entry(last, "RMS", 3, *last_rms)]
}

fn sections(rows: &[Row]) -> Vec<Section> {
    let section = |given: Given, title: &str, note: &str| Section {
        paper: 'A',
        title: title.into(),
        note: note.into(),
        entries: rows.iter().filter(|row| row.given == given).flat_map(entries).collect(),
        pictures: Vec::new(),
    };
    vec![
        section(
            Given::Programs,
            "Section IV-B, figures 8 to 19: programs of G01 lines",
            "1000 mm/min, points every 0.005 in the curve's parameter, RMS over the path's length, as printed. The acceleration is the machine's: \
             the 1000 mm/min² of the paper would take a minute to reach the feed.",
        ),
        section(
            Given::Samples,
            "The same with references that keep their time",
            "Not in the paper; the same laws without a control that plans anew.",
        ),
    ]
}

fn show(printer: &Printer, rows: &[Row]) -> Value {
    printer.line(
        "Paper A: contour error from the first run to the last, feed 1000 mm/min (the paper's law and estimator, no low-pass)",
    );
    let arrow = |first: f64, last: f64| format!("{} → {}", um(first), um(last));
    let lines: Vec<Vec<String>> = rows
        .iter()
        .filter_map(|row| {
            let ((rms, max), (last_rms, last_max)) = (row.runs.first()?, row.runs.last()?);
            let printed = |first: usize, last: usize| {
                row.printed.filter(|p| p[first].is_finite()).map_or("–".to_owned(), |p| format!("{} → {}", p[first], p[last]))
            };
            Some(vec![
                row.label(),
                (row.runs.len() - 1).to_string(),
                printed(1, 3),
                printed(0, 2),
                arrow(*rms, *last_rms),
                arrow(*max, *last_max),
            ])
        })
        .collect();
    printer.line(table(&["curve, law", "updates", "printed RMS µm", "printed MAX µm", "RMS µm", "MAX µm"], &lines));
    json!({ "paper": "A", "table": "ellipse and flower", "rows": rows.iter().map(Row::json).collect::<Vec<_>>() })
}

impl Row {
    fn label(&self) -> String {
        match self.given {
            Given::Programs => format!("{}, as G-code", self.name),
            Given::Samples => self.name.clone(),
        }
    }

    fn json(&self) -> Value {
        let column = |pick: fn(&(f64, f64)) -> f64| self.runs.iter().map(|run| pick(run) * 1e3).collect::<Vec<f64>>();
        let printed = self.printed.map(|[max, rms, last_max, last_rms]| {
            let figure = |value: f64| value.is_finite().then_some(value);
            json!({
                "max_first_um": figure(max), "rms_first_um": figure(rms),
                "max_converged_um": figure(last_max), "rms_converged_um": figure(last_rms),
            })
        });
        json!({
            "name": self.label(), "printed": printed, "rms_by_run_um": column(|run| run.0), "max_by_run_um": column(|run| run.1),
        })
    }
}
