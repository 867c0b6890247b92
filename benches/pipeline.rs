//! The steps of the walk, each on its own: parse, plan, predict, compensate. (`simulate` and the contour estimators have benches in
//! their crates.)

use std::f64::consts::TAU;
use std::fmt::Write;
use std::hint::black_box;
use std::sync::Arc;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use datasets::Log;
use machine::{Machine, MachineSpec};
use motion::curves::library;
use motion::{DesiredPath, PlanSettings, Trajectory, plan_curve};
use pipeline::excitation::{TRAVEL_MM, record};
use pipeline::model_based_ilc::Settings;
use pipeline::refit::{RefitSettings, TimeEncoding, refit, verify};
use pipeline::training::{TrainSettings, Trained};
use pipeline::{Input, Part, ReadSettings, SILENT, Setup, model_based_ilc};
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

    let logs = record(&spec, SECONDS, TRAVEL_MM, 1).expect("records");
    for name in ["linear", "staged"] {
        let trained = train(&logs, &spec, name);
        let input = Input::path("crown", desired.clone(), Some(spec.limits()));
        let mut model = trained.bundle.machine().expect("a machine");
        group.bench_function(format!("predict, {name}"), |b| b.iter(|| model.run(black_box(desired.trajectory()))));
        group.bench_function(format!("compensate, {name}"), |b| {
            b.iter(|| model_based_ilc(&input, &trained.bundle, &Settings::default(), SILENT));
        });
    }
    group.finish();
}

/// Seconds of excitation that the models are trained on.
const SECONDS: f64 = 30.0;

fn train(logs: &[Log], spec: &MachineSpec, recipe: &str) -> Trained {
    let settings = TrainSettings::of(Recipe::builtin(recipe).expect("built in"), 1);
    pipeline::training::train(logs, Some(spec), &settings, SILENT).expect("trains")
}

/// Words of five axes in inverse time, 2.5 ms a line, behind an approach: loops of the table with the tool leaning.
fn five_axis_program(lines: usize, approach: &str) -> Vec<u8> {
    let mut text = format!("%\nG21 G90 G17 G94\nG0 X30 Y0 Z5 B20 C0\n{approach}\nG93\n");
    for i in 0..lines {
        let turn = TAU * i as f64 / 4000.0;
        let (x, y, z) = (30.0 * turn.cos(), 10.0 * (3.0 * turn).sin(), 2.0 * (5.0 * turn).sin());
        let (b, c) = (20.0 + 8.0 * (2.0 * turn).sin(), 60.0 * turn.sin());
        writeln!(text, "N{i} G1 X{x:.4} Y{y:.4} Z{z:.4} B{b:.4} C{c:.4} F24000.0").expect("a string takes all");
    }
    text.push_str("G94\nM30\n%\n");
    text.into_bytes()
}

/// The walk of a dense program of five axes, in lines a second: read and planned, learned on the model, written and read again.
fn five_axes(c: &mut Criterion) {
    let spec = MachineSpec::builtin("bc").expect("built in");
    let setup = Setup::new(&spec, None).expect("kinematics");
    let settings = ReadSettings { at_zero: true, ..ReadSettings::default() };
    let lines = 20_000;
    let of = |bytes: &[u8]| Input::from(Part::read("dense.nc", bytes, &setup, &settings).expect("is planned"));
    let timed = five_axis_program(lines, "G0 Z0");
    let read = || of(&timed);
    let mut group = c.benchmark_group("five axes");
    group.throughput(Throughput::Elements(lines as u64));
    group.sample_size(10);
    group.bench_function("read and plan", |b| b.iter(read));

    let input = read();
    println!("{} samples of {lines} lines", input.trajectory().len());
    let encoding = TimeEncoding::Keep;
    let written = RefitSettings {
        encoding,
        decimals: 6,
        increment_decimals: None,
        spacing_s: 4e-3,
        chord_tolerance_mm: 2e-4,
        path_tolerance_mm: None,
        slow_stop: None,
    };
    let write = |input: &Input, reference: &Trajectory| {
        let part = input.program().expect("a program");
        let refitted = refit(part, reference, &written).expect("fits");
        let bytes = gcode::edit(&part.program, &refitted.edits).expect("edits");
        let toolpath = gcode::interpret(&gcode::parse(bytes.clone()), &part.options).expect("reads");
        verify(part, &(0..part.toolpath.moves.len()), &refitted, &toolpath, 0.1, written.decimals).expect("passes");
        bytes
    };
    let logs = record(&spec, SECONDS, TRAVEL_MM, 1).expect("records");
    for name in ["linear", "staged"] {
        let bundle = train(&logs, &spec, name).bundle;
        let settings = Settings { written: Some(written), ..Settings::default() };
        let learn = |input: &Input| model_based_ilc(input, &bundle, &settings, SILENT).expect("learns").reference;
        group.bench_function(format!("learn, {name}"), |b| b.iter(|| learn(&input)));
        let reference = learn(&input);
        group.bench_function(format!("write and verify, {name}"), |b| b.iter(|| write(&input, &reference)));
        // As the command does it, among the threads that share the work.
        for (times, bytes) in [("all times stated", &timed), ("the approach's not", &five_axis_program(lines, "G1 Z0 F600"))] {
            let walk = || {
                let input = of(bytes);
                write(&input, &learn(&input))
            };
            group.bench_function(format!("bytes to bytes, {name}, {times}"), |b| b.iter(|| rayon::scope(|_| walk())));
        }
    }
    group.finish();
}

criterion_group!(pipeline, benches, five_axes);
criterion_main!(pipeline);
