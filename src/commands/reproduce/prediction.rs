//! Paper D, tables II to IV: what the networks predict, on curves that training never saw.

use anyhow::{Context, Result};
use datasets::Log;
use machine::{Machine, MachineSpec, SimulatedMachine};
use models::{Bundle, FeatureSet};
use pipeline::compare::PAPER_D;
use pipeline::statistics::{contour_errors, rms_max};
use pipeline::units::um;
use pipeline::{Input, Setup};
use serde_json::{Value, json};

use super::Reproduce;
use super::errors_over_time::figure_13;
use super::found::{Entry, Found, Section};
use super::paper_d::only;
use super::trained::Axes;
use crate::output::{Printer, table};
use crate::read;

/// RMS and MAX, mm.
type Figures = (f64, f64);

/// A row: name, printed RMS and MAX in µm (where the paper has them), measured ones.
struct Row {
    name: String,
    printed: Option<Figures>,
    measured: Figures,
    why: &'static str,
}

/// Tracking error of the X axis on the butterfly, and predicted minus measured; mm.
struct ButterflyRun {
    measured: Vec<f64>,
    missed: Vec<f64>,
}

const BUTTERFLY: &str = "Another machine and another butterfly: the paper prints neither feed nor control points. The simulated friction changes \
                         with place, direction and run, which leaves more for the non-linear features to explain.";
const OURS: &str = "Not in the paper.";
const FOUR_CURVES: &str = "Another machine; the paper does not print the parameters of crown, spiral and random NURBS. The peaks lie at reversals, \
                           where the simulated friction differs from the paper's.";
const CONTOUR: &str = "Difference of the magnitudes |ε − ε̂| (eq. 30), on curves of our own parameters.";

impl Reproduce {
    pub(super) fn table_2(&self, printer: &Printer) -> Result<Found> {
        let printed = [
            ("features i", FeatureSet::I, (1.014, 9.003)),
            ("features ii", FeatureSet::Ii, (0.782, 5.777)),
            ("features iii", FeatureSet::Iii, (0.613, 5.256)),
        ];
        let rows = printed
            .into_iter()
            .map(|(name, features, printed)| {
                let measured = self.butterfly_x(self.network("lstm"), features)?;
                Ok(Row { name: format!("LSTM, {name}"), printed: Some(printed), measured, why: BUTTERFLY })
            })
            .collect::<Result<Vec<_>>>()?;
        let title = "X axis of the butterfly, tracking error predicted from three sets of features (and figure 13)";
        let mut found = self.show(printer, "II", title, &rows)?;
        let mut missed = Vec::new();
        let mut measured = Vec::new();
        for (name, features, _) in printed {
            let run = self.butterfly_run(self.network("lstm"), features, self.common.seed)?;
            missed.push((name.to_owned(), run.missed));
            measured = run.measured;
        }
        let spec = read::machine(&self.machine.machine)?;
        let picture = figure_13(Setup::new(&spec, None)?.period_s, &measured, &missed);
        found.sections[0].pictures.push(picture);
        Ok(found)
    }

    pub(super) fn table_3(&self, printer: &Printer) -> Result<Found> {
        let printed = [
            ("NARX", "narx", Some((5.262, 18.52)), BUTTERFLY),
            ("GRU", self.network("gru"), Some((0.709, 5.811)), BUTTERFLY),
            ("LSTM", self.network("lstm"), Some((0.613, 5.256)), BUTTERFLY),
            ("linear law alone", "linear", None, OURS),
            ("precomp, staged", "staged", None, OURS),
        ];
        let rows = printed
            .into_iter()
            .map(|(name, predictor, printed, why)| {
                let measured = self.butterfly_x(predictor, FeatureSet::Iii)?;
                Ok(Row { name: name.to_owned(), printed, measured, why })
            })
            .collect::<Result<Vec<_>>>()?;
        self.show(printer, "III", "X axis of the butterfly, tracking error predicted by three networks", &rows)
    }

    pub(super) fn table_4(&self, printer: &Printer) -> Result<Found> {
        // Crown, spiral, flower, random NURBS: X, Y, Z, contour.
        let printed: [[Figures; 4]; 4] = [
            [(0.623, 4.668), (0.788, 4.729), (0.963, 5.262), (0.651, 3.553)],
            [(0.398, 3.264), (0.450, 3.071), (0.455, 2.958), (0.388, 1.982)],
            [(0.504, 4.424), (0.617, 4.346), (0.721, 4.905), (0.524, 3.644)],
            [(0.396, 3.104), (0.479, 4.051), (0.434, 3.543), (0.365, 2.640)],
        ];
        let spec = read::machine(&self.machine.machine)?;
        let mut rows: Vec<Row> = Vec::new();
        for (title, predictor) in [("LSTM", self.network("lstm")), ("staged", "staged")] {
            let mut sums = [[(0.0, 0.0); 4]; 4];
            for seed in self.seeds_used() {
                let bundle = self.model(Axes::All, predictor, FeatureSet::Iii, seed)?;
                for (sums, name) in sums.iter_mut().zip(PAPER_D) {
                    for (sum, figures) in sums.iter_mut().zip(self.predicted(&spec, &bundle, name, seed)?) {
                        *sum = (sum.0 + figures.0 / self.seeds as f64, sum.1 + figures.1 / self.seeds as f64);
                    }
                }
            }
            for ((name, sums), printed) in PAPER_D.iter().zip(sums).zip(printed) {
                for ((what, measured), printed) in ["x", "y", "z", "contour"].iter().zip(sums).zip(printed) {
                    let (printed, why) = match (title, *what) {
                        ("LSTM", "contour") => (Some(printed), CONTOUR),
                        ("LSTM", _) => (Some(printed), FOUR_CURVES),
                        _ => (None, OURS),
                    };
                    rows.push(Row { name: format!("{title}, {name}, {what}"), printed, measured, why });
                }
            }
        }
        self.show(printer, "IV", "tracking and contour error predicted", &rows)
    }

