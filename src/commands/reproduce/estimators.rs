//! Paper D, table I: contour-error estimators.

use std::time::Instant;

use anyhow::Result;
use machine::{AxisSpec, LinearAxis, Machine, MachineSpec, SimulatedMachine};
use motion::Vec3;
use motion::contour::{ContourEstimator, ContourQuery, ExactOnCurve, TableRow, TimeMatch, sample_estimators, table_row};
use pipeline::{Input, Setup};
use serde_json::{Value, json};

use super::Reproduce;
use super::found::{Entry, Found, Printed, Section};
use crate::output::{Printer, table};
use crate::read;

/// A setting in which the estimators are compared.
struct Setting {
    name: &'static str,
    feed_mm_s: f64,
    /// Time by which the position loops of X, Y, Z trail, ms, instead of what the machine's feed-forward leaves.
    lag_ms: Option<[f64; 3]>,
    /// Sampling rate, Hz, and the samples of the run that make one.
    rates: &'static [(u32, usize)],
}

/// Paper D states neither feed nor lag for its table I. Its figures follow from both: the search is off by up to `vT/10` where the error
/// vanishes (4.9 µm: 25 mm/s), the tangent by `e²κ/2` (12.9 µm at the acceleration limit: about 5 ms).
const SETTINGS: [Setting; 2] = [
    Setting { name: "the machine as it is, 80 mm/s", feed_mm_s: 80.0, lag_ms: None, rates: &[(500, 1), (250, 2), (125, 4)] },
    Setting {
        name: "position loops that trail by 5 ms, 25 mm/s (both inferred from the printed figures)",
        feed_mm_s: 25.0,
        lag_ms: Some([4.95, 5.05, 5.0]),
        rates: &[(500, 1)],
    },
];

impl Reproduce {
    /// Estimation errors on the analytic flower, run on the simulated machine.
    pub(super) fn table_1(&self, printer: &Printer) -> Result<Found> {
        let mut found = Found::default();
        for setting in &SETTINGS {
            let spec = trailing(read::machine(&self.machine.machine)?, setting.lag_ms);
            let path = Input::curve("flat-flower", setting.feed_mm_s, &Setup::new(&spec, None)?)?;
            let actual = SimulatedMachine::new(&spec, self.common.seed)?.run(path.trajectory())?;
            let actual = path.desired().tips_of(&actual)?;
            let desired = path.desired().tips();
            let Some(curve) = path.desired().curve() else { anyhow::bail!("the flower is analytic") };
            for (rate_hz, stride) in setting.rates {
                let thin = |points: &[Vec3]| -> Vec<Vec3> { points.iter().copied().step_by(*stride).collect() };
                let (from, to) = (thin(&actual), thin(&desired));
                let timed = |estimator: &mut dyn ContourEstimator| -> Result<_> {
                    let mut errors = Vec::with_capacity(from.len());
                    // Once to warm buffers and caches up, then the one that counts.
                    estimator.estimate_into(ContourQuery::new(&from, &to, TimeMatch::SAME), &mut errors)?;
                    let started = Instant::now();
                    estimator.estimate_into(ContourQuery::new(&from, &to, TimeMatch::SAME), &mut errors)?;
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
                found.tables.push(show_table_1(printer, setting, *rate_hz, &rows));
                found.sections.push(section(setting, *rate_hz, &rows));
            }
        }
        Ok(found)
    }
}

/// The machine with so much velocity feed-forward that its position loops trail by these times, ms.
fn trailing(mut spec: MachineSpec, lag_ms: Option<[f64; 3]>) -> MachineSpec {
    for (axis, lag_ms) in spec.axes.iter_mut().zip(lag_ms.into_iter().flatten()) {
        if let AxisSpec::Linear(LinearAxis { drive: Some(drive), .. }) = axis {
            drive.loops.feed_forward = (1.0 - drive.loops.position_gain_1_s * lag_ms * 1e-3).max(0.0);
        }
    }
    spec
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

/// Why an estimator's error differs from the printed one.
fn why(estimator: &str, setting: &Setting) -> &'static str {
    if printed_table_1(estimator).is_none() {
        return "Not in the paper.";
    }
    if setting.lag_ms.is_none() {
        return "The paper states neither feed nor lag. Errors of estimators follow from both: see the table with inferred ones.";
    }
    match estimator {
        "hermite-foot" => HERMITE,
        _ => "Feed and lag are inferred from the printed figures, not printed.",
    }
}

const HERMITE: &str = "The foot on a cubic Hermite spline through samples 50 µm apart is exact to 0.3 µm. A spline whose tangents are four chords \
                       long, taken at the chord's share of its foot, would be off by up to √3/6 of the 49 µm from sample to sample: 14.1 µm. Whether the \
                       paper's comparison was made so, it does not say.";

fn section(setting: &Setting, rate_hz: u32, rows: &[TableRow]) -> Section {
    let entries = rows.iter().flat_map(|row| {
        let printed = printed_table_1(row.estimator);
        let why = why(row.estimator, setting);
        let max = Entry::of(
            format!("{}, largest error", row.estimator),
            "µm",
            printed.map_or(Printed::None, |(max, _)| Printed::Value(max)),
            row.max_error_um,
            why,
        );
        let time = printed.map(|(_, seconds)| {
            let time =
                "The paper's time is that of its whole run in another language and on another processor; ours is for one sample.";
            let printed = Printed::Words(format!("{seconds} s a run"));
            Entry::of(format!("{}, time", row.estimator), "ns a sample", printed, row.ns_per_sample, time)
        });
        std::iter::once(max).chain(time)
    });
    Section {
        paper: 'D',
        title: format!("Table I: contour-error estimators on the flower, {rate_hz} Hz, {}", setting.name),
        note: String::new(),
        entries: entries.collect(),
        pictures: Vec::new(),
    }
}

fn show_table_1(printer: &Printer, setting: &Setting, rate_hz: u32, rows: &[TableRow]) -> Value {
    printer.line(format!(
        "Paper D, table I: flower r = 30 + 25 cos 6t, {rate_hz} Hz, {}; largest estimation error and time",
        setting.name
    ));
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
    json!({ "paper": "D", "table": "I", "setting": setting.name, "rate_hz": rate_hz, "rows": rows })
}
