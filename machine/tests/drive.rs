//! Simulated drives against their equations.

mod common;

use common::{PERIOD_S, peak, rms, together, trajectory};
use machine::{
    AxisSpec, DriveSpec, Interpolation, Machine, MachineError, MachineSpec, Sensor, SimulatedMachine, SimulationOptions,
};
use motion::{Axis, Trajectory};

fn changed(name: &str, change: impl Fn(&mut DriveSpec)) -> MachineSpec {
    let mut spec = MachineSpec::builtin(name).unwrap();
    for axis in &mut spec.axes {
        if let AxisSpec::Linear(axis) = axis {
            axis.drive.iter_mut().for_each(|drive| change(drive));
        }
    }
    spec
}

fn simulated(spec: &MachineSpec, options: SimulationOptions) -> SimulatedMachine {
    SimulatedMachine::new(spec, 7).unwrap().with_options(options).unwrap()
}

/// From standstill at 0 to `speed` mm/s within 0.1 s, then constant.
fn ramp(speed: f64, duration_s: f64) -> Vec<f64> {
    let rise = 0.1;
    (0..(duration_s / PERIOD_S) as usize)
        .map(|k| {
            let t = k as f64 * PERIOD_S;
            if t < rise { 0.5 * speed * t * t / rise } else { speed * (t - 0.5 * rise) }
        })
        .collect()
}

