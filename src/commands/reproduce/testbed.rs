//! Paper E's simulation (figures 4 to 6 and 8) and the tuning rules of its section III, on a testbed of its orders (eq. 19-20).

use std::sync::Arc;

use anyhow::Result;
use compensation::laws::{NormOptimalIlc, NormOptimalSettings};
use compensation::{CompensationLaw, ImpulseResponse};
use machine::{Machine, Testbed};
use motion::{Cartesian, DesiredPath, Trajectory};
use pipeline::units::um;
use rayon::prelude::*;
use serde_json::{Value, json};

use super::Reproduce;
use super::found::{Entry, Found, Printed, Section};
use super::raster::{LINE_MM, REST, RUNS, Row, SAMPLES, SHARES, STEP_MM, across, note, raster, rms, section, show};
use crate::output::{Printer, table};

/// Samples before and after the first corner that figures 6 and 7 are read from.
const AROUND: usize = 60;
/// Noise of a run where the rules of section III-D are shown, mm.
const NOISE_MM: f64 = 1e-3;
/// Runs over which the fluctuation by noise is taken, after those that learn.
const NOISY_RUNS: usize = 8;

/// References and actual positions of all runs.
type Runs = Vec<(Trajectory, Trajectory)>;

/// What a tuning rule says and what comes out.
struct Rule {
    what: String,
    unit: &'static str,
    printed: Printed,
    measured: f64,
    why: &'static str,
}

impl Reproduce {
    pub(super) fn testbed(&self, printer: &Printer) -> Result<Found> {
        let axes = Testbed::axes();
        let desired = raster(Testbed::PERIOD_S, &axes, Arc::new(Cartesian::new(axes.clone())))?;
        let seed = self.common.seed;
        let learned = SHARES.par_iter().map(|a| scanned(seed, *a, &desired)).collect::<Result<Vec<_>>>()?;
        let (rows, corners): (Vec<Row>, Vec<Corner>) = learned.into_iter().unzip();
        let corners: Vec<Corner> = corners.into_iter().filter(|corner| corner.a == 0.0 || corner.a == 1.0).collect();
        let rules = self.rules(&desired)?;
        let mut tables = vec![show(printer, "on its testbed", 28, &rows)];
        tables.push(show_corners(printer, &desired, &corners));
        tables.push(show_rules(printer, &rules));
        let sections = vec![
            section("Figures 4, 5 and 8, simulation: the scan on the testbed", scan_note(), 28.0, &rows, TESTBED),
            corner_section(&corners),
            rule_section(rules),
        ];
        Ok(Found { tables, sections })
    }

    /// The rules of section III, each as a figure.
    fn rules(&self, desired: &DesiredPath) -> Result<Vec<Rule>> {
        let seed = self.common.seed;
        let error = |(s, r, updates): &(f64, f64, usize)| -> Result<f64> {
            let settings = NormOptimalSettings { a: 0.0, s: *s, r: *r };
            let runs = iterate(&mut Testbed::new(0.0, 1), law(settings)?, desired, *updates)?;
            runs.last().map_or(Ok(f64::NAN), |(_, actual)| rms(desired.trajectory(), actual))
        };
        let cases = [(1e-3, 0.0, 1), (1e-3, 0.0, 3), (1e-3, 1e-4, SETTLED), (1e-3, 1e-3, SETTLED), (1e-2, 1e-3, SETTLED)];
        let errors = cases.par_iter().map(error).collect::<Result<Vec<f64>>>()?;
        let [one, three, quick, slow, loose] = errors[..] else { anyhow::bail!("five cases have five errors") };
        let noise = [1e-3, 1e-1].par_iter().map(|r| fluctuation(seed, desired, *r)).collect::<Result<Vec<f64>>>()?;
        let rule = |what: &str, unit, printed: Printed, measured, why| Rule { what: what.into(), unit, printed, measured, why };
        Ok(vec![
            rule("R = 0: axes' error after one update", "µm", Printed::None, one * 1e3, ""),
            rule("R = 0: after three updates over after one", "", Printed::Words("1 (deadbeat)".into()), three / one, DEADBEAT),
            rule(
                "S = 1e-3: axes' error with R = 1e-3 over R = 1e-4, settled",
                "",
                Printed::Words("1 (no effect)".into()),
                slow / quick,
                OF_R,
            ),
            rule(
                "R = 1e-3: axes' error with S = 1e-2 over S = 1e-3, settled",
                "",
                Printed::Words("larger than 1".into()),
                loose / slow,
                OF_S,
            ),
            rule("noise: change from run to run, R = 1e-3", "µm", Printed::None, noise[0] * 1e3, ""),
            rule("noise: change from run to run, R = 1e-1", "µm", Printed::Words("smaller".into()), noise[1] * 1e3, OF_NOISE),
        ])
    }
}

