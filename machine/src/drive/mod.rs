//! One simulated drive: the loops of the controller, the motor, the mechanics and their friction.
//!
//! Lengths are named mm and m. A rotary drive uses the same code with mrad and rad; forces are then
//! torques.

mod friction;
mod loops;
mod mechanics;
mod motor;
mod noise;
mod plant;
mod reference;

use friction::{Friction, Level, Warmth};
use loops::{CurrentLag, PositionLoop, VelocityLoop};
use mechanics::{Loads, TwoMass};
use motor::Ripple;
use noise::{Coloured, normal};
use plant::Plant;
use rand_chacha::ChaCha8Rng;

use crate::options::{Sensor, SimulationOptions};
use crate::spec::{DriveSpec, Rates};

/// Readings of both sensors of an axis.
#[derive(Debug, Clone, Default)]
pub(crate) struct Readings {
    /// Motor encoder, mm of the table, one per sample.
    pub motor: Vec<f64>,
    /// Table scale, mm, one per sample.
    pub table: Vec<f64>,
}

/// Initial state of a drive.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Start {
    /// Initial position at standstill, mm.
    pub position_mm: f64,
    /// Running time of the machine before the run, s.
    pub elapsed_s: f64,
}

/// One drive during one run.
#[derive(Debug)]
pub(crate) struct Drive<'a> {
    spec: &'a DriveSpec,
    rates: Rates,
    options: SimulationOptions,
    plant: Plant,
    masses: TwoMass,
    sensor: Sensor,
    position_loop: PositionLoop,
    velocity_loop: VelocityLoop,
    current: CurrentLag,
    ripple: Ripple,
    level: Level,
    motor_friction: Friction,
    table_friction: Friction,
    run_level: f64,
    warmth: Warmth,
    drift: Coloured,
    torque_noise: Coloured,
    force_noise: Coloured,
    rng: ChaCha8Rng,
}

/// Torque, forces and friction level, constant during one period of the velocity loop.
#[derive(Debug, Clone, Copy)]
struct Held {
    command: f64,
    ripple: f64,
    extra_torque: f64,
    disturbance: f64,
    level: f64,
}

impl<'a> Drive<'a> {
    /// A drive at standstill. All noise of the run is drawn from `rng`.
    pub(crate) fn at_rest(
        spec: &'a DriveSpec,
        rates: Rates,
        options: SimulationOptions,
        sensor: Sensor,
        start: Start,
        mut rng: ChaCha8Rng,
    ) -> Self {
        let plant = Plant::new(spec);
        let noise = options.noise_scale;
        let tick_s = spec.loops.velocity_period_ms * 1e-3;
        let friction = &spec.friction;
        let run_level = if noise > 0.0 { 1.0 + noise * friction.run_level * normal(&mut rng) } else { 1.0 };
        Self {
            masses: TwoMass::at_rest(start.position_mm * 1e-3, &plant),
            sensor,
            position_loop: PositionLoop::new(&spec.loops),
            velocity_loop: VelocityLoop::new(&spec.loops, spec.motor.torque_limit_n_m),
            current: CurrentLag::new(spec.loops.current_lag_ms * 1e-3, spec.loops.integration_step_us * 1e-6),
            ripple: Ripple::new(&spec.motor),
            level: Level::new(friction),
            motor_friction: Friction::new(friction, friction.motor_share),
            table_friction: Friction::new(friction, 1.0 - friction.motor_share),
            run_level,
            warmth: Warmth::new(friction.warming, noise, start.elapsed_s, tick_s),
            drift: Coloured::new(noise * friction.drift, friction.drift_time_s, tick_s, &mut rng),
            torque_noise: Coloured::new(noise * spec.motor.torque_noise_n_m, spec.motor.noise_time_ms * 1e-3, tick_s, &mut rng),
            force_noise: Coloured::new(noise * spec.table.force_noise_n, spec.table.noise_time_ms * 1e-3, tick_s, &mut rng),
            spec,
            rates,
            options,
            plant,
            rng,
        }
    }

    /// Follows `reference_mm` and reads both sensors at each of its samples.
    pub(crate) fn follow(mut self, reference_mm: &[f64], period_s: f64) -> Readings {
        let mut readings = Readings::default();
        let commands = reference::commands(reference_mm, &self.spec.loops, self.rates, period_s, self.options.interpolation);
        // Both masses as one, in N·m per mm/s².
        let mass = self.plant.table_inertia * self.plant.per_rad + self.plant.motor_inertia / self.plant.per_rad;
        let torque_per_rate = self.spec.loops.acceleration_feed_forward * mass * 1e-3;
        for k in 0..reference_mm.len() {
            readings.motor.push(self.motor_mm());
            readings.table.push(self.table_mm());
            if k + 1 == reference_mm.len() {
                break;
            }
            let loops = self.rates.position_per_sample;
            for command in &commands[k * loops..(k + 1) * loops] {
                let measured = match self.sensor {
                    Sensor::Motor => self.motor_mm(),
                    Sensor::Table => self.table_mm(),
                };
                let velocity_mm_s = self.position_loop.step(command, measured);
                let speed = velocity_mm_s * 1e-3 / self.plant.per_rad;
                let feed_torque = torque_per_rate * command.acceleration;
                for _ in 0..self.rates.velocity_per_position {
                    self.velocity_period(speed, feed_torque);
                }
            }
        }
        readings
    }

    /// One period of the velocity loop at the commanded motor speed, rad/s, with a feed-forward
    /// torque, N·m.
    fn velocity_period(&mut self, commanded: f64, feed_torque: f64) {
        let command = self.velocity_loop.step(commanded - self.masses.speed, feed_torque);
        let (ripple, cogging) = self.ripple.at(self.masses.angle);
        let level_here = self.level.at(self.masses.position * 1e3, self.masses.angle);
        let held = Held {
            command,
            ripple,
            extra_torque: cogging + self.torque_noise.step(&mut self.rng),
            disturbance: self.force_noise.step(&mut self.rng),
            // Amplified noise must not change the sign of friction.
            level: level_here * (self.run_level * self.warmth.step() * (1.0 + self.drift.step(&mut self.rng))).max(0.0),
        };
        let step_s = self.spec.loops.integration_step_us * 1e-6;
        for _ in 0..self.rates.steps_per_velocity {
            self.integrate(held, step_s);
        }
    }

    /// One integration step.
    fn integrate(&mut self, held: Held, step_s: f64) {
        let torque = self.current.step(held.command) * held.ripple + held.extra_torque;
        self.masses.drift(step_s);
        let motor_velocity = self.masses.speed * self.plant.per_rad;
        let motor_friction = self.motor_friction.step(motor_velocity, held.level, step_s);
        let table_friction = self.table_friction.step(self.masses.velocity, held.level, step_s);
        let loads = Loads { torque, motor_friction, table_friction, disturbance: held.disturbance };
        self.masses.kick(&self.plant, loads, step_s);
    }

    /// Reading of the motor encoder, mm of the table.
    fn motor_mm(&self) -> f64 {
        let count = std::f64::consts::TAU / self.spec.motor.counts_per_turn;
        self.quantised(self.masses.angle, count) * self.plant.per_rad * 1e3
    }

    /// Reading of the table scale, mm.
    fn table_mm(&self) -> f64 {
        self.quantised(self.masses.position * 1e3, self.spec.table.scale_resolution_um * 1e-3)
    }

    fn quantised(&self, value: f64, count: f64) -> f64 {
        if self.options.quantised { (value / count).round() * count } else { value }
    }
}
