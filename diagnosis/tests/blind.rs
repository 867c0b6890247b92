//! A blind test: machines drawn at random with known faults, diagnosed from the logs of the product's own excitation.
//!
//! `cargo test --release -p precomp-diagnosis --test blind -- --ignored --nocapture`; `SEEDS=1000..1040` takes other machines.

mod common;

use std::collections::BTreeMap;

use common::{Patient, logs, patient};
use diagnosis::{Diagnosis, Quantity, Settings, diagnose};

/// Counts of one quantity.
#[derive(Debug, Default)]
struct Tally {
    cases: usize,
    covered: usize,
    unobserved: usize,
    lines: Vec<String>,
}

fn compare(patient: &Patient, found: &Diagnosis, tallies: &mut BTreeMap<&'static str, Tally>) {
    let mut note = |name: &'static str, quantity: Quantity, axis: &str, truth: f64| {
        let tally = tallies.entry(name).or_default();
        let Some(finding) = found.finding(quantity, axis) else { return };
        match finding.estimate {
            Some(estimate) => {
                tally.cases += 1;
                tally.covered += usize::from(estimate.covers(truth));
                tally.lines.push(format!(
                    "{name} {} {axis}: {truth:.4} {:.4} [{:.4} {:.4}]{}",
                    patient.seed,
                    estimate.value,
                    estimate.low,
                    estimate.high,
                    if estimate.covers(truth) { "" } else { " MISS" }
                ));
            }
            None => tally.unobserved += 1,
        }
    };
    for (truth, axis) in patient.truths.iter().zip(&found.axes) {
        note("gain", Quantity::VelocityGain, axis, truth.position_gain_1_s);
        note("lag", Quantity::FollowingLag, axis, 1e3 * truth.lag_s());
        note("feed-forward", Quantity::VelocityFeedForward, axis, truth.feed_forward);
        note("acceleration", Quantity::AccelerationFeedForward, axis, 0.0);
        note("coulomb", Quantity::CoulombFriction, axis, truth.coulomb_um);
        note("stribeck", Quantity::StribeckFriction, axis, truth.stribeck);
        note("backlash", Quantity::Backlash, axis, truth.backlash_um);
    }
    for (i, one) in patient.truths.iter().enumerate() {
        for (j, other) in patient.truths.iter().enumerate().skip(i + 1) {
            let name = format!("{}-{}", found.axes[i], found.axes[j]);
            note("mismatch", Quantity::ServoMismatch, &name, 1e3 * (one.lag_s() - other.lag_s()));
        }
    }
}

fn run(seeds: std::ops::Range<u64>, seconds: f64) -> BTreeMap<&'static str, Tally> {
    let mut tallies = BTreeMap::new();
    for seed in seeds {
        let patient = patient(seed);
        let found = diagnose(&logs(&patient.spec, seconds, seed), &Settings { sensor: patient.sensor, circle: None });
        match found {
            Ok(found) => {
                if std::env::var("VERBOSE").is_ok() {
                    for (model, truth) in found.models.iter().zip(&patient.truths) {
                        println!(
                            "{seed} {:?} {}: {:.2} of {:.2} µm {:?}\n    {:?}",
                            patient.sensor,
                            model.axis,
                            1e3 * model.residual_rms_mm,
                            1e3 * model.tracking_rms_mm,
                            model.servo,
                            truth
                        );
                    }
                }
                compare(&patient, &found, &mut tallies);
            }
            Err(error) => println!("{seed}: {error}"),
        }
    }
    tallies
}

fn print(tallies: &BTreeMap<&'static str, Tally>) {
    for (name, tally) in tallies {
        println!("{name:14} {:4} cases, {:4} within, {:3} not observable", tally.cases, tally.covered, tally.unobserved);
    }
    if std::env::var("VERBOSE").is_ok() {
        tallies.values().flat_map(|tally| &tally.lines).for_each(|line| println!("{line}"));
    }
}

#[test]
#[ignore = "forty machines take minutes; a few are in `few_machines`"]
fn forty_machines() {
    let seeds = std::env::var("SEEDS").unwrap_or_else(|_| "0..40".to_owned());
    let (first, last) = seeds.split_once("..").expect("SEEDS=first..last");
    let tallies = run(first.parse().unwrap()..last.parse().unwrap(), 40.0);
    print(&tallies);
}
