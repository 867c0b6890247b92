//! Machines drawn at random with known faults, and their logs.
#![allow(dead_code, reason = "every test file uses some of these")]

use datasets::{ExcitationPlan, Log, excite};
use diagnosis::Sensor;
use machine::{
    AxisSpec, Harmonic, Machine, MachineSpec, PreslidingSpec, SimulatedMachine, SimulationOptions, TorqueHarmonic, Wave,
};
use motion::Trajectory;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::f64::consts::TAU;

/// Half of the travel of the excitation, mm.
const TRAVEL_MM: f64 = 60.0;
/// Draws of a machine until one is stable.
const DRAWS: u64 = 40;

/// What is known of one axis.
#[derive(Debug, Clone, Copy)]
pub struct Truth {
    pub position_gain_1_s: f64,
    pub feed_forward: f64,
    pub backlash_um: f64,
    /// Deflection of the loops without integrator by Coulomb friction, µm.
    pub coulomb_um: f64,
    /// Static friction over Coulomb friction, less 1.
    pub stribeck: f64,
    /// Amplitude of the cogging as such a deflection, µm, and its period, mm.
    pub cogging_um: f64,
    pub cogging_mm: f64,
    /// Relative amplitude of friction along the axis.
    pub wave: f64,
    /// Resonance of the table on the screw with the motor held, Hz, and its damping ratio.
    pub resonance_hz: f64,
    pub damping: f64,
}

impl Truth {
    pub fn lag_s(&self) -> f64 {
        (1.0 - self.feed_forward) / self.position_gain_1_s
    }
}

/// A machine with known faults.
pub struct Patient {
    pub seed: u64,
    pub spec: MachineSpec,
    pub sensor: Sensor,
    pub truths: Vec<Truth>,
}

struct Draw(ChaCha8Rng);

impl Draw {
    fn uniform(&mut self, low: f64, high: f64) -> f64 {
        self.0.random_range(low..high)
    }

    fn log_uniform(&mut self, low: f64, high: f64) -> f64 {
        self.uniform(low.ln(), high.ln()).exp()
    }

    fn chance(&mut self, probability: f64) -> bool {
        self.0.random_bool(probability)
    }
}

/// The stable machine of a seed: a cascade with feed-forward 0 to 1.1, gains of the axes up to a tenth apart, backlash up to 20 µm, friction
/// that deflects the loops by 1 to 20 µm, LuGre or Maxwell-slip, cogging up to half of it, a resonance of 30 to 150 Hz, both sensors.
pub fn patient(seed: u64) -> Patient {
    for stream in 0..DRAWS {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(1000 + stream);
        let drawn = drawn(seed, &mut Draw(rng));
        if is_stable(&drawn.spec) {
            return drawn;
        }
    }
    panic!("no stable machine for seed {seed}");
}

fn drawn(seed: u64, draw: &mut Draw) -> Patient {
    let mut spec = MachineSpec::builtin("ballscrew").unwrap();
    spec.name = format!("patient-{seed}");
    let sensor = if draw.chance(0.5) { Sensor::Table } else { Sensor::Motor };
    spec.sensor = if sensor == Sensor::Table { machine::Sensor::Table } else { machine::Sensor::Motor };
    let gain = draw.log_uniform(30.0, 120.0);
    let feed_forward = if draw.chance(0.2) { 0.0 } else { draw.uniform(0.0, 1.1) };
    let ratio = draw.log_uniform(4.0, 10.0);
    let maxwell = draw.chance(0.5);
    let truths = spec.axes.iter_mut().map(|axis| change(axis, draw, gain, feed_forward, ratio, maxwell)).collect();
    Patient { seed, spec, sensor, truths }
}

