//! Paper E's simulation (figures 4 to 6 and 8) and the tuning rules of its section III, on a testbed of its orders (eq. 19-20).

use std::sync::Arc;

use anyhow::Result;
use compensation::laws::{NormOptimalIlc, NormOptimalSettings};
use compensation::{CompensationLaw, ImpulseResponse};
use machine::{Machine, Testbed};
use motion::{Cartesian, DesiredPath, Trajectory};
use rayon::prelude::*;
use serde_json::{Value, json};

use super::Reproduce;
use super::corner::{self, Corner, Shown};
use super::found::{Entry, Found, Printed, Section};
use super::raster::{RUNS, Row, SAMPLES, SHARES, across, first_corner, note, raster, rms, section, show};
use crate::output::{Printer, table};

/// What figure 6 is made on.
const CORNER: Shown = Shown { figure: 6, machine: "simulation: the testbed", file: "e-figure-6" };
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
        tables.push(corner::show(printer, CORNER, desired.trajectory(), first_corner(), &corners));
        tables.push(show_rules(printer, &rules));
        let sections = vec![
            section("Figures 4, 5 and 8, simulation: the scan on the testbed", scan_note(), 28.0, &rows, TESTBED),
            corner::section(CORNER, desired.trajectory(), first_corner(), &corners),
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

const TESTBED: &str = "The paper prints the orders of plant and controller (eq. 19-20) but no coefficients, and the scan as a picture without sizes. The gain \
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
    Ok((row, Corner::new(a, first_corner(), &across(desired.trajectory(), actual)?, actual)))
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
        pictures: Vec::new(),
    }
}
