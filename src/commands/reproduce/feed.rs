//! Paper B, table I: corners found by the curve-to-chord ratio run slower, the rest faster.

use anyhow::Result;
use compensation::laws::{Gain, SpatialIlc};
use compensation::{CorrectionLimits, StopRule, learn};
use machine::{Machine, MachineSpec, SimulatedMachine};
use motion::contour::{PAPER_B_RATIO, PAPER_B_SUPPORT, corner_flags, stretches};
use motion::curves::library;
use motion::{DesiredPath, Piece, ToolPath};
use pipeline::excitation::{TRAVEL_MM, record};
use pipeline::model_based_ilc::Settings;
use pipeline::training::{TrainSettings, train};
use pipeline::units::um;
use pipeline::{Input, SILENT, Setup, model_based_ilc};
use serde_json::{Value, json};

use super::Reproduce;
use super::found::{self, Entry, Found, Section};
use crate::output::{Printer, table};
use crate::read;

/// Distance of the program's points, mm, among which corners are looked for.
const SPACING_MM: f64 = 0.1;
/// Distances of points for which the number of corners is shown, mm: that of Paper B's samples at 1000 mm/min and 500 Hz; where the ratio of the
/// outer bends, of 3.86 mm radius, just meets the threshold (by a search in steps of 0.00004 mm); and above, while the ellipse has none yet.
const SPACINGS_MM: [f64; 4] = [1000.0 / 60.0 / 500.0, 0.10588, 0.12, 0.2];
/// Learning runs, as printed.
const RUNS: usize = 4;
/// MAX of the first run and of the converged one, µm, and time, s, where the paper prints them.
type Printed = [Option<f64>; 3];
/// Curve, feed of the path and of its corners, mm/min, and what the paper prints: of the ellipse, which has no corners, in section IV-A.
const ROWS: [(&str, f64, Option<f64>, Printed); 6] = [
    ("ellipse", 1000.0, None, [Some(14.5), Some(1.5), None]),
    ("five-petals", 1000.0, None, [Some(25.784), Some(7.240), Some(31.69)]),
    ("five-petals", 1000.0, Some(100.0), [Some(9.213), Some(2.357), Some(38.13)]),
    ("five-petals", 1500.0, Some(100.0), [Some(19.312), Some(2.468), Some(29.89)]),
    ("five-petals", 1500.0, Some(150.0), [None; 3]),
    ("five-petals", 2000.0, Some(200.0), [None; 3]),
];

/// Feeds and figures of a row.
struct Row {
    name: String,
    printed: Printed,
    first_max: f64,
    converged_max: f64,
    compensated_max: f64,
    seconds: f64,
}

impl Reproduce {
    pub(super) fn feed(&self, printer: &Printer) -> Result<Found> {
        let spec = read::machine(&self.machine.machine)?;
        let (corners, ellipse) = (corner_ranges("five-petals", SPACING_MM)?, corner_ranges("ellipse", SPACING_MM)?);
        let logs = record(&spec, self.seconds(), TRAVEL_MM, self.common.seed)?;
        let settings = TrainSettings::of(read::recipe("staged")?, self.common.seed);
        let bundle = train(&logs, Some(&spec), &settings, SILENT)?.bundle;
        let limits = Setup::new(&spec, None)?.limits;
        let mut rows = Vec::new();
        for (curve, feed, corner, printed) in ROWS {
            let of_curve = if curve == "ellipse" { &ellipse } else { &corners };
            let planned = planned(&spec, curve, feed / 60.0, corner.map(|corner| corner / 60.0), of_curve)?;
            let input = Input::path(curve, planned, Some(limits.clone()));
            let desired = input.desired();
            // Noise of its own: the training logs are drawn with the first seed.
            let mut machine = SimulatedMachine::new(&spec, self.common.seed.wrapping_add(1000))?;
            let mut law = SpatialIlc::new(Gain::Constant(0.8), None)?;
            let stop = StopRule::after(RUNS);
            let learned = learn(&mut machine, &mut law, desired, None, &CorrectionLimits::default(), &stop, &mut |_, _| 0.0)?;
            let max = |round: Option<&compensation::Iteration>| -> Result<f64> {
                round.map_or(Ok(f64::NAN), |round| Ok(input.figures(&round.actual)?.tip.max_mm))
            };
            let first = model_based_ilc(&input, &bundle, &Settings::default(), SILENT)?;
            let compensated = machine.run(&first.reference)?;
            rows.push(Row {
                name: corner.map_or(format!("{curve}, {feed}"), |corner| format!("{curve}, {feed}, corners {corner}")),
                printed,
                first_max: max(learned.iterations.first())?,
                converged_max: max(learned.last())?,
                compensated_max: input.figures(&compensated)?.tip.max_mm,
                seconds: desired.trajectory().duration_s(),
            });
        }
        let counts = SPACINGS_MM.map(|spacing_mm| -> Result<_> {
            let count = |curve| corner_ranges(curve, spacing_mm).map(|corners| corners.len());
            Ok((spacing_mm, count("five-petals")?, count("ellipse")?))
        });
        let counts = counts.into_iter().collect::<Result<Vec<_>>>()?;
        let tables = vec![show(printer, &rows, corners.len(), ellipse.len())];
        let mut sections = sections(&rows, corners.len(), ellipse.len());
        sections[0].entries.extend(counts.iter().flat_map(of_spacing));
        Ok(Found { tables, sections })
    }
}

