//! Simulated rotary drives against their equations.

mod common;

use common::{PERIOD_S, rms};
use machine::{AxisSpec, Machine, MachineSpec, RotaryDriveSpec, Sensor, SimulatedMachine, SimulationOptions};
use motion::Trajectory;

/// The rotary axes of the machine `name`, with changed drives.
fn rotary(name: &str, change: impl Fn(&mut RotaryDriveSpec)) -> MachineSpec {
    let mut spec = MachineSpec::builtin(name).unwrap();
    spec.kinematics = Default::default();
    spec.axes.retain(|axis| matches!(axis, AxisSpec::Rotary(_)));
    for axis in &mut spec.axes {
        if let AxisSpec::Rotary(axis) = axis {
            axis.drive.iter_mut().for_each(|drive| change(drive));
        }
    }
    spec
}

fn quiet() -> SimulationOptions {
    SimulationOptions { quantised: false, ..SimulationOptions::noise_free() }
}

fn simulated(spec: &MachineSpec, options: SimulationOptions) -> SimulatedMachine {
    SimulatedMachine::new(spec, 5).unwrap().with_options(options).unwrap()
}

/// The same angles on every axis of `spec`.
fn together(spec: &MachineSpec, column: Vec<f64>) -> Trajectory {
    Trajectory::new(PERIOD_S, spec.motion_axes(), vec![column; spec.axes.len()]).unwrap()
}

/// From standstill at 0 to `speed` rad/s within 0.1 s, then constant.
fn ramp(speed: f64, duration_s: f64) -> Vec<f64> {
    let rise = 0.1;
    (0..(duration_s / PERIOD_S) as usize)
        .map(|k| {
            let t = k as f64 * PERIOD_S;
            if t < rise { 0.5 * speed * t * t / rise } else { speed * (t - 0.5 * rise) }
        })
        .collect()
}

