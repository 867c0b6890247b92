//! Paper D, tables V and VI: contour error before and after pre-compensation, beside converged ILC.

use anyhow::Result;
use models::FeatureSet;
use pipeline::compare::{CompareSettings, FEED_MM_S, Ilc, Method, PAPER_D, PathComparison, Plant, Tuned, compare_tuned};
use pipeline::units::um;
use pipeline::{Input, SILENT, Setup};
use serde_json::{Value, json};

use super::Reproduce;
use super::found::{Entry, Found, Section};
use super::trained::Axes;
use crate::output::{Printer, table};
use crate::read;

/// RMS and MAX, µm, as printed.
type Printed = Option<(f64, f64)>;

/// Uncompensated, pre-compensated, converged ILC on each of [`PAPER_D`].
const PRINTED: [[Printed; 3]; 4] = [
    [Some((7.361, 11.894)), Some((0.527, 2.354)), None],
    [Some((5.994, 9.734)), Some((0.399, 2.004)), None],
    [Some((5.401, 11.135)), Some((0.544, 2.919)), None],
    [Some((5.172, 9.435)), Some((0.497, 2.209)), Some((0.384, 1.701))],
];

const MACHINE: &str = "Another machine, tuned to errors of this size; the paper does not print the curves' parameters.";
const SHOT: &str = "The paper's network on another machine: what it does not predict stays as contour error.";
const ILC: &str = "Spatial ILC with tuned gain and low-pass, eighth run; the paper does not name its law.";
const OURS: &str = "Not in the paper.";

/// Curve, method, printed and measured figures, why they differ.
struct Row {
    curve: String,
    method: &'static str,
    printed: Printed,
    measured: (f64, f64),
    why: &'static str,
}

impl Reproduce {
    pub(super) fn table_5(&self, printer: &Printer) -> Result<Found> {
        let spec = read::machine(&self.machine.machine)?;
        let setup = Setup::new(&spec, None)?;
        let paths: Vec<Input> =
            PAPER_D.iter().map(|name| Input::curve(name, FEED_MM_S, &setup)).collect::<pipeline::Result<_>>()?;
        let settings = CompareSettings { seeds: self.seeds, seed: self.common.seed, ..CompareSettings::default() };
        let tuned = Tuned::on(Plant::Simulated(&spec), &[Ilc::Spatial], &setup, &settings, SILENT)?;
        let compared = |predictor: &str| -> Result<Vec<PathComparison>> {
            let bundle = self.model(Axes::All, predictor, FeatureSet::Iii, self.common.seed)?;
            Ok(compare_tuned(&paths, Plant::Simulated(&spec), Some(&bundle), &settings, &tuned, SILENT)?)
        };
        let by_lstm = compared(self.network("lstm"))?;
        let by_staged = compared("staged")?;
        let mut rows = Vec::new();
        for ((lstm, staged), [uncompensated, pre_compensated, ilc]) in by_lstm.iter().zip(&by_staged).zip(PRINTED) {
            for (method, result, name, printed, why) in [
                ("uncompensated", lstm, Method::Uncompensated, uncompensated, MACHINE),
                ("LSTM, one shot (the paper)", lstm, Method::OneShot, pre_compensated, SHOT),
                ("staged, first run (precomp)", staged, Method::FirstRun, None, OURS),
                ("converged spatial ILC", staged, Method::Ilc(Ilc::Spatial), ilc, if ilc.is_some() { ILC } else { OURS }),
                ("floor", staged, Method::Floor, None, OURS),
            ] {
                if let Some(figures) = result.of(name) {
                    rows.push(Row { curve: result.name.clone(), method, printed, measured: figures.mean(), why });
                }
            }
        }
        show(printer, &rows);
        let mut section = self.section(&rows)?;
        if let (Some(path), Some(result)) = (paths.last(), by_lstm.last()) {
            let bundle = self.model(Axes::All, self.network("lstm"), FeatureSet::Iii, self.common.seed)?;
            let ilc = result.runs.iter().find(|run| run.name == Ilc::Spatial.name());
            section.pictures = self.figures_14_and_15(&spec, &bundle, path, ilc)?;
        }
        Ok(Found { tables: vec![json(&rows)], sections: vec![section] })
    }

    fn section(&self, rows: &[Row]) -> Result<Section> {
        let entries = rows.iter().flat_map(|row| {
            let entry = |figure: &str, printed: Option<f64>, measured| {
                Entry::um(format!("{}, {}, {figure}", row.curve, row.method), printed, measured, row.why)
            };
            [
                entry("MAX", row.printed.map(|(_, max)| max), row.measured.1),
                entry("RMS", row.printed.map(|(rms, _)| rms), row.measured.0),
            ]
        });
        let note = format!("{} Table VI is the paper's random NURBS, here `nurbs-1`, with converged ILC.", self.paper_d_note()?);
        let title = "Tables V and VI: contour error without and with pre-compensation, and of ILC (and figures 14 and 15)".into();
        Ok(Section { paper: 'D', title, note, entries: entries.collect(), pictures: Vec::new() })
    }
}

fn show(printer: &Printer, rows: &[Row]) {
    printer.line("Paper D, tables V and VI: contour error of unseen curves");
    let lines: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            let (p_rms, p_max) =
                row.printed.map_or(("–".into(), "–".into()), |(rms, max)| (format!("{rms}"), format!("{max}")));
            vec![format!("{}, {}", row.curve, row.method), p_rms, p_max, um(row.measured.0), um(row.measured.1)]
        })
        .collect();
    printer.line(table(&["curve, method", "printed RMS µm", "printed MAX µm", "RMS µm", "MAX µm"], &lines));
}

fn json(rows: &[Row]) -> Value {
    let rows: Vec<Value> = rows
        .iter()
        .map(|row| {
            json!({
                "name": format!("{}, {}", row.curve, row.method),
                "printed": row.printed.map(|(rms, max)| json!({ "rms_um": rms, "max_um": max })),
                "measured": { "rms_um": row.measured.0 * 1e3, "max_um": row.measured.1 * 1e3 },
            })
        })
        .collect();
    json!({ "paper": "D", "table": "V, VI", "rows": rows })
}