/// Parameter ranges of a curve's corners among points at this distance.
fn corner_ranges(name: &str, spacing_mm: f64) -> Result<Vec<(f64, f64)>> {
    let curve = library::by_name(name)?;
    let (from, to) = curve.domain();
    // Points evenly along the curve: fine steps, of which every one that completes a spacing is taken.
    let fine = 200_000;
    let at = |i: usize| from + (to - from) * i as f64 / fine as f64;
    let (mut parameters, mut points) = (vec![from], vec![curve.point(from)]);
    let (mut way, mut last) = (0.0, points[0]);
    for i in 1..=fine {
        let point = curve.point(at(i));
        way += (point - last).norm();
        last = point;
        if way >= spacing_mm {
            parameters.push(at(i));
            points.push(point);
            way = 0.0;
        }
    }
    let flags = corner_flags(&points, PAPER_B_SUPPORT, PAPER_B_RATIO);
    Ok(stretches(&flags).into_iter().map(|range| (parameters[range.start], parameters[range.end - 1])).collect())
}

/// A curve at one feed, its corners at another.
fn planned(
    spec: &MachineSpec,
    curve: &str,
    feed_mm_s: f64,
    corner_mm_s: Option<f64>,
    corners: &[(f64, f64)],
) -> Result<DesiredPath> {
    let curve = library::by_name(curve)?;
    let setup = Setup::new(spec, None)?;
    let (mut at, end) = curve.domain();
    let mut path = ToolPath::default();
    let mut stretch = |from: f64, to: f64, feed_mm_s: f64| {
        if to > from {
            path.push(Piece { range: (from, to), ..Piece::whole(curve.clone(), feed_mm_s) });
        }
    };
    for (from, to) in corners {
        stretch(at, *from, feed_mm_s);
        stretch(*from, *to, corner_mm_s.unwrap_or(feed_mm_s));
        at = *to;
    }
    stretch(at, end, feed_mm_s);
    let settings = setup.plan_settings();
    Ok(motion::plan(&path, &setup.kinematics, &setup.limits, &settings)?.desired)
}

const MACHINE: &str = "Another machine. The errors of its drives at the tight inner bends are smaller than those of the paper's.";
const CYCLE: &str =
    "The paper does not print its control's acceleration; Paper A, on a like machine, prints 1000 mm/min². Ours is 800 mm/s².";
const OURS: &str = "Not in the paper.";
const CORNERS: &str = "The five inner bends are found. Whether the five outer ones are follows from the distance of the points, which the paper does not print.";
const SPACINGS: &str = "The paper's eight are found where the ratio of the outer bends just meets the threshold, so that some of them are found and others not. \
                        With closer points only the inner bends are corners; with wider ones all ten are, one of them in two parts at the start and end of the path.";

