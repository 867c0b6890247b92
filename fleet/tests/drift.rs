//! Detection of faults and false alarms on simulated machines.
//!
//! `cargo test --release -p precomp-fleet --test drift -- --ignored --nocapture`; `SEEDS=7000..7010` takes other machines, `DAYS=30` more healthy days that
//! are watched, `MINUTES=1` shorter logs a day.

use std::collections::BTreeSet;
use std::path::Path;

use fleet::{AxisDay, Fault, Limits, MachineFolder, Quantity, SimulatedFleet, Store, TrainSettings, WatchSettings, train, watch};
use machine::{AxisSpec, MachineSpec, Sensor};
use pipeline::excitation::{TRAVEL_MM, record};
use pipeline::{Recipe, SILENT};

/// Days of the training, healthy days after it.
const TRAINING: usize = 2;
const HEALTHY: usize = 8;
/// False alarms a machine and 30 days that are accepted.
const FALSE_ALARMS: f64 = 0.5;
/// Days on which all axes have a fault.
const FAULTS: [(&str, &str); 2] = [("2027-01-01", "friction=20"), ("2027-01-02", "backlash=5")];

/// Counts over machines.
#[derive(Debug, Default)]
struct Tally {
    machines: usize,
    /// Healthy machine-days that were watched, alarms on them, and machine-days with one.
    days: usize,
    false_alarms: usize,
    alarmed_days: usize,
    /// For each fault: axes with it, those with an alarm, those with an alarm of this quantity.
    faults: [[usize; 3]; 2],
    lines: Vec<String>,
}

/// Whether a scale at the table sees the backlash of an axis that can have some.
fn shows_backlash(spec: &MachineSpec) -> bool {
    let elastic =
        |axis: &AxisSpec| matches!(axis, AxisSpec::Linear(axis) if axis.drive.as_ref().is_some_and(|drive| !drive.screw.rigid));
    spec.sensor == Sensor::Table && spec.axes.iter().all(elastic)
}

/// A machine with healthy days, and a day with each fault on all axes.
fn simulate(root: &Path, seed: u64, days: usize, minutes: f64) -> (MachineFolder, bool) {
    let first = "2026-01-01".parse().unwrap();
    let plan = SimulatedFleet { machines: 1, minutes, days: TRAINING + HEALTHY + days, first, seed, faults: Vec::new() };
    plan.write_machine(root, 0, &mut |_| ()).unwrap();
    let machine = Store::new(root).machines(&[]).unwrap().swap_remove(0);
    let healthy = plan.description(0).unwrap();
    for (index, (date, fault)) in FAULTS.iter().enumerate() {
        if index == 1 && !shows_backlash(&healthy) {
            continue;
        }
        let mut spec = healthy.clone();
        for axis in ["x", "y", "z"] {
            format!("1:{axis}:{fault}@1").parse::<Fault>().unwrap().apply(&mut spec).unwrap();
        }
        for log in record(&spec, 60.0 * minutes, TRAVEL_MM, seed * 7919 + index as u64).unwrap() {
            let path = machine.path.join(format!("date={date}")).join(format!("{}.parquet", log.name));
            datasets::write_all(&[(path.clone(), datasets::log_content(&path, &log).unwrap())]).unwrap();
        }
    }
    (machine, shows_backlash(&healthy))
}

fn settings(predictor: &str) -> TrainSettings {
    TrainSettings {
        recipe: Recipe::builtin(predictor).unwrap(),
        days: TRAINING,
        healthy_days: HEALTHY,
        most_samples: 120_000,
        most_samples_a_day: 1_000_000,
        sensor: None,
        seed: 1,
    }
}