/// Updates after which the error no longer changes.
const SETTLED: usize = 12;

const TESTBED: &str = "The paper prints the orders of plant and controller (eq. 19-20) but no coefficients, and the scan as a picture without sizes. The gain \\
                       follows from how far the turns lie above the bandwidth, here 30 Hz.";
const DEADBEAT: &str = "With the testbed's own responses as model the first update reaches the optimum.";
const OF_R: &str = "The settled error is that of eq. 12, which has no R.";
const OF_S: &str = "The paper: performance needs S = 0; S buys robustness.";
const OF_NOISE: &str = "Section III-D: a larger R damps what noise changes from run to run; the paper prints no values.";

fn scan_note() -> String {
    format!(
        "{} Coefficients of eq. 19-20 are our own, no noise, learned with the testbed's own responses.",
        note(Testbed::PERIOD_S)
    )
}

/// The scan learned with this share of the contour error.
fn scanned(seed: u64, a: f64, desired: &DesiredPath) -> Result<(Row, Corner)> {
    let law = law(NormOptimalSettings { a, ..NormOptimalSettings::default() })?;
    let runs = iterate(&mut Testbed::new(0.0, seed), law, desired, RUNS)?;
    let mut row = Row::new(a);
    row.add(desired, runs.iter().map(|(reference, actual)| (reference, actual)), 1.0)?;
    let actual = runs.last().map_or(desired.trajectory(), |(_, actual)| actual);
    Ok((row, Corner::new(a, desired, actual)?))
}

/// RMS change of the reference from run to run once learning has settled, on a testbed with noise; mm.
fn fluctuation(seed: u64, desired: &DesiredPath, r: f64) -> Result<f64> {
    let settings = NormOptimalSettings { a: 0.0, s: 1e-3, r };
    let runs = iterate(&mut Testbed::new(NOISE_MM, seed), law(settings)?, desired, RUNS + NOISY_RUNS)?;
    let settled = &runs[RUNS..];
    let changes = settled.windows(2).map(|pair| rms(&pair[1].0, &pair[0].0)).collect::<Result<Vec<f64>>>()?;
    Ok((changes.iter().map(|change| change * change).sum::<f64>() / changes.len() as f64).sqrt())
}

/// The law with the testbed's own responses.
fn law(settings: NormOptimalSettings) -> Result<NormOptimalIlc> {
    let responses = Testbed::responses(SAMPLES).map(ImpulseResponse::new);
    Ok(NormOptimalIlc::new(settings, responses.into_iter().collect::<Result<_, _>>()?)?)
}

/// Runs and updates without limits of the correction, as in the paper.
fn iterate(machine: &mut Testbed, mut law: NormOptimalIlc, desired: &DesiredPath, updates: usize) -> Result<Runs> {
    let mut reference = desired.trajectory().clone();
    let mut runs = Runs::with_capacity(updates + 1);
    for update in 0..=updates {
        let actual = machine.run(&reference)?;
        let next = if update < updates { law.update(desired, &reference, &actual)? } else { reference.clone() };
        runs.push((std::mem::replace(&mut reference, next), actual));
    }
    Ok(runs)
}

