//! Paper D, tables V and VI: contour error before and after pre-compensation, beside converged ILC.

use anyhow::Result;
use pipeline::compare::{CompareSettings, FEED_MM_S, Ilc, Method, PAPER_D, PathComparison, Plant, Tuned, compare_tuned};
use pipeline::excitation::{TRAVEL_MM, record};
use pipeline::training::{TrainSettings, train};
use pipeline::units::um;
use pipeline::{Input, SILENT, Setup};
use serde_json::{Value, json};

use super::Reproduce;
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

impl Reproduce {
    pub(super) fn table_5(&self, printer: &Printer) -> Result<Vec<Value>> {
        let spec = read::machine(&self.machine.machine)?;
        let setup = Setup::new(&spec, None)?;
        let logs = record(&spec, self.seconds, TRAVEL_MM, self.common.seed)?;
        let paths: Vec<Input> =
            PAPER_D.iter().map(|name| Input::curve(name, FEED_MM_S, &setup)).collect::<pipeline::Result<_>>()?;
        let settings = CompareSettings { seeds: self.seeds, seed: self.common.seed, ..CompareSettings::default() };
        let tuned = Tuned::on(Plant::Simulated(&spec), &[Ilc::Spatial], &setup, &settings, SILENT)?;
        let compared = |predictor: &str| -> Result<Vec<PathComparison>> {
            let train_settings = TrainSettings::of(read::recipe(predictor)?, self.common.seed);
            let bundle = train(&logs, Some(&spec), &train_settings, SILENT)?.bundle;
            Ok(compare_tuned(&paths, Plant::Simulated(&spec), Some(&bundle), &settings, &tuned, SILENT)?)
        };
        let by_lstm = compared(self.network("lstm"))?;
        let by_staged = compared("staged")?;
        let mut rows = Vec::new();
        for ((lstm, staged), printed) in by_lstm.iter().zip(&by_staged).zip(PRINTED) {
            let [uncompensated, pre_compensated, ilc] = printed;
            for (what, result, name, printed) in [
                ("uncompensated", lstm, Method::Uncompensated, uncompensated),
                ("LSTM, one shot (the paper)", lstm, Method::OneShot, pre_compensated),
                ("staged, first run (precomp)", staged, Method::FirstRun, None),
                ("converged spatial ILC", staged, Method::Ilc(Ilc::Spatial), ilc),
                ("floor", staged, Method::Floor, None),
            ] {
                if let Some(figures) = result.of(name) {
                    rows.push((format!("{}, {what}", result.name), printed, figures.mean()));
                }
            }
        }
        printer.line("Paper D, tables V and VI: contour error of unseen curves");
        let lines: Vec<Vec<String>> = rows
            .iter()
            .map(|(name, printed, (rms, max))| {
                let (p_rms, p_max) =
                    printed.map_or(("–".into(), "–".into()), |(rms, max)| (format!("{rms}"), format!("{max}")));
                vec![name.clone(), p_rms, p_max, um(*rms), um(*max)]
            })
            .collect();
        printer.line(table(&["curve, method", "printed RMS µm", "printed MAX µm", "RMS µm", "MAX µm"], &lines));
        let rows: Vec<Value> = rows
            .into_iter()
            .map(|(name, printed, (rms, max))| {
                json!({
                    "name": name,
                    "printed": printed.map(|(rms, max)| json!({ "rms_um": rms, "max_um": max })),
                    "measured": { "rms_um": rms * 1e3, "max_um": max * 1e3 },
                })
            })
            .collect();
        Ok(vec![json!({ "paper": "D", "table": "V, VI", "rows": rows })])
    }
}
