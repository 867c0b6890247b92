//! The steps of the walk, each on its own: parse, plan, predict, compensate. (`simulate` and the contour estimators have benches in
//! their crates.)

use std::hint::black_box;
use std::sync::Arc;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use datasets::{ExcitationPlan, Log, excite};
use machine::{Machine, MachineSpec, SimulatedMachine};
use motion::curves::library;
use motion::{DesiredPath, PlanSettings, plan_curve};
use precomp::learning::{self, Settings};
use precomp::training_run::{self, TrainSettings};
use training::Recipe;

/// A dense program of 20,000 lines.
fn program() -> Vec<u8> {
    let mut text = String::from("%\nG21 G90 G17 G94\nG0 X0 Y0 Z5\nG1 Z0 F600\n");
    for i in 0..20_000 {
        let u = f64::from(i) * 0.01;
        text.push_str(&format!("N{} G1 X{:.4} Y{:.4} F1500\n", i + 10, 30.0 * u.cos(), 30.0 * (1.01 * u).sin()));
    }
    text.push_str("M30\n%\n");
    text.into_bytes()
}

fn crown(spec: &MachineSpec) -> DesiredPath {
    plan_curve(Arc::new(library::CROWN), 80.0, &spec.limits(), &PlanSettings::default()).expect("the crown is planned")
}

fn benches(c: &mut Criterion) {
    let bytes = program();
    let mut group = c.benchmark_group("parse");
    group.throughput(Throughput::Bytes(bytes.len() as u64));
    group.bench_function("parse", |b| b.iter(|| gcode::parse(black_box(bytes.clone()))));
    let parsed = gcode::parse(bytes);
    let options = gcode::Dialect::Fanuc.into();
    group.bench_function("interpret", |b| b.iter(|| gcode::interpret(black_box(&parsed), &options)));
    group.finish();

    let spec = MachineSpec::builtin("ballscrew").expect("built in");
    let desired = crown(&spec);
    let samples = desired.trajectory().len() as u64;
    let mut group = c.benchmark_group("path");
    group.throughput(Throughput::Elements(samples));
    group.sample_size(10);
    group.bench_function("plan", |b| b.iter(|| crown(black_box(&spec))));

    let runs = excite(
        &ExcitationPlan::of_seconds(12.0),
        &spec.limits(),
        &spec.motion_axes(),
        &[(-60.0, 60.0); 3],
        spec.sampling_period_s(),
        1,
    )
    .expect("excitation");
    let mut machine = SimulatedMachine::new(&spec, 1).expect("simulated");
    let logs: Vec<Log> = runs
        .into_iter()
        .map(|(name, reference)| {
            let actual = machine.run(&reference).expect("runs");
            Log::new(name, reference, actual).expect("matches")
        })
        .collect();
    for name in ["linear", "staged"] {
        let settings = TrainSettings::of(Recipe::builtin(name).expect("built in"), 1);
        let trained = training_run::train(&logs, Some(&spec), &settings).expect("trains");
        let mut model = trained.bundle.machine().expect("a machine");
        group.bench_function(format!("predict, {name}"), |b| b.iter(|| model.run(black_box(desired.trajectory()))));
        group.bench_function(format!("compensate, {name}"), |b| {
            b.iter(|| learning::compensate_with(&trained.bundle, &spec.limits(), &desired, None, &Settings::default()));
        });
    }
    group.finish();
}

criterion_group!(pipeline, benches);
criterion_main!(pipeline);
