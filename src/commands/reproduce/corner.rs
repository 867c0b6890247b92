//! Paper E, figures 6 and 7: traces at the first corner of the scan.

use motion::Trajectory;
use pipeline::units::um;
use serde_json::{Value, json};

use super::found::{Entry, Printed, Section};
use super::picture::{Line, Panel, Picture, draw};
use crate::output::{Printer, table};

/// Samples before and after the first corner that are shown.
const AROUND: usize = 60;
/// Half the width of the enlarged corner, mm.
const ENLARGED_MM: f64 = 0.15;

/// What the traces were made on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shown {
    /// Figure of the paper.
    pub figure: u32,
    pub machine: &'static str,
    /// File of the picture.
    pub file: &'static str,
}

/// Trace at the corner with one share of the contour error.
pub(super) struct Corner {
    pub a: f64,
    /// Contour error (eq. 1) of every sample, mm.
    errors: Vec<f64>,
    /// Actual positions, mm.
    trace: Vec<Vec<f64>>,
}

impl Corner {
    /// The samples of a run around `corner`; `errors` are the contour errors of all its samples, mm.
    pub(super) fn new(a: f64, corner: usize, errors: &[f64], actual: &Trajectory) -> Self {
        Self { a, errors: errors[around(corner)].to_vec(), trace: trace(actual, corner) }
    }

    /// RMS of the contour error before and after the corner, mm.
    fn sides(&self) -> [f64; 2] {
        let rms = |errors: &[f64]| (errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt();
        let (before, after) = self.errors.split_at(AROUND);
        [rms(before), rms(after)]
    }

    fn name(&self) -> &'static str {
        if self.a == 0.0 { "a = 0, single axes" } else { "a = 1, contour" }
    }
}

fn around(corner: usize) -> std::ops::Range<usize> {
    corner - AROUND..corner + AROUND
}

fn trace(run: &Trajectory, corner: usize) -> Vec<Vec<f64>> {
    run.columns().iter().map(|column| column[around(corner)].to_vec()).collect()
}

pub(super) fn show(printer: &Printer, shown: Shown, desired: &Trajectory, corner: usize, corners: &[Corner]) -> Value {
    printer.line(format!(
        "Paper E, figure {}, {}: the first corner, {AROUND} samples before and after",
        shown.figure, shown.machine
    ));
    let cells = |corner: &Corner| {
        let [before, after] = corner.sides();
        vec![format!("{}", corner.a), um(before), um(after)]
    };
    let lines: Vec<Vec<String>> = corners.iter().map(cells).collect();
    printer.line(table(&["a", "before, RMS µm", "after, RMS µm"], &lines));
    let row = |corner: &Corner| {
        let [before, after] = corner.sides();
        json!({
            "a": corner.a, "before_rms_um": before * 1e3, "after_rms_um": after * 1e3,
            "x_mm": corner.trace[0], "y_mm": corner.trace[1],
        })
    };
    let rows: Vec<Value> = corners.iter().map(row).collect();
    let wanted = trace(desired, corner);
    json!({
        "paper": "E", "table": format!("figure {}", shown.figure), "machine": shown.machine, "rows": rows,
        "desired": { "x_mm": wanted[0], "y_mm": wanted[1] },
    })
}

pub(super) fn section(shown: Shown, desired: &Trajectory, corner: usize, corners: &[Corner]) -> Section {
    const CURVES: &str = "The paper shows the traces without values: single-axis learning leaves the path before the corner and oscillates behind it, \
                          contour learning follows more closely throughout.";
    let entries = corners.iter().flat_map(|corner| {
        let words = |words: &str| if corner.a == 0.0 { Printed::None } else { Printed::Words(words.into()) };
        ["before", "after"].into_iter().zip(corner.sides()).map(move |(side, rms)| {
            Entry::um(
                format!("a = {}: contour error (eq. 1), {AROUND} samples {side}, RMS", corner.a),
                words("smaller than a = 0"),
                rms,
                CURVES,
            )
        })
    });
    Section {
        paper: 'E',
        title: format!("Figure {}: traces at the first corner, {}", shown.figure, shown.machine),
        note: "Positions of every sample are in `--json` (`x_mm`, `y_mm`). With a = 1 the axes pass the corner at another time than planned.".into(),
        entries: entries.collect(),
        pictures: vec![picture(shown, desired, corner, corners)],
    }
}

/// Points of a trace, mm.
type Piece = Vec<(f64, f64)>;

/// The corner as a whole, enlarged, and the contour error over the samples.
fn picture(shown: Shown, desired: &Trajectory, corner: usize, corners: &[Corner]) -> Picture {
    let points = |trace: &[Vec<f64>]| trace[0].iter().copied().zip(trace[1].iter().copied()).collect::<Vec<_>>();
    let wanted = points(&trace(desired, corner));
    let turn = wanted[AROUND];
    let near = |points: &Piece| -> Vec<Piece> {
        let is_near = |point: &(f64, f64)| (point.0 - turn.0).abs() <= ENLARGED_MM && (point.1 - turn.1).abs() <= ENLARGED_MM;
        points.chunk_by(|a, b| is_near(a) == is_near(b)).filter(|piece| is_near(&piece[0])).map(<[_]>::to_vec).collect()
    };
    let of_all = |cut: &dyn Fn(&Piece) -> Vec<Piece>| {
        let desired = Line { name: "desired", pieces: cut(&wanted) };
        let runs = corners.iter().map(|corner| Line { name: corner.name(), pieces: cut(&points(&corner.trace)) });
        std::iter::once(desired).chain(runs).collect::<Vec<_>>()
    };
    let path = |title: &str, lines| Panel { title: title.into(), axes: ("x, mm", "y, mm"), is_path: true, lines };
    let error = |corner: &Corner| {
        let at = |(k, error): (usize, &f64)| (k as f64 - AROUND as f64, error * 1e3);
        Line { name: corner.name(), pieces: vec![corner.errors.iter().enumerate().map(at).collect()] }
    };
    let panels = [
        path("first corner", of_all(&|points| vec![points.clone()])),
        path("enlarged", of_all(&near)),
        Panel {
            title: "contour error".into(),
            axes: ("samples from the corner", "eq. 1, µm"),
            is_path: false,
            lines: corners.iter().map(error).collect(),
        },
    ];
    Picture {
        file: shown.file,
        caption: format!("Figure {}, {}: traces at the first corner, to scale", shown.figure, shown.machine),
        svg: draw(3, &panels),
    }
}
