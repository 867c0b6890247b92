//! The S-shaped test piece of ISO 10791-7 on Paper C's machine: not in the paper, but what five-axis machines are accepted by.

use anyhow::Result;
use pipeline::control::ProgramRun;
use pipeline::part::Part;
use pipeline::statistics::{contour_errors_along, counts};
use pipeline::units::um;
use serde_json::{Value, json};

use super::found::{Entry, Found, Printed, Section};
use crate::output::{Printer, table};

/// Feed of the tool tip, mm/min: that of a finishing cut, faster than Paper C's saddle. The standard leaves it to the user.
pub(super) const FEED_MM_MIN: f64 = 2000.0;
/// Learning runs, as on Paper C's saddle.
pub(super) const RUNS: usize = 7;
/// Length before the end of the path that a figure leaves out, mm: the axes overshoot along the path there, off the end of the piece.
const END_MM: f64 = 1.0;
/// Names and units of the errors of a run.
const ERRORS: [(&str, &str); 5] = [
    ("tip MAX", "µm"),
    ("tip mean", "µm"),
    ("direction MAX", "µrad"),
    ("direction mean", "µrad"),
    ("tip MAX before the last millimetre", "µm"),
];

/// Runs of the piece as G-code that the control replans: name and [`ERRORS`].
pub(super) struct SPiece {
    runs: [(String, [f64; 5]); 3],
}

const OURS: &str = "Not in the paper.";
const END: &str = "Not in the paper. At the end of the path, which is not moved, the axes come to it along another line; moving the points before it does not \
                   prevent that. The first run comes to it slowly.";

impl SPiece {
    /// The runs of `part`: uncompensated, the last one of the best law, and the first compensated one.
    pub(super) fn new(
        part: &Part,
        uncompensated: &ProgramRun,
        (law, best_ilc): (&str, &ProgramRun),
        first_run: &ProgramRun,
    ) -> Result<Self> {
        Ok(Self {
            runs: [
                ("uncompensated".to_owned(), errors(part, uncompensated)?),
                (format!("best ILC ({law})"), errors(part, best_ilc)?),
                ("first run, compensated by the model".to_owned(), errors(part, first_run)?),
            ],
        })
    }

    pub(super) fn show(&self, printer: &Printer) -> Found {
        printer.line(format!(
            "S-shaped test piece of ISO 10791-7 on Paper C's machine at {FEED_MM_MIN} mm/min, as G-code; {RUNS} updates of ILC"
        ));
        let cells = |(name, run): &(String, [f64; 5])| {
            let figures = run.iter().zip(self.changes(run));
            let figures = figures.map(|(error, change)| format!("{} ({change:+.1} %)", um(error * 1e-3)));
            std::iter::once(name.clone()).chain(figures).collect()
        };
        let lines: Vec<Vec<String>> = self.runs.iter().map(cells).collect();
        let header: Vec<String> = ERRORS.iter().map(|(name, unit)| format!("{name} {unit}")).collect();
        let header: Vec<&str> = std::iter::once("method").chain(header.iter().map(String::as_str)).collect();
        printer.line(table(&header, &lines));
        Found { tables: vec![self.json()], sections: vec![self.section()] }
    }

    /// Changes of a run against the uncompensated one, %.
    fn changes(&self, run: &[f64; 5]) -> [f64; 5] {
        std::array::from_fn(|k| 100.0 * (run[k] / self.runs[0].1[k] - 1.0))
    }

    fn section(&self) -> Section {
        let why = |index: usize| if index == 4 { END } else { OURS };
        let mut entries = Vec::new();
        for (name, run) in &self.runs {
            let of = ERRORS.iter().zip(run).enumerate();
            entries.extend(of.map(|(index, ((error, unit), value))| {
                Entry::of(format!("{name}, {error}"), unit, Printed::None, *value, why(index))
            }));
        }
        let [.., (_, first_run)] = &self.runs;
        let changes = ERRORS.iter().zip(self.changes(first_run)).enumerate();
        entries.extend(changes.map(|(index, ((error, _), change))| {
            Entry::of(format!("first run against uncompensated, {error}"), "%", Printed::None, change, why(index))
        }));
        Section {
            paper: 'C',
            title: format!("Beyond the paper: S-shaped test piece of ISO 10791-7 at {FEED_MM_MIN} mm/min, as G-code"),
            note: format!(
                "One flank, the tool along its rulings, with control points of our own (`curve:s-piece`): those of the standard are not at hand. Lines as \
                 above, planned anew by the control. ILC: of the six laws above the one with the lowest cost after {RUNS} updates."
            ),
            entries,
            pictures: Vec::new(),
        }
    }

    fn json(&self) -> Value {
        let row = |(name, [tip_max, tip_mean, turn_max, turn_mean, inner_max]): &(String, [f64; 5])| {
            json!({
                "name": name,
                "measured": {
                    "max_um": tip_max, "mean_um": tip_mean, "orientation_max_urad": turn_max, "orientation_mean_urad": turn_mean,
                    "max_before_end_um": inner_max,
                },
            })
        };
        let rows: Vec<Value> = self.runs.iter().map(row).collect();
        json!({ "paper": "C", "table": "S-shaped test piece", "curve": "s-piece", "feed_mm_min": FEED_MM_MIN, "given": "programs", "rows": rows })
    }
}

/// [`ERRORS`] of a run in their units.
fn errors(part: &Part, run: &ProgramRun) -> Result<[f64; 5]> {
    let tip = &run.figures.tip;
    let (max_rad, mean_rad) = run.figures.orientation.map_or((f64::NAN, f64::NAN), |o| (o.max_rad, o.mean_rad));
    Ok([tip.max_mm * 1e3, tip.mean_mm * 1e3, max_rad * 1e6, mean_rad * 1e6, before_end_mm(part, run)? * 1e3])
}

/// Largest error of the tip before the last [`END_MM`] of the path, mm.
fn before_end_mm(part: &Part, run: &ProgramRun) -> Result<f64> {
    let desired = &part.plan.desired;
    let tips = desired.tips();
    let mut left_mm = vec![0.0; tips.len()];
    for k in (1..tips.len()).rev() {
        left_mm[k - 1] = left_mm[k] + (tips[k] - tips[k - 1]).norm();
    }
    let (errors, positions) = contour_errors_along(desired, &run.run.command, &run.run.actual)?;
    let samples = positions.iter().map(|position| position.round() as usize).zip(&errors);
    let inner = samples.filter(|(sample, _)| counts(Some(part), *sample) && left_mm[*sample] > END_MM);
    Ok(inner.map(|(_, error)| error.magnitude_mm).fold(0.0, f64::max))
}