    /// Prediction error of the X axis of the butterfly: mean RMS and MAX over the seeds.
    fn butterfly_x(&self, predictor: &str, features: FeatureSet) -> Result<Figures> {
        let mut mean = (0.0, 0.0);
        for seed in self.seeds_used() {
            let (rms, max) = rms_max(&self.butterfly_run(predictor, features, seed)?.missed);
            mean = (mean.0 + rms / self.seeds as f64, mean.1 + max / self.seeds as f64);
        }
        Ok(mean)
    }

    fn butterfly_run(&self, predictor: &str, features: FeatureSet, seed: u64) -> Result<ButterflyRun> {
        let spec = read::machine(&self.machine.machine)?;
        let bundle = self.model(Axes::X, predictor, features, seed)?;
        let path = Input::curve("butterfly", 80.0, &Setup::new(&spec, None)?)?;
        let actual = SimulatedMachine::new(&spec, seed.wrapping_add(500))?.run(path.trajectory())?;
        let run = only(&Log::new("butterfly", path.trajectory().clone(), actual)?, 0)?;
        let measured = run.reference.tracking_error(&run.actual)?.swap_remove(0);
        Ok(ButterflyRun { measured, missed: misses(&bundle, &run)?.swap_remove(0) })
    }

    /// Prediction errors of x, y, z and of the contour error, on one curve.
    fn predicted(&self, spec: &MachineSpec, bundle: &Bundle, curve: &str, seed: u64) -> Result<[Figures; 4]> {
        let path = Input::curve(curve, 80.0, &Setup::new(spec, None)?)?;
        let reference = path.trajectory();
        let actual = SimulatedMachine::new(spec, seed.wrapping_add(500))?.run(reference)?;
        let run = Log::new(curve, reference.clone(), actual)?;
        let mut figures = [(0.0, 0.0); 4];
        for (figures, misses) in figures.iter_mut().zip(misses(bundle, &run)?) {
            *figures = rms_max(&misses);
        }
        let measured = contour_errors(path.desired(), &run.actual)?;
        let expected = contour_errors(path.desired(), &bundle.machine()?.run(reference)?)?;
        let off: Vec<f64> = measured.iter().zip(&expected).map(|(m, e)| (m.magnitude_mm - e.magnitude_mm).abs()).collect();
        figures[3] = rms_max(&off);
        Ok(figures)
    }

    fn show(&self, printer: &Printer, number: &str, what: &str, rows: &[Row]) -> Result<Found> {
        printer.line(format!("Paper D, table {number}: {what}"));
        let lines: Vec<Vec<String>> = rows
            .iter()
            .map(|row| {
                let (rms, max) =
                    row.printed.map_or(("–".into(), "–".into()), |(rms, max)| (format!("{rms}"), format!("{max}")));
                vec![row.name.clone(), rms, max, um(row.measured.0), um(row.measured.1)]
            })
            .collect();
        printer.line(table(&["predictor", "printed RMS µm", "printed MAX µm", "RMS µm", "MAX µm"], &lines));
        let entries = rows.iter().flat_map(|row| {
            let entry =
                |figure: &str, printed, measured| Entry::um(format!("{}, {figure}", row.name), printed, measured, row.why);
            [
                entry("MAX", row.printed.map(|(_, max)| max), row.measured.1),
                entry("RMS", row.printed.map(|(rms, _)| rms), row.measured.0),
            ]
        });
        let section = Section {
            paper: 'D',
            title: format!("Table {number}: {what}"),
            note: self.paper_d_note()?,
            entries: entries.collect(),
            pictures: Vec::new(),
        };
        let rows: Vec<Value> = rows
            .iter()
            .map(|row| {
                json!({
                    "name": row.name,
                    "printed": row.printed.map(|(rms, max)| json!({ "rms_um": rms, "max_um": max })),
                    "measured": { "rms_um": row.measured.0 * 1e3, "max_um": row.measured.1 * 1e3 },
                })
            })
            .collect();
        Ok(Found { tables: vec![json!({ "paper": "D", "table": number, "rows": rows })], sections: vec![section] })
    }
}

/// Predicted minus measured tracking error of every axis.
fn misses(bundle: &Bundle, run: &Log) -> Result<Vec<Vec<f64>>> {
    let measured = run.reference.tracking_error(&run.actual)?;
    let predicted = bundle.machine()?.tracking_errors(&run.reference).context("the model")?;
    Ok(predicted.iter().zip(&measured).map(|(p, m)| p.iter().zip(m).map(|(p, m)| p - m).collect()).collect())
}