fn change(axis: &mut AxisSpec, draw: &mut Draw, gain: f64, feed_forward: f64, ratio: f64, maxwell: bool) -> Truth {
    let AxisSpec::Linear(axis) = axis else { panic!("a linear axis is wanted") };
    let drive = axis.drive.as_mut().unwrap();
    let position_gain_1_s = gain * draw.uniform(0.9, 1.1);
    let feed_forward = if feed_forward > 0.0 { (feed_forward + draw.uniform(-0.03, 0.03)).max(0.0) } else { 0.0 };
    let bandwidth_1_s = gain * ratio;
    let table_kg = draw.log_uniform(20.0, 100.0);
    let motor_kg = table_kg * draw.log_uniform(1.0, 8.0);
    let per_rad = drive.screw.lead_mm * 1e-3 / TAU;
    let coulomb_um = draw.log_uniform(1.0, 20.0);
    let coulomb_n = coulomb_um * 1e-6 * (table_kg + motor_kg) * bandwidth_1_s * position_gain_1_s;
    let stribeck = draw.uniform(0.0, 0.5);
    let (resonance_hz, damping) = (draw.log_uniform(30.0, 150.0), draw.log_uniform(0.02, 0.1));
    let backlash_um = if draw.chance(0.3) { 0.0 } else { draw.uniform(0.0, 20.0) };
    let cogging = if draw.chance(0.4) { 0.0 } else { draw.uniform(0.03, 0.5) };
    let per_turn = f64::from(draw.0.random_range(1_u8..=12));
    let wave = if draw.chance(0.4) { 0.0 } else { draw.uniform(0.05, 0.3) };
    drive.loops.position_gain_1_s = position_gain_1_s;
    drive.loops.feed_forward = feed_forward;
    drive.loops.velocity_gain_n_m_s_rad = bandwidth_1_s * (table_kg + motor_kg) * per_rad * per_rad;
    drive.loops.integral_time_ms = 1e3 * draw.log_uniform(4.0, 15.0) / bandwidth_1_s;
    drive.motor.inertia_kg_m2 = motor_kg * per_rad * per_rad;
    drive.motor.torque_limit_n_m = 4.0 * ((table_kg + motor_kg) * 0.8 + 3.0 * coulomb_n) * per_rad;
    drive.motor.torque_noise_n_m = 0.01 * coulomb_n * per_rad;
    drive.motor.ripple = vec![Harmonic { amplitude: 0.004, per_turn: 6.0, phase_rad: draw.uniform(0.0, TAU) }];
    let amplitude_n_m = cogging * coulomb_n * per_rad;
    drive.motor.cogging = vec![TorqueHarmonic { amplitude_n_m, per_turn, phase_rad: draw.uniform(0.0, TAU) }];
    drive.table.mass_kg = table_kg;
    drive.table.force_noise_n = 0.01 * coulomb_n;
    let pulsation = TAU * resonance_hz;
    drive.screw.stiffness_n_m = table_kg * pulsation * pulsation;
    drive.screw.damping_n_s_m = 2.0 * damping * table_kg * pulsation;
    drive.screw.backlash_half_width_um = 0.5 * backlash_um;
    let friction = &mut drive.friction;
    friction.coulomb_n = coulomb_n;
    friction.static_n = coulomb_n * (1.0 + stribeck);
    friction.stribeck_mm_s = draw.log_uniform(0.5, 10.0);
    friction.motor_share = draw.uniform(0.3, 0.8);
    friction.direction_asymmetry = draw.uniform(-0.12, 0.12);
    friction.waves = vec![Wave { amplitude: wave, period_mm: draw.uniform(30.0, 60.0), phase_rad: draw.uniform(0.0, TAU) }];
    friction.screw_waves = Vec::new();
    let distance_um = draw.log_uniform(2.0, 20.0);
    let damping_n_s_m = 0.1 * table_kg * pulsation;
    friction.presliding = if maxwell {
        let shares = vec![0.3, 0.3, 0.25, 0.15];
        PreslidingSpec::Maxwell { shares, slip_um: [0.4, 1.0, 2.0, 4.0].map(|part| part * distance_um).to_vec(), damping_n_s_m }
    } else {
        PreslidingSpec::Lugre { stiffness_n_m: 0.5 * coulomb_n / (distance_um * 1e-6), damping_n_s_m }
    };
    let mut steps = 10.0;
    // The coarsest step that a description may have.
    while steps < 512.0 && 250.0 / steps > 25.0 {
        steps *= 2.0;
    }
    drive.loops.integration_step_us = 250.0 / steps;
    let cogging_um = cogging * coulomb_um;
    let cogging_mm = drive.screw.lead_mm / per_turn;
    Truth {
        position_gain_1_s,
        feed_forward,
        backlash_um,
        coulomb_um,
        stribeck,
        cogging_um,
        cogging_mm,
        wave,
        resonance_hz,
        damping,
    }
}

/// The runs of the excitation.
pub fn references(spec: &MachineSpec, seconds: f64, seed: u64) -> Vec<(String, Trajectory)> {
    let travel = vec![(-TRAVEL_MM, TRAVEL_MM); spec.axes.len()];
    let plan = ExcitationPlan::of_seconds(seconds);
    excite(&plan, &spec.limits(), &spec.motion_axes(), &travel, spec.sampling_period_s(), seed).unwrap()
}

/// The logs of the excitation.
pub fn logs(spec: &MachineSpec, seconds: f64, seed: u64) -> Vec<Log> {
    let mut machine = SimulatedMachine::new(spec, seed).unwrap();
    let run = |(name, reference): (String, Trajectory)| {
        let actual = machine.run(&reference).unwrap();
        Log::new(name, reference, actual).unwrap()
    };
    references(spec, seconds, seed).into_iter().map(run).collect()
}

/// Whether the machine follows a short excitation and then stands still.
fn is_stable(spec: &MachineSpec) -> bool {
    let Ok(machine) = SimulatedMachine::new(spec, 1) else { return false };
    let machine = machine.with_options(SimulationOptions::noise_free()).unwrap();
    let (_, reference) = references(spec, 20.0, 1).swap_remove(2);
    let columns = reference.columns().iter().map(|column| {
        let mut column = column.clone();
        column.extend(std::iter::repeat_n(column[column.len() - 1], 500));
        column
    });
    let reference = reference.with_columns(columns.collect()).unwrap();
    let Ok(run) = machine.run_with_seed(&reference, 1) else { return false };
    [&run.motor, &run.table].into_iter().all(|seen| {
        reference.columns().iter().zip(seen.columns()).all(|(wanted, column)| {
            let near = wanted.iter().zip(column).all(|(r, x)| (r - x).abs() < 6.0);
            let end = &column[column.len() - 200..];
            let (low, high) = end.iter().fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(*x), high.max(*x)));
            near && high - low < 1e-3
        })
    })
}