fn count(rows: &[AxisDay], tally: &mut Tally) {
    let watched = rows.iter().filter(|row| row.phase == fleet::Phase::Watched);
    let (mut days, mut alarmed) = (BTreeSet::new(), BTreeSet::new());
    for row in watched {
        let alarms: Vec<Quantity> = row.alarms().collect();
        let fault = FAULTS.iter().position(|(date, _)| *date == row.date);
        match fault {
            Some(fault) => {
                let wanted = [Quantity::Friction, Quantity::Backlash][fault];
                let found = [1, usize::from(!alarms.is_empty()), usize::from(alarms.contains(&wanted))];
                (0..3).for_each(|i| tally.faults[fault][i] += found[i]);
            }
            None => {
                days.insert(&row.date);
                tally.false_alarms += alarms.len();
                if !alarms.is_empty() {
                    alarmed.insert(&row.date);
                }
            }
        }
        let changes: Vec<String> =
            row.changes.iter().map(|(quantity, change)| format!("{} {:.2}", quantity.name(), change.score())).collect();
        if fault.is_some() || !alarms.is_empty() {
            tally.lines.push(format!("{} {} {}: {} of the limit", row.machine, row.date, row.quality.axis, changes.join(" ")));
        }
    }
    tally.machines += 1;
    tally.days += days.len();
    tally.alarmed_days += alarmed.len();
}

fn run(seeds: std::ops::Range<u64>, days: usize, minutes: f64, predictor: &str) -> Tally {
    let mut tally = Tally::default();
    let limits = Limits { false_alarms_per_month: FALSE_ALARMS };
    for seed in seeds {
        let folder = tempfile::tempdir().unwrap();
        let (machine, _) = simulate(&folder.path().join("logs"), seed, days, minutes);
        let models = folder.path().join("models");
        match train(&machine, &models, &settings(predictor), SILENT) {
            Ok(_) => {
                let watched = WatchSettings { limits, since: None, most_samples_a_day: 1_000_000 };
                count(&watch(&machine, &models, &watched).unwrap(), &mut tally);
            }
            Err(error) => println!("{error}"),
        }
        if std::env::var("VERBOSE").is_ok() {
            tally.lines.drain(..).for_each(|line| println!("{line}"));
        }
    }
    tally
}

fn print(tally: &Tally) {
    let Tally { machines, days, false_alarms, alarmed_days, faults, .. } = tally;
    let a_month = 30.0 * *false_alarms as f64 / *days as f64;
    println!(
        "{machines} machines, {days} healthy days: {false_alarms} alarms on {alarmed_days} days, {a_month:.2} a machine and 30 days"
    );
    for ((_, name), [axes, found, named]) in FAULTS.iter().zip(faults) {
        println!("{name}: {axes} axes, {found} with an alarm, {named} with one of this quantity");
    }
}

#[test]
#[ignore = "ten machines take half an hour; `one_machine` is always run"]
fn ten_machines() {
    let stated = |name: &str, usual: &str| std::env::var(name).unwrap_or_else(|_| usual.to_owned());
    let seeds = stated("SEEDS", "6000..6010");
    let (first, last) = seeds.split_once("..").expect("SEEDS=first..last");
    let (days, minutes) = (stated("DAYS", "20").parse().unwrap(), stated("MINUTES", "2").parse().unwrap());
    let tally = run(first.parse().unwrap()..last.parse().unwrap(), days, minutes, &stated("PREDICTOR", "staged"));
    print(&tally);
    assert!(tally.machines > 0);
    let month = 30.0 * tally.false_alarms as f64 / tally.days as f64;
    assert!(month < 1.0, "{month} false alarms a machine and month");
    // Backlash is found on about half of the axes (docs/fleet.md): printed, not asserted.
    let [axes, found, _] = tally.faults[0];
    assert!(found as f64 >= 0.95 * axes as f64, "{}: {found} of {axes}", FAULTS[0].1);
}

/// One machine of the same kind, with the linear predictor and short days: its faults are found, its healthy days give no alarm.
#[test]
fn one_machine() {
    let tally = run(5003..5004, 4, 0.3, "linear");
    print(&tally);
    tally.lines.iter().for_each(|line| println!("{line}"));
    assert_eq!((tally.machines, tally.days, tally.false_alarms), (1, 4, 0));
    assert!(tally.faults.iter().all(|[axes, found, _]| *axes == 3 && *found >= 2));
}