/// Corners of flower and ellipse among points at one distance.
fn of_spacing((spacing_mm, flower, ellipse): &(f64, usize, usize)) -> [Entry; 2] {
    let of = |curve: &str, printed, count: usize| {
        let what = format!("{curve}, points {spacing_mm:.4} mm apart");
        Entry::of(what, "", Some(printed), count as f64, SPACINGS)
    };
    [of("flower", 8.0, *flower), of("fourth-order ellipse", 0.0, *ellipse)]
}

fn sections(rows: &[Row], corners: usize, ellipse: usize) -> Vec<Section> {
    let count = |what: &str, printed: f64, measured: usize, why| Entry::of(what, "", Some(printed), measured as f64, why);
    let found = vec![count("flower", 8.0, corners, CORNERS), count("fourth-order ellipse", 0.0, ellipse, "")];
    let entries = rows.iter().flat_map(|row| {
        let why = if row.printed[0].is_some() { MACHINE } else { OURS };
        let mut entries = vec![
            Entry::um(format!("{}: MAX, first run", row.name), row.printed[0], row.first_max, why),
            Entry::um(format!("{}: MAX, run {}", row.name, RUNS + 1), row.printed[1], row.converged_max, why),
            Entry::um(
                format!("{}: MAX, first run compensated by the model", row.name),
                found::Printed::None,
                row.compensated_max,
                OURS,
            ),
        ];
        let why = if row.printed[2].is_some() { CYCLE } else { OURS };
        entries.push(Entry::of(format!("{}: cycle", row.name), "s", row.printed[2], row.seconds, why));
        entries
    });
    vec![
        Section {
            paper: 'B',
            title: "Figure 13: corners found by the curve-to-chord ratio".into(),
            note: format!("Ratio below {PAPER_B_RATIO} over four points to either side, points every {SPACING_MM} mm."),
            entries: found,
            pictures: Vec::new(),
        },
        Section {
            paper: 'B',
            title: "Table I and section IV-A: feeds of path and corners, mm/min (and figures 9, 10, 12, 14 and 15)".into(),
            note: format!("Spatial ILC, Q = 0.8, {RUNS} updates, references that keep their time."),
            entries: entries.collect(),
            pictures: Vec::new(),
        },
    ]
}

fn show(printer: &Printer, rows: &[Row], corners: usize, ellipse: usize) -> Value {
    printer.line(format!(
        "Paper B, table I: flower r = 25 + 15 cos 5t, curve-to-chord ratio below {PAPER_B_RATIO} (k = 4, points every {SPACING_MM} mm): \
         {corners} corners (printed: 8; the five inner ones, and with points 0.1059 mm apart some of the five outer ones too, whose ratio then is \
         the threshold), on the fourth-order ellipse {ellipse}; spatial ILC, Q = 0.8, {RUNS} runs"
    ));
    let lines: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            let printed = |index: usize| row.printed[index].map_or("–".to_owned(), |printed| printed.to_string());
            vec![
                row.name.clone(),
                printed(0),
                printed(1),
                printed(2),
                um(row.first_max),
                um(row.converged_max),
                um(row.compensated_max),
                format!("{:.2}", row.seconds),
            ]
        })
        .collect();
    let header = [
        "curve, feed mm/min",
        "printed first MAX µm",
        "converged",
        "s",
        "first MAX µm",
        "converged MAX µm",
        "compensated first run MAX µm",
        "s",
    ];
    printer.line(table(&header, &lines));
    let rows: Vec<Value> = rows
        .iter()
        .map(|row| {
            json!({
                "name": row.name,
                "printed": { "first_max_um": row.printed[0], "converged_max_um": row.printed[1], "seconds": row.printed[2] },
                "first_max_um": row.first_max * 1e3, "converged_max_um": row.converged_max * 1e3, "compensated_max_um": row.compensated_max * 1e3,
                "seconds": row.seconds,
            })
        })
        .collect();
    json!({ "paper": "B", "table": "I", "corners": corners, "rows": rows })
}
