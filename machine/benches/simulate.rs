//! Speed of the simulation: seconds of motion per second of computing time.
#![allow(missing_docs, reason = "criterion's macros make undocumented items")]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use machine::{MachineSpec, SimulatedMachine};
use motion::{Axis, Trajectory};

/// Ten seconds of motion of three axes without a common standstill.
fn reference() -> Trajectory {
    let columns =
        (1..4).map(|axis| (0..5000).map(|k| 20.0 * (0.002 * f64::from(k) * 2.0 * f64::from(axis)).sin()).collect()).collect();
    Trajectory::new(0.002, Axis::xyz(), columns).unwrap()
}

fn simulate(criterion: &mut Criterion) {
    let reference = reference();
    let mut group = criterion.benchmark_group("simulate 10 s of 3 axes");
    group.sample_size(10);
    group.throughput(Throughput::Elements(3 * 10 * 40_000));
    for name in ["ballscrew", "maxwell"] {
        let spec = MachineSpec::builtin(name).unwrap();
        let mut machine = SimulatedMachine::new(&spec, 1).unwrap();
        group.bench_function(name, |b| b.iter(|| machine.run_full(&reference).unwrap()));
    }
    group.finish();
}

criterion_group!(benches, simulate);
criterion_main!(benches);