fn there_and_back(speed: f64) -> Vec<f64> {
    let up = ramp(speed, 1.5);
    let top = up[up.len() - 1];
    up.iter().copied().chain(up.iter().map(|angle| top - angle)).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[test]
fn a_ramp_lags_by_what_feed_forward_leaves() {
    for name in ["bc", "xyzac"] {
        let spec = rotary(name, |_| {});
        for speed in [0.5, -0.5] {
            let reference = together(&spec, ramp(speed, 3.1));
            let error = reference.tracking_error(&simulated(&spec, quiet()).run(&reference).unwrap()).unwrap();
            for (axis, error) in spec.axes.iter().zip(error) {
                let loops = &axis.rotary_drive().unwrap().loops;
                let expected = speed * (1.0 - loops.feed_forward) / loops.position_gain_1_s;
                let measured = mean(&error[300..]);
                assert!((measured / expected - 1.0).abs() < 0.02, "{name}: {measured} against {expected} rad");
            }
        }
    }
}

#[test]
fn a_reversal_shows_backlash_and_deflection_in_the_table_view_only() {
    let even = |drive: &mut RotaryDriveSpec| {
        drive.friction.direction_asymmetry = 0.0;
        drive.friction.waves.clear();
        drive.friction.motor_waves.clear();
    };
    let speed = 0.2;
    for width_urad in [0.0, 20.0, 40.0] {
        let spec = rotary("bc", |drive| {
            even(drive);
            drive.gear.backlash_half_width_urad = width_urad;
        });
        let reference = together(&spec, there_and_back(speed));
        let half = reference.len() / 2;
        let run = simulated(&spec, quiet()).run_full(&reference).unwrap();
        for (a, axis) in spec.axes.iter().enumerate() {
            let drive = axis.rotary_drive().unwrap();
            let twist: Vec<f64> = run.motor.columns()[a].iter().zip(&run.table.columns()[a]).map(|(m, t)| m - t).collect();
            let lost = mean(&twist[half - 200..half - 20]) - mean(&twist[2 * half - 200..2 * half - 20]);
            let torque = (1.0 - drive.friction.motor_share) * drive.friction.coulomb_n_m + drive.table.viscous_n_m_s_rad * speed;
            let expected = 2e-6 * width_urad + 2.0 * torque / drive.gear.stiffness_n_m_rad;
            assert!((lost - expected).abs() < 1e-6, "{lost} against {expected} rad on axis {a}");
        }
        // With the scale in the loop the lag of the table is the same in both directions.
        let options = SimulationOptions { sensor: Some(Sensor::Table), ..quiet() };
        let error = reference.tracking_error(&simulated(&spec, options).run_full(&reference).unwrap().table).unwrap();
        for (error, axis) in error.iter().zip(&spec.axes) {
            let loops = &axis.rotary_drive().unwrap().loops;
            let lag = speed * (1.0 - loops.feed_forward) / loops.position_gain_1_s;
            let difference = mean(&error[half - 200..half - 20]) - mean(&error[2 * half - 200..2 * half - 20]);
            assert!((difference - 2.0 * lag).abs() < 5e-6, "{difference} against {} rad", 2.0 * lag);
        }
    }
}

#[test]
fn a_direct_drive_follows_without_backlash() {
    let spec = rotary("bc", |drive| {
        drive.gear.turns_per_turn = 1.0;
        drive.gear.stiffness_n_m_rad = 4e6;
        drive.gear.backlash_half_width_urad = 0.0;
        // The rotor of a torque motor is most of the inertia, so its speed loop need not wait for
        // the table.
        drive.motor.inertia_kg_m2 = 0.6;
        drive.table.inertia_kg_m2 = 0.4;
        drive.motor.counts_per_turn = 16_777_216.0;
        drive.motor.torque_limit_n_m = 300.0;
        drive.loops.velocity_gain_n_m_s_rad = 1000.0 * (0.6 + 0.4);
        drive.friction.coulomb_n_m = 3.0;
        drive.friction.static_n_m = 4.0;
    });
    let speed = 1.0;
    let reference = together(&spec, there_and_back(speed));
    let half = reference.len() / 2;
    let run = simulated(&spec, SimulationOptions::noise_free()).run_full(&reference).unwrap();
    let error = reference.tracking_error(&run.table).unwrap();
    for (a, axis) in spec.axes.iter().enumerate() {
        let drive = axis.rotary_drive().unwrap();
        let lag = speed * (1.0 - drive.loops.feed_forward) / drive.loops.position_gain_1_s;
        for (sign, part) in [(1.0, &error[a][half - 200..half - 20]), (-1.0, &error[a][2 * half - 200..2 * half - 20])] {
            assert!((mean(part) / (sign * lag) - 1.0).abs() < 0.02, "{} against {lag} rad", mean(part));
        }
        let apart: Vec<f64> = run.motor.columns()[a].iter().zip(&run.table.columns()[a]).map(|(m, t)| m - t).collect();
        assert!(rms(&apart[half - 200..half - 20]) < 4e-6, "{} rad between motor and table", rms(&apart));
    }
}

#[test]
fn noise_free_runs_repeat_and_noisy_ones_scatter_by_microradians() {
    for name in ["bc", "xyzac"] {
        let spec = rotary(name, |_| {});
        let swing = (0..1000).map(|k| 0.3 * (1.0 - (std::f64::consts::TAU * k as f64 * PERIOD_S).cos())).collect();
        let reference = together(&spec, swing);
        let mut machine = simulated(&spec, SimulationOptions::noise_free());
        assert_eq!(machine.run_full(&reference).unwrap(), machine.run_full(&reference).unwrap());
        let mut machine = simulated(&spec, SimulationOptions::default());
        let (a, b) = (machine.run(&reference).unwrap(), machine.run(&reference).unwrap());
        for scatter in a.tracking_error(&b).unwrap() {
            let apart = rms(&scatter) / 2.0_f64.sqrt();
            assert!((1e-6..2e-5).contains(&apart), "{name}: {apart} rad");
        }
    }
}

#[test]
fn a_still_axis_stays_still_far_from_zero() {
    let spec = rotary("xyzac", |_| {});
    let still = together(&spec, vec![300.0; 500]);
    let run = simulated(&spec, quiet()).run_full(&still).unwrap();
    for column in run.table.columns() {
        let moved = column.iter().fold(0.0_f64, |m, angle| m.max((angle - column[0]).abs()));
        // The integrator removes the remaining error of the approach.
        assert!(moved < 1e-5 && (column[0] - 300.0).abs() < 2e-4, "{moved} rad, {}", column[0] - 300.0);
    }
}
