//! The default predictor on EMPS, a real ball-screw axis at 1 kHz (A. Janot, M. Gautier, M. Brunot,
//! 2019), always tested on held-out data.

mod staged_common;

use models::AxisPredictor;
use models::staged::StagedPredictor;
use staged_common::{first_pass, residual, rms, run_of, shared_log};
use training::network::NetworkRecipe;
use training::stacked;
use training::staged::{AxisRun, StagedRecipe, fit};

const PERIOD_S: f64 = 1e-3;
/// The log starts in motion: its first 300 ms lack their command history.
const UNSCORED: usize = 300;

fn log() -> Option<AxisRun> {
    Some(run_of(&shared_log("emps_train_1kHz.csv")?, 1, 2, PERIOD_S))
}

/// Feed level (42, 82 or 124 mm/s) of the motion that each sample belongs to, from stop to stop.
fn plateaus(reference: &[f64]) -> Vec<u32> {
    let speed = |k: usize| {
        if k == 0 { 0.0 } else { (reference[k] - reference[k - 1]).abs() / PERIOD_S }
    };
    let mut labels = vec![0; reference.len()];
    let mut start = 0;
    while start < reference.len() {
        let moving = (start..reference.len()).find(|&k| speed(k) <= 1.0).unwrap_or(reference.len());
        let end = (moving..reference.len()).find(|&k| speed(k) > 1.0).unwrap_or(reference.len());
        let top = (start..moving).map(speed).fold(0.0, f64::max);
        let label = if top > 100.0 {
            124
        } else if top > 60.0 {
            82
        } else {
            42
        };
        labels[start..end.max(start + 1)].fill(label);
        start = end.max(start + 1);
    }
    labels
}

/// The default predictor, its linear law, and a description.
fn trained(runs: &[AxisRun]) -> (Box<dyn AxisPredictor>, StagedPredictor, String) {
    let (staged, report) = fit(runs, &StagedRecipe::default()).unwrap();
    let recipe = NetworkRecipe::residual();
    let stack = stacked::try_out(&staged, runs, &recipe, 1).unwrap();
    let linear = first_pass(&staged);
    let parts =
        format!("{} + network {:.2} → {:.2} µm: {}", report.chosen, 1e3 * stack.without, 1e3 * stack.with, stack.accepted);
    match stack.accepted {
        true => (stacked::fit(&staged, runs, &recipe, 1).unwrap(), linear, parts),
        false => (Box::new(staged), linear, parts),
    }
}

/// RMS in µm of the predictor and of its first pass on the rows of `plateau`, fitted to all other
/// rows.
fn without_plateau(plateau: u32) -> Option<(f64, f64)> {
    let log = log()?;
    let labels = plateaus(&log.reference);
    let mut runs = Vec::new();
    let mut start = 0;
    while start < labels.len() {
        let end = (start..labels.len()).find(|&k| labels[k] != labels[start]).unwrap_or(labels.len());
        if labels[start] != plateau && end - start > 200 {
            runs.push(AxisRun::new(log.reference[start..end].to_vec(), log.actual[start..end].to_vec(), PERIOD_S));
        }
        start = end;
    }
    let (predictor, linear, parts) = trained(&runs);
    let on_plateau = |residual: Vec<f64>| {
        let rows = residual.into_iter().enumerate().skip(UNSCORED);
        1e3 * rms(rows.filter(|(k, _)| labels[*k] == plateau).map(|(_, e)| e))
    };
    let full = on_plateau(residual(predictor.as_ref(), &log));
    let linear = on_plateau(residual(&linear, &log));
    println!("{plateau} mm/s left out: {parts}; {full:.2} µm, first pass {linear:.2} µm");
    Some((full, linear))
}

#[test]
fn the_second_half_is_predicted_from_the_first() {
    let Some(log) = log() else { return };
    let half = log.reference.len() / 2;
    let first = AxisRun::new(log.reference[..half].to_vec(), log.actual[..half].to_vec(), PERIOD_S);
    let (predictor, linear, parts) = trained(&[first]);
    let left = residual(predictor.as_ref(), &log);
    let error = 1e3 * rms(left[half..].iter().copied());
    let max = 1e3 * left[half..].iter().fold(0.0_f64, |max, e| max.max(e.abs()));
    let linear = 1e3 * rms(residual(&linear, &log)[half..].iter().copied());
    println!("second half: {parts}; {error:.3} | {max:.2} µm, linear {linear:.2} µm");
    assert!(error <= 1.2 && max <= 6.0, "{error} {max}");
    assert!(error < linear);
}

#[test]
fn a_plateau_between_those_known_is_predicted() {
    let Some((full, linear)) = without_plateau(82) else { return };
    assert!(full <= 1.6 && full < linear, "{full} {linear}");
}

#[test]
fn a_plateau_above_those_known_is_predicted() {
    let Some((full, linear)) = without_plateau(124) else { return };
    assert!(full <= 2.0 && full < linear, "{full} {linear}");
}

#[test]
fn a_plateau_below_those_known_is_predicted() {
    let Some((full, linear)) = without_plateau(42) else { return };
    assert!(full <= 4.0 && full < linear, "{full} {linear}");
}
