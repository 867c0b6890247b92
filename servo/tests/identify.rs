//! Machines drawn at random, identified from their own runs and tried on another one.

use std::sync::Arc;

use machine::{MachineSpec, SimulatedMachine, SimulationOptions};
use motion::curves::library::random_nurbs;
use motion::{Trajectory, plan_curve};
use servo::{Record, Run, Scope, Servo, identify, identify_all, index};

fn planned(spec: &MachineSpec, points: usize, sigma_mm: f64, share: f64, seed: u64) -> Trajectory {
    let curve = Arc::new(random_nurbs(points, sigma_mm, 3, seed).unwrap());
    let feed = share * spec.limits().axes.iter().map(|axis| axis.velocity).fold(f64::INFINITY, f64::min);
    plan_curve(curve, feed, &spec.limits(), &motion::PlanSettings { period_s: spec.sampling_period_s(), ..Default::default() })
        .unwrap()
        .trajectory()
        .clone()
}

/// About a minute of random curves at several feeds.
fn runs(spec: &MachineSpec, seed: u64) -> Vec<(Trajectory, Trajectory)> {
    let machine = SimulatedMachine::new(spec, seed).unwrap();
    let curves = [(10, 18.0, 0.8), (20, 4.0, 0.8), (10, 18.0, 0.4), (8, 8.0, 0.1), (12, 18.0, 0.8), (8, 18.0, 0.6)];
    let run = |((points, sigma_mm, share), seed)| {
        let reference = planned(spec, points, sigma_mm, share, seed);
        let actual = machine.run_with_seed(&reference, seed).unwrap().motor;
        (reference, actual)
    };
    curves.into_iter().zip(100 * seed..).map(run).collect()
}

fn record(runs: &[(Trajectory, Trajectory)], axis: usize) -> Record {
    let run = |(reference, actual): &(Trajectory, Trajectory)| {
        let (reference, actual) = (reference.columns()[axis].clone(), actual.columns()[axis].clone());
        let rows = std::iter::once(0..reference.len()).collect();
        Run { reference, actual, start: None, rows }
    };
    Record { period_s: runs[0].0.period_s(), runs: runs.iter().map(run).collect() }
}

fn rms_um(a: &[f64], b: &[f64]) -> f64 {
    (a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>() / a.len() as f64).sqrt() * 1e3
}

/// Error of the model against the noise-free machine on an unseen curve, of a constant lag, and of a noisy run against the noise-free one.
fn errors_um(spec: &MachineSpec, seed: u64, axis: usize) -> [f64; 3] {
    let record = record(&runs(spec, seed), axis);
    let fit = identify(&record, Scope { sees_backlash: false, whole: true }).unwrap();
    let unseen = planned(spec, 14, 14.0, 0.8, 7000 + seed);
    let machine = SimulatedMachine::new(spec, 1).unwrap();
    let noisy = machine.run_with_seed(&unseen, 900).unwrap().motor;
    let quiet = machine.with_options(SimulationOptions::noise_free()).unwrap().run_with_seed(&unseen, 0).unwrap().motor;
    let (reference, quiet) = (&unseen.columns()[axis], &quiet.columns()[axis]);
    let model = fit.servo.follow(reference, record.period_s);
    let lag = motion::lag_s(reference, quiet, record.period_s).unwrap();
    let late: Vec<f64> =
        (0..reference.len()).map(|k| reference[(k as f64 - lag / record.period_s).round().max(0.0) as usize]).collect();
    [rms_um(&model, quiet), rms_um(&late, quiet), rms_um(&noisy.columns()[axis], quiet)]
}