fn wave(amplitude: f64, frequency: f64, samples: usize) -> Vec<f64> {
    (0..samples).map(|k| amplitude * (1.0 - (std::f64::consts::TAU * frequency * k as f64 * PERIOD_S).cos())).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[test]
fn a_ramp_lags_by_what_feed_forward_leaves() {
    let (gains, shares) = ([100.0, 95.0, 105.0], [0.886, 0.8815, 0.8865]);
    for speed in [40.0, -40.0] {
        let reference = together(ramp(speed, 2.1));
        let mut machine = simulated(&MachineSpec::builtin("ballscrew").unwrap(), SimulationOptions::noise_free());
        let error = reference.tracking_error(&machine.run(&reference).unwrap()).unwrap();
        for a in 0..3 {
            let expected = speed * (1.0 - shares[a]) / gains[a];
            let measured = mean(&error[a][300..]);
            assert!(measured * speed > 0.0, "a lagging axis has an error of its speed's sign");
            assert!((measured / expected - 1.0).abs() < 0.01, "{measured} against {expected} mm");
        }
    }
}

#[test]
fn runs_superpose_without_friction_backlash_and_counts() {
    let linear = changed("ballscrew", |drive| {
        drive.friction.coulomb_n = 0.0;
        drive.friction.static_n = 0.0;
        drive.screw.backlash_half_width_um = 0.0;
        drive.motor.ripple.clear();
        drive.motor.cogging.clear();
    });
    for interpolation in [Interpolation::Linear, Interpolation::Cubic] {
        let options = SimulationOptions { quantised: false, interpolation, ..SimulationOptions::noise_free() };
        let mut machine = simulated(&linear, options);
        let (a, b) = (wave(8.0, 1.0, 600), wave(0.3, 7.0, 600));
        let both = a.iter().zip(&b).map(|(a, b)| a + 2.0 * b).collect();
        let mut run = |column| machine.run_full(&together(column)).unwrap().table;
        let (zero, a, b, both) = (run(vec![0.0; 600]), run(a), run(b), run(both));
        for axis in 0..3 {
            for k in 0..600 {
                let at = |t: &Trajectory| t.columns()[axis][k];
                let sum = at(&a) + 2.0 * at(&b) - 2.0 * at(&zero);
                assert!((sum - at(&both)).abs() < 1e-8, "axis {axis}, sample {k}");
            }
        }
    }
}

#[test]
fn friction_and_backlash_are_not_linear() {
    let options = SimulationOptions { quantised: false, ..SimulationOptions::noise_free() };
    for name in ["ballscrew", "maxwell", "worn"] {
        let mut machine = simulated(&MachineSpec::builtin(name).unwrap(), options);
        let mut error = |amplitude: f64| {
            let reference = together(wave(amplitude, 1.0, 600));
            let error = reference.tracking_error(&machine.run(&reference).unwrap()).unwrap();
            error[0].clone()
        };
        let (small, large) = (error(2.0), error(4.0));
        let left: Vec<f64> = small.iter().zip(&large).map(|(s, l)| 2.0 * s - l).collect();
        assert!(rms(&left) > 3e-4, "{name}: {} mm", rms(&left));
    }
}

#[test]
fn a_still_axis_stays_still() {
    let still = together(vec![0.0; 1500]);
    let mut quiet = simulated(&MachineSpec::builtin("ballscrew").unwrap(), SimulationOptions::noise_free());
    let run = quiet.run_full(&still).unwrap();
    for column in run.motor.columns().iter().chain(run.table.columns()) {
        assert!(column.iter().all(|x| x == &column[0]), "moved without noise");
    }
    let mut noisy = simulated(&MachineSpec::builtin("ballscrew").unwrap(), SimulationOptions::default());
    for column in noisy.run_full(&still).unwrap().motor.columns() {
        assert!(peak(column) < 2e-3, "{} mm at rest", peak(column));
    }
    // Off the encoder grid the integrator hunts between two counts, no further.
    let run = quiet.run_full(&together(vec![0.010_037; 1500])).unwrap();
    let count = 5.0 / 32768.0;
    for column in run.motor.columns() {
        assert!(column.iter().all(|x| (x - 0.010_037).abs() < 1.01 * count));
    }
}

/// Reference, and per axis the lost motion of the table between upward and downward motion at
/// constant `speed`, mm.
fn lost_motion(spec: &MachineSpec, sensor: Sensor, speed: f64) -> Vec<f64> {
    let up = ramp(speed, 1.5);
    let (half, top) = (up.len(), up[up.len() - 1]);
    let reference = together(up.iter().copied().chain(up.iter().map(|x| top - x)).collect());
    let options = SimulationOptions { sensor: Some(sensor), quantised: false, ..SimulationOptions::noise_free() };
    let run = simulated(spec, options).run_full(&reference).unwrap();
    let error = reference.tracking_error(&run.table).unwrap();
    spec.axes
        .iter()
        .zip(error)
        .map(|(axis, error)| {
            let loops = &axis.drive().unwrap().loops;
            let lag = speed * (1.0 - loops.feed_forward) / loops.position_gain_1_s;
            let difference = mean(&error[half - 200..half - 20]) - mean(&error[2 * half - 200..2 * half - 20]);
            difference - 2.0 * lag
        })
        .collect()
}

#[test]
fn lost_motion_is_backlash_and_deflection_and_a_table_scale_removes_it() {
    let spec = changed("ballscrew", |drive| {
        drive.friction.direction_asymmetry = 0.0;
        drive.friction.waves.clear();
        drive.friction.screw_waves.clear();
    });
    let speed = 10.0;
    let by_motor = lost_motion(&spec, Sensor::Motor, speed);
    let by_table = lost_motion(&spec, Sensor::Table, speed);
    for (a, axis) in spec.axes.iter().enumerate() {
        let drive = axis.drive().unwrap();
        let force = (1.0 - drive.friction.motor_share) * drive.friction.coulomb_n + drive.table.viscous_n_s_m * speed * 1e-3;
        let backlash = 2e-3 * drive.screw.backlash_half_width_um;
        let deflection = 2e3 * force / drive.screw.stiffness_n_m;
        assert!((by_motor[a] - backlash - deflection).abs() < 1e-4, "{} mm on axis {a}", by_motor[a]);
        assert!(by_table[a].abs() < 2e-4, "{} mm on axis {a}", by_table[a]);
    }
}

#[test]
fn the_torque_limit_bounds_the_acceleration() {
    let mut column = vec![0.0; 50];
    column.extend(vec![20.0; 100]);
    let options = SimulationOptions { quantised: false, ..SimulationOptions::noise_free() };
    let weak = changed("ballscrew", |drive| drive.motor.torque_limit_n_m = 1.5);
    let run = simulated(&weak, options).run_full(&together(column)).unwrap();
    let drive = weak.axes[0].drive().unwrap();
    let radius = drive.screw.lead_mm * 1e-3 / std::f64::consts::TAU;
    let inertia = drive.motor.inertia_kg_m2 + drive.table.mass_kg * radius * radius;
    // Friction only brakes. Ripple and cogging add a little to the limited torque.
    let largest = 1e3 * radius * (1.5 * 1.004 + 0.01) / inertia;
    let x = &run.table.columns()[0];
    // Over 10 ms, so that the vibration of the screw averages out.
    let acceleration: Vec<f64> = x.windows(11).map(|w| (w[10] - 2.0 * w[5] + w[0]) / (5.0 * PERIOD_S).powi(2)).collect();
    let pushed = acceleration[..70].iter().fold(0.0_f64, |m, a| m.max(*a));
    assert!(pushed < 1.02 * largest && pushed > 0.7 * largest, "{pushed} of {largest} mm/s²");
}

#[test]
fn runs_are_a_deterministic_sequence() {
    let reference = trajectory(vec![wave(5.0, 1.0, 300), wave(4.0, 1.5, 300), wave(3.0, 2.0, 300)]);
    let spec = MachineSpec::builtin("ballscrew").unwrap();
    let sequence = |seed| {
        let mut machine = SimulatedMachine::new(&spec, seed).unwrap();
        [(); 3].map(|()| machine.run(&reference).unwrap())
    };
    let (a, b, other) = (sequence(1), sequence(1), sequence(2));
    assert_eq!(a, b);
    assert_ne!(a, other);
    assert_ne!(a[0], a[1]);
    let machine = SimulatedMachine::new(&spec, 1).unwrap();
    let own = machine.run_with_seed(&reference, 9).unwrap();
    assert_eq!(own, machine.run_with_seed(&reference, 9).unwrap());
    assert_ne!(own, machine.run_with_seed(&reference, 10).unwrap());
    let mut quiet = simulated(&spec, SimulationOptions::noise_free());
    let first = quiet.run_full(&reference).unwrap();
    assert_eq!(first, quiet.run_full(&reference).unwrap());
    assert_eq!(first, quiet.run_with_seed(&reference, 3).unwrap());
    assert_eq!(quiet.runs(), 2);
}

#[test]
fn noise_scales() {
    let reference = together(wave(5.0, 1.0, 1000));
    let spec = MachineSpec::builtin("maxwell").unwrap();
    let spread = |noise_scale| {
        let options = SimulationOptions { noise_scale, ..SimulationOptions::default() };
        let mut machine = simulated(&spec, options);
        let (a, b) = (machine.run(&reference).unwrap(), machine.run(&reference).unwrap());
        rms(&a.tracking_error(&b).unwrap()[0])
    };
    let (small, large) = (spread(1.0), spread(4.0));
    assert!(large > 2.0 * small && small > 5e-5, "{small}, {large} mm");
}

#[test]
fn references_that_do_not_fit_are_refused() {
    let mut machine = SimulatedMachine::new(&MachineSpec::builtin("ballscrew").unwrap(), 1).unwrap();
    let two = Trajectory::new(PERIOD_S, ["x", "y"].map(Axis::named).to_vec(), vec![vec![0.0]; 2]).unwrap();
    let slow = Trajectory::new(0.004, Axis::xyz(), vec![vec![0.0]; 3]).unwrap();
    let empty = together(vec![]);
    for (reference, word) in [(two, "axes"), (slow, "period"), (empty, "sample")] {
        let error = machine.run(&reference).unwrap_err();
        assert!(matches!(error, MachineError::Misfit(_)) && error.to_string().contains(word), "{error}");
    }
    assert_eq!(machine.runs(), 0);
}

#[test]
fn one_sample_is_a_run() {
    let mut machine = simulated(&MachineSpec::builtin("worn").unwrap(), SimulationOptions::default());
    assert_eq!(machine.run(&together(vec![3.0])).unwrap().len(), 1);
}
