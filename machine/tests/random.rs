//! Random machines.

use machine::{Machine, MachineSpec, Sensor, SimulatedMachine, SimulationOptions};
use motion::Trajectory;

/// Seeds of these tests. Reports use others.
const SEEDS: std::ops::Range<u64> = 1001..1041;

fn wave(spec: &MachineSpec) -> Trajectory {
    let period_s = spec.sampling_period_s();
    let amplitude = 0.25 * spec.limits().axes[0].velocity;
    let column = |phase: f64| {
        (0..(0.6 / period_s) as usize).map(|k| amplitude * (1.0 - (3.0 * k as f64 * period_s + phase).cos())).collect()
    };
    Trajectory::new(period_s, spec.motion_axes(), vec![column(0.0), column(1.0), column(2.0)]).unwrap()
}

#[test]
fn forty_machines_are_sound_reproducible_and_run() {
    for seed in SEEDS {
        let spec = MachineSpec::random(seed).unwrap();
        assert_eq!(spec, MachineSpec::random(seed).unwrap(), "{seed}");
        assert_eq!(spec, MachineSpec::from_toml(&spec.to_toml().unwrap()).unwrap(), "{seed}");
        let reference = wave(&spec);
        let mut machine = SimulatedMachine::new(&spec, seed).unwrap();
        let actual = machine.run(&reference).unwrap();
        for (error, axis) in reference.tracking_error(&actual).unwrap().iter().zip(&spec.axes) {
            let largest = error.iter().fold(0.0_f64, |top, e| top.max(e.abs()));
            let lag_s = 1.0 / axis.drive().unwrap().loops.position_gain_1_s + 0.035;
            assert!(largest < 0.05 + 2.0 * spec.path.velocity_mm_s * lag_s, "machine {seed}, axis {}: {largest} mm", axis.name());
        }
    }
}

#[test]
fn structures_differ() {
    let all: Vec<MachineSpec> = SEEDS.map(|seed| MachineSpec::random(seed).unwrap()).collect();
    let count = |of: &dyn Fn(&MachineSpec) -> bool| all.iter().filter(|spec| of(spec)).count();
    let loops = |spec: &MachineSpec| spec.axes[0].drive().unwrap().loops.clone();
    for (what, number) in [
        ("table sensors", count(&|spec| spec.sensor == Sensor::Table)),
        ("PID loops", count(&|spec| loops(spec).position_integral_ms.is_some())),
        ("averages", count(&|spec| loops(spec).command_average_ms > 0.0)),
        ("lags", count(&|spec| loops(spec).command_lag_ms > 0.0)),
        ("delays", count(&|spec| loops(spec).delay_periods > 0)),
        ("linear motors", count(&|spec| spec.axes[0].drive().unwrap().screw.lead_mm > 100.0)),
        ("one mass", count(&|spec| spec.axes[0].drive().unwrap().screw.rigid)),
        ("warming", count(&|spec| spec.axes[0].drive().unwrap().friction.warming.is_some())),
        ("logs of 4 ms", count(&|spec| spec.sampling_period_ms == 4.0)),
    ] {
        assert!((4..=36).contains(&number), "{what}: {number} of 40");
    }
}

#[test]
fn a_machine_without_noise_repeats_itself_and_a_warming_one_drifts() {
    let spec = (1001..)
        .map(|seed| MachineSpec::random(seed).unwrap())
        .find(|spec| spec.axes[0].drive().unwrap().friction.warming.is_some())
        .unwrap();
    let reference = wave(&spec);
    let mut quiet = SimulatedMachine::new(&spec, 1).unwrap().with_options(SimulationOptions::noise_free()).unwrap();
    assert_eq!(quiet.run(&reference).unwrap(), quiet.run(&reference).unwrap());
    // With one seed for both runs they differ by the warming only.
    let mut warm = SimulatedMachine::new(&spec, 1).unwrap();
    let cold = warm.run_with_seed(&reference, 7).unwrap();
    for _ in 0..50 {
        warm.run(&reference).unwrap();
    }
    assert_ne!(cold, warm.run_with_seed(&reference, 7).unwrap());
}