/// Contour error (eq. 1) around the first corner, RMS, mm.
struct Corner {
    a: f64,
    before: f64,
    after: f64,
    /// Actual positions, mm.
    trace: Vec<Vec<f64>>,
}

/// Samples around the first corner.
fn around() -> std::ops::Range<usize> {
    let corner = REST + (LINE_MM / STEP_MM).round() as usize;
    corner - AROUND..corner + AROUND
}

impl Corner {
    fn new(a: f64, desired: &DesiredPath, actual: &Trajectory) -> Result<Self> {
        let errors = across(desired.trajectory(), actual)?;
        let rms = |errors: &[f64]| (errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt();
        let (before, after) = errors[around()].split_at(AROUND);
        Ok(Self { a, before: rms(before), after: rms(after), trace: trace(actual) })
    }
}

fn trace(run: &Trajectory) -> Vec<Vec<f64>> {
    run.columns().iter().map(|column| column[around()].to_vec()).collect()
}

fn show_corners(printer: &Printer, desired: &DesiredPath, corners: &[Corner]) -> Value {
    printer.line(format!("Paper E, figures 6 and 7: the first corner, {AROUND} samples before and after"));
    let lines: Vec<Vec<String>> =
        corners.iter().map(|corner| vec![format!("{}", corner.a), um(corner.before), um(corner.after)]).collect();
    printer.line(table(&["a", "before, RMS µm", "after, RMS µm"], &lines));
    let rows: Vec<Value> = corners
        .iter()
        .map(|corner| {
            json!({
                "a": corner.a, "before_rms_um": corner.before * 1e3, "after_rms_um": corner.after * 1e3,
                "x_mm": corner.trace[0], "y_mm": corner.trace[1],
            })
        })
        .collect();
    let wanted = trace(desired.trajectory());
    json!({ "paper": "E", "table": "figures 6, 7", "rows": rows, "desired": { "x_mm": wanted[0], "y_mm": wanted[1] } })
}

fn corner_section(corners: &[Corner]) -> Section {
    const CURVES: &str = "The paper shows the traces without values: single-axis learning leaves the path before the corner and oscillates behind it, \\
                          contour learning follows more closely throughout.";
    let entries = corners.iter().flat_map(|corner| {
        let words = |words: &str| if corner.a == 0.0 { Printed::None } else { Printed::Words(words.into()) };
        [("before", corner.before), ("after", corner.after)].map(|(side, rms)| {
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
        title: "Figures 6 and 7: traces at the first corner".into(),
        note: "Positions of every sample are in `--json` (`x_mm`, `y_mm`). With a = 1 the axes pass the corner at another time than planned.".into(),
        entries: entries.collect(),
    }
}

fn show_rules(printer: &Printer, rules: &[Rule]) -> Value {
    printer.line("Paper E, section III: what S and R do");
    let printed = |rule: &Rule| match &rule.printed {
        Printed::Words(words) => words.clone(),
        _ => "–".to_owned(),
    };
    let lines: Vec<Vec<String>> =
        rules.iter().map(|rule| vec![rule.what.clone(), printed(rule), format!("{:.4}", rule.measured)]).collect();
    printer.line(table(&["", "printed", "measured"], &lines));
    let rows: Vec<Value> =
        rules.iter().map(|rule| json!({ "name": rule.what, "unit": rule.unit, "measured": rule.measured })).collect();
    json!({ "paper": "E", "table": "section III", "rows": rows })
}

fn rule_section(rules: Vec<Rule>) -> Section {
    let entries = rules.into_iter().map(|rule| Entry::of(rule.what, rule.unit, rule.printed, rule.measured, rule.why));
    Section {
        paper: 'E',
        title: "Section III: deadbeat, S against R, noise".into(),
        note: format!("On the testbed, a = 0; noise of {} µm on every sample where it is named.", NOISE_MM * 1e3),
        entries: entries.collect(),
    }
}
