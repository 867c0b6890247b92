//! The stages on a servo model: a slow axis with a PID loop and a smoothed command, drawn at random.

mod staged_common;

use std::sync::Arc;

use machine::{MachineSpec, SimulatedMachine, SimulationOptions};
use models::AxisPredictor;
use motion::curves::library::random_nurbs;
use motion::{PlanSettings, Trajectory, plan_curve};
use staged_common::{residual, rms};
use training::staged::{AxisRun, ServoFit, StagedRecipe, adapt, fit, fit_best, fit_on};

const SEED: u64 = 2;
const AXIS: usize = 0;

fn planned(spec: &MachineSpec, points: usize, sigma_mm: f64, share: f64, seed: u64) -> Trajectory {
    let curve = Arc::new(random_nurbs(points, sigma_mm, 3, seed).unwrap());
    let feed = share * spec.limits().axes.iter().map(|axis| axis.velocity).fold(f64::INFINITY, f64::min);
    let settings = PlanSettings { period_s: spec.sampling_period_s(), ..PlanSettings::default() };
    plan_curve(curve, feed, &spec.limits(), &settings).unwrap().trajectory().clone()
}

fn run_of(machine: &SimulatedMachine, reference: &Trajectory, seed: u64) -> AxisRun {
    let actual = machine.run_with_seed(reference, seed).unwrap().motor;
    AxisRun::new(reference.columns()[AXIS].clone(), actual.columns()[AXIS].clone(), reference.period_s())
}

#[test]
fn stages_on_a_servo_model_halve_the_error_of_a_slow_axis_with_a_smoothed_command() {
    let spec = MachineSpec::random(SEED).unwrap();
    let machine = SimulatedMachine::new(&spec, SEED).unwrap();
    let curves = [(10, 18.0, 0.8), (20, 4.0, 0.8), (10, 18.0, 0.4), (8, 8.0, 0.1), (12, 18.0, 0.8), (8, 18.0, 0.6)];
    let references =
        curves.into_iter().zip(200..).map(|((points, sigma, share), seed)| planned(&spec, points, sigma, share, seed));
    let runs: Vec<AxisRun> = references.zip(200..).map(|(reference, seed)| run_of(&machine, &reference, seed)).collect();
    // Without harmonics and map, which take most of the time.
    let mut recipe = StagedRecipe { memory_s: vec![0.02, 0.2], ..StagedRecipe::default() };
    (recipe.harmonics.rounds, recipe.map.rounds) = (0, 0);

    let servo = ServoFit::identify_all(&[(runs.clone(), false)]).remove(0).unwrap();
    assert!(servo.optimism() > 1.0 && servo.optimism() < 1.5);
    let (plain, _) = fit(&runs, &recipe).unwrap();
    let (best, report, taken) = fit_best(&runs, Some(&servo), &recipe).unwrap();
    assert!(taken && best.servo() == Some(&servo.base()));

    let quiet = machine.clone().with_options(SimulationOptions::noise_free()).unwrap();
    let unseen = run_of(&quiet, &planned(&spec, 14, 14.0, 0.8, 7000), 0);
    let error = |predictor: &dyn AxisPredictor| 1e3 * rms(residual(predictor, &unseen));
    let (on_reference, on_servo) = (error(&plain), error(&best));
    println!("{on_reference:.3} µm on the reference, {on_servo:.3} on the servo model, {:?} held out", report.held_out_rms());
    assert!(on_servo < 0.6 * on_reference);

    // Refitted to a part of the runs, and to another state of the machine.
    let part = servo.refit(&runs[..4]).unwrap();
    let (of_part, _) = fit_on(&runs[..4], Some(&part.base()), &recipe).unwrap();
    assert!(error(&of_part) < on_reference);
    let mut other = spec.clone();
    for axis in &mut other.axes {
        if let machine::AxisSpec::Linear(axis) = axis
            && let Some(drive) = &mut axis.drive
        {
            drive.loops.position_gain_1_s *= 0.9;
            drive.friction.coulomb_n *= 1.2;
            drive.friction.static_n *= 1.2;
        }
    }
    let other = SimulatedMachine::new(&other, 5).unwrap();
    let short = run_of(&other, &planned(&spec, 10, 14.0, 0.8, 7100), 5);
    let later = run_of(&other.with_options(SimulationOptions::noise_free()).unwrap(), &planned(&spec, 14, 14.0, 0.8, 7000), 0);
    let (adapted, _) = adapt(&best, &[short], &recipe).unwrap();
    let on_later = |predictor: &dyn AxisPredictor| 1e3 * rms(residual(predictor, &later));
    println!("another state: {:.3} µm, adapted {:.3} µm", on_later(&best), on_later(&adapted));
    assert!(on_later(&adapted) < 0.3 * on_later(&best));
}