/// Every row: machine, axis, error of the model, of a constant lag, and the floor, µm.
fn table(seeds: std::ops::Range<u64>) -> Vec<[f64; 3]> {
    let mut rows = Vec::new();
    for seed in seeds {
        let spec = MachineSpec::random(seed).unwrap();
        for axis in 0..3 {
            let row = errors_um(&spec, seed, axis);
            println!("random:{seed} {axis}: model {:.3}, lag {:.2}, floor {:.3} µm", row[0], row[1], row[2]);
            rows.push(row);
        }
    }
    rows
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// The search was made on seeds 1 to 6.
#[test]
fn axes_drawn_at_random_are_followed_nearly_as_well_as_they_repeat() {
    let rows = table(60..62);
    let over_floor = median(rows.iter().map(|[model, _, floor]| model / floor).collect());
    assert!(over_floor < 2.0, "{over_floor}");
    for [model, lag, _] in rows {
        assert!(model < 0.1 * lag, "{model} of {lag}");
    }
}

/// `cargo test --release -p precomp-servo --test identify -- --ignored --nocapture`; `SEEDS=100..120` takes other machines.
#[test]
#[ignore = "minutes"]
fn table_of_random_axes() {
    let range = std::env::var("SEEDS").unwrap_or_else(|_| "60..80".into());
    let (first, last) = range.split_once("..").unwrap();
    let rows = table(first.parse().unwrap()..last.parse().unwrap());
    println!("median of model / floor: {:.2}", median(rows.iter().map(|[model, _, floor]| model / floor).collect()));
}

/// `random:143`: slow axes of one cascade without feed-forward or smoothing, whose smooth logs averaged commands follow as well; one of them creeps
/// under vibrations.
#[test]
fn the_axes_of_a_machine_have_one_control() {
    let spec = MachineSpec::random(143).unwrap();
    let runs = runs(&spec, 143);
    let records: Vec<Record> = (0..3).map(|axis| record(&runs, axis)).collect();
    let fits: Vec<_> = identify_all(&records).into_iter().map(Option::unwrap).collect();
    for fit in &fits {
        assert!(fit.servo.integral > 0.0 && fit.servo.position_integral_1_s == 0.0, "{:?}", fit.servo);
        assert!(fit.servo.command_average_s == 0.0 && fit.servo.command_lag_s == 0.0, "{:?}", fit.servo);
    }
    assert!(fits[1].servo.creep_mm_s > 1e-3, "{}", fits[1].servo.creep_mm_s);
    assert!(fits[1].free.0.contains(&index::CREEP));
}

#[test]
fn a_model_fitted_to_some_rows_is_refitted_to_others() {
    let spec = MachineSpec::random(62).unwrap();
    let all = record(&runs(&spec, 62), 0);
    let fit = identify(&all, Scope { sees_backlash: false, whole: true }).unwrap();
    let mut later = all.clone();
    later.runs.iter_mut().for_each(|run| run.rows[0].start = run.len() / 2);
    let refitted = servo::refit(&fit, &later).unwrap();
    assert_eq!(refitted.free, fit.free);
    assert!(refitted.servo != fit.servo && refitted.mean_square < 4.0 * fit.mean_square);
    assert!(refitted.servo.check().is_ok());
}

/// Many runs that all begin in one place, with other friction elsewhere: the model holds over the whole of the travel.
#[test]
fn friction_beyond_the_first_seconds_of_many_runs_is_fitted() {
    let levels = std::array::from_fn(|place| if place < 12 { 1.0 } else { 1.8 });
    let truth = Servo { levels, ..Servo::usual(40.0, 0.9).with_places(0.0, 120.0) };
    let period_s = 0.004;
    let runs = (0..8).map(|run| {
        // Six seconds to and fro from 10 to 26 mm, then as long from 80 to 96 mm.
        let at = |k: usize| {
            let time = k as f64 * period_s;
            let swing = 8.0 * (1.0 - ((5.0 + f64::from(run)) * time).cos());
            let moved = ((time - 6.0) / 1.5).clamp(0.0, 1.0);
            10.0 + swing + 70.0 * moved * moved * (3.0 - 2.0 * moved)
        };
        let reference: Vec<f64> = (0..3375).map(at).collect();
        let actual = truth.follow(&reference, period_s);
        let rows = std::iter::once(0..reference.len()).collect();
        Run { reference, actual, start: None, rows }
    });
    let record = Record { period_s, runs: runs.collect() };
    let fit = identify(&record, Scope { sees_backlash: false, whole: true }).unwrap();
    let left = |run: &Run| rms_um(&fit.servo.follow(&run.reference, period_s), &run.actual);
    let left: Vec<f64> = record.runs.iter().map(left).collect();
    println!("{left:.3?} µm");
    assert!(left.iter().all(|&left| left < 0.3), "{left:?}");
}

#[test]
fn a_record_that_no_model_follows_has_none() {
    let still =
        Run { reference: vec![1.0; 3000], actual: vec![1.0; 3000], start: None, rows: std::iter::once(0..3000).collect() };
    let scope = Scope { sees_backlash: false, whole: true };
    let still = Record { period_s: 0.002, runs: vec![still] };
    assert!(identify(&still, scope).is_none());
    assert!(identify_all(&[still.clone(), still]).iter().all(Option::is_none));
    assert!(identify_all(&[]).is_empty());
    assert!(identify(&Record { period_s: 0.002, runs: Vec::new() }, scope).is_none());
}
