//! Paper D, table I: contour-error estimators.

use std::time::Instant;

use anyhow::Result;
use machine::Machine;
use motion::Vec3;
use motion::contour::{ContourEstimator, ExactOnCurve, TableRow, TimeMatch, sample_estimators, table_row};
use serde_json::{Value, json};

use super::Reproduce;
use crate::input::{self, Frame, Input};
use crate::output::{Printer, table};

impl Reproduce {
    /// Estimation errors on the analytic flower, run at 80 mm/s on the simulated machine.
    pub(super) fn table_1(&self, printer: &Printer) -> Result<Vec<Value>> {
        let spec = input::machine(&self.machine.machine)?;
        let path = Input::curve("flat-flower", 80.0, &Frame::of(&spec))?;
        let actual = input::simulated(&spec, self.common.seed)?.run(path.desired.trajectory())?;
        let actual = path.desired.tips_of(&actual)?;
        let desired = path.desired.tips();
        let Some(curve) = path.desired.curve() else { anyhow::bail!("the flower is analytic") };
        let mut tables = Vec::new();
        for (rate_hz, stride) in [(500, 1), (250, 2), (125, 4)] {
            let thin = |points: &[Vec3]| -> Vec<Vec3> { points.iter().copied().step_by(stride).collect() };
            let (from, to) = (thin(&actual), thin(&desired));
            let timed = |estimator: &mut dyn ContourEstimator| -> Result<_> {
                let mut errors = Vec::with_capacity(from.len());
                // Once to warm buffers and caches up, then the one that counts.
                estimator.estimate_into(&from, &to, TimeMatch::SAME, &mut errors)?;
                let started = Instant::now();
                estimator.estimate_into(&from, &to, TimeMatch::SAME, &mut errors)?;
                Ok((errors, started.elapsed().as_secs_f64()))
            };
            let (truth, truth_s) = timed(&mut ExactOnCurve::new(curve.clone()))?;
            let mut rows: Vec<TableRow> = sample_estimators()
                .iter_mut()
                .map(|estimator| {
                    let (errors, seconds) = timed(estimator.as_mut())?;
                    Ok(table_row(estimator.name(), &errors, &truth, seconds))
                })
                .collect::<Result<_>>()?;
            rows.push(table_row("optimisation on the curve", &truth, &truth, truth_s));
            tables.push(say_table_1(printer, rate_hz, &rows));
        }
        Ok(tables)
    }
}

/// What Paper D prints: largest error, µm, and time, s, for its run of the flower.
fn printed_table_1(estimator: &str) -> Option<(f64, f64)> {
    match estimator {
        "spline-search" => Some((4.9, 4.83)),
        "hermite-foot" => Some((14.1, 3.03)),
        "circle" => Some((7.5, 7.19)),
        "tangent" => Some((12.9, 12.3)),
        "optimisation on the curve" => Some((0.0, 604.0)),
        _ => None,
    }
}

fn say_table_1(printer: &Printer, rate_hz: u32, rows: &[TableRow]) -> Value {
    printer.line(format!("Paper D, table I: flower r = 30 + 25 cos 6t, {rate_hz} Hz; largest estimation error and time"));
    let lines: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            let (max, seconds) = printed_table_1(row.estimator)
                .map_or((String::from("–"), String::from("–")), |(max, s)| (format!("{max}"), format!("{s}")));
            vec![
                row.estimator.to_owned(),
                max,
                format!("{:.5}", row.max_error_um),
                format!("{:.5}", row.rms_error_um),
                seconds,
                format!("{:.0}", row.ns_per_sample),
            ]
        })
        .collect();
    let header = ["estimator", "printed MAX µm", "MAX µm", "RMS µm", "printed s a run", "ns a sample"];
    printer.line(table(&header, &lines));
    let rows: Vec<Value> = rows
        .iter()
        .map(|row| {
            json!({
                "name": row.estimator,
                "printed": printed_table_1(row.estimator).map(|(max, seconds)| json!({ "max_um": max, "seconds": seconds })),
                "measured": { "max_um": row.max_error_um, "rms_um": row.rms_error_um, "ns_per_sample": row.ns_per_sample },
            })
        })
        .collect();
    json!({ "paper": "D", "table": "I", "rate_hz": rate_hz, "rows": rows })
}
