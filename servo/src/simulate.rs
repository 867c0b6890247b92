//! The servo model of an axis, run on a command.
//!
//! ```text
//! position loop   v* = K_v (e + k_i ∫e dt) + k_ff ṙ,  e = r − x,  delayed
//! velocity loop   u = ω_b (v* − θ̇) + k ω_b² ∫(v* − θ̇) dt + k_a r̈ − β ω_b θ̇ + c
//! one mass        θ̈ = u − f(θ̇),  x = θ
//! two masses      (1 − μ) θ̈ = u − (1 − σ) f(θ̇) − μ s,  ẍ = s − σ/μ f(ẋ) − τβ/μ ω_b ẋ,  s = Ω² dead(θ − x) + 2ζΩ (θ̇ − ẋ) in contact;
//!                 β (1 − τ) is left on the motor; the loop is closed, and logged, on the table, on the motor (hidden table), or on each
//! friction        f = F λ(x) c (1 + α sign v), with the contacts' force c of `contacts` and the level λ of the place
//! command         r = the logged command, late by the delay, averaged, then behind a first-order lag
//! ```
//! The cascade and the two masses of a feed drive (Paper D, eq. 1-7), per moved mass, with the current loop in the delay. Without integrals
//! it is the PD law of simple controls, with that of the position loop their PID.

use crate::command::Command;
use crate::contacts::Contacts;
use crate::parameters::Servo;
use crate::table::Table;

/// Largest step of the integration, s: half the period of a usual position loop.
pub const STEP_S: f64 = 5e-4;

/// A simulated run.
#[derive(Debug, Clone, Default)]
pub struct Simulated {
    /// Actual positions at the samples of the reference, mm.
    pub positions: Vec<f64>,
    /// Friction at the samples, as a deflection, mm: against the direction of motion.
    pub friction_mm: Vec<f64>,
}

/// Start of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start {
    /// Position, mm.
    pub position_mm: f64,
    /// Velocity, mm/s.
    pub velocity_mm_s: f64,
    /// Whether the integrators hold the axis in this state; else they are empty.
    pub held: bool,
}

impl From<(f64, f64)> for Start {
    /// A measured position (mm) and velocity (mm/s), with empty integrators.
    fn from((position_mm, velocity_mm_s): (f64, f64)) -> Self {
        Self { position_mm, velocity_mm_s, held: false }
    }
}

/// Speed above which an axis moves, mm/s.
pub const MOVING_MM_S: f64 = 0.05;
/// Samples over which the speed at the start of a command is taken.
const START_SAMPLES: usize = 5;

/// Actual positions of the model at the samples of `reference`, mm. Starts at `start`.
#[must_use]
pub fn simulate(servo: &Servo, reference: &[f64], period_s: f64, start: impl Into<Start>) -> Vec<f64> {
    simulate_with_friction(servo, reference, period_s, start).positions
}

/// Speed of a command at its start, mm/s; 0 where it is at rest.
#[must_use]
pub fn speed_at_start(reference: &[f64], period_s: f64) -> f64 {
    let over = START_SAMPLES.min(reference.len().saturating_sub(1));
    let moves = reference.windows(2).take(over).any(|pair| (pair[1] - pair[0]).abs() > MOVING_MM_S * period_s);
    if moves { (reference[over] - reference[0]) / (over as f64 * period_s) } else { 0.0 }
}

impl Servo {
    /// Actual positions that the axis takes under a command, mm, where nothing but the command is known: it starts at the rest that the
    /// fit found, or in steady motion.
    #[must_use]
    pub fn follow(&self, reference: &[f64], period_s: f64) -> Vec<f64> {
        simulate(self, reference, period_s, self.start(reference, period_s))
    }

    /// Expected start of a run.
    #[must_use]
    pub fn start(&self, reference: &[f64], period_s: f64) -> Start {
        let velocity = speed_at_start(reference, period_s);
        let first = reference.first().copied().unwrap_or(0.0);
        let behind = if velocity == 0.0 { self.start_error_mm } else { velocity * self.lag_s() };
        Start { position_mm: first - behind, velocity_mm_s: velocity, held: true }
    }
}

/// As [`simulate`], with the friction.
#[must_use]
pub fn simulate_with_friction(servo: &Servo, reference: &[f64], period_s: f64, start: impl Into<Start>) -> Simulated {
    let start = start.into();
    let mut out = Simulated { positions: Vec::with_capacity(reference.len()), friction_mm: Vec::with_capacity(reference.len()) };
    if reference.is_empty() {
        return out;
    }
    let steps = (period_s / STEP_S).ceil().max(1.0) as usize;
    let step_s = period_s / steps as f64;
    let command = Command::new(reference, servo.channel_delay_s / period_s, servo.command_average_s / period_s);
    let mut here = command.position(0.0);
    let mut axis = Axis::at(servo, step_s, steps, here, start);
    let approach = if servo.command_lag_s > 0.0 { 1.0 - (-step_s / servo.command_lag_s).exp() } else { 1.0 };
    here -= start.velocity_mm_s * servo.command_lag_s;
    for k in 0..reference.len() {
        out.positions.push(axis.logged);
        out.friction_mm.push(servo.coulomb_mm * axis.level * axis.motor_contacts.force());
        axis.take_level();
        for i in 1..=steps {
            let given = command.position(k as f64 + i as f64 / steps as f64);
            let next = here + approach * (given - here);
            axis.step(here, (next - here) / step_s);
            here = next;
        }
    }
    out
}

/// State of the model.
pub struct Axis<'a> {
    servo: &'a Servo,
    step_s: f64,
    friction: f64,
    /// Friction at the present place over that elsewhere.
    level: f64,
    /// Share of the motor in the moved mass.
    motor_mass: f64,
    /// Viscous friction on the motor over the velocity gain.
    motor_viscous: f64,
    constant: f64,
    /// Another force on the table, mm/s².
    table_force: f64,
    motor: f64,
    velocity: f64,
    sensor: f64,
    logged: f64,
    table: Table,
    motor_contacts: Contacts,
    table_contacts: Contacts,
    integral: f64,
    position_integral: f64,
    /// Slopes of the last sampling period, for the acceleration of the command.
    slopes: Ring,
    /// Velocity commands on their way.
    late: Ring,
    /// Fraction of a step by which they are later than the ring is long.
    late_part: f64,
    period_s: f64,
}

impl<'a> Axis<'a> {
    /// The axis at rest or in steady motion.
    pub fn at(servo: &'a Servo, step_s: f64, steps: usize, command: f64, start: Start) -> Self {
        let Start { position_mm: position, velocity_mm_s: velocity, held } = start;
        let stiffness = servo.bandwidth_1_s * servo.position_gain_1_s;
        let contacts = Contacts::at(servo, velocity);
        let (friction, constant) = (servo.coulomb_mm * stiffness, servo.offset_mm * stiffness);
        let level = servo.level(position);
        // What the integrators have to hold against, mm/s².
        let needed = friction * level * contacts.force() + servo.viscous * servo.bandwidth_1_s * velocity - constant;
        let fed = velocity * (1.0 - servo.feed_forward) + needed / servo.bandwidth_1_s;
        let integral = if held && servo.integral > 0.0 { needed } else { 0.0 };
        let position_integral =
            if held && servo.position_integral_1_s > 0.0 { fed / servo.position_gain_1_s - (command - position) } else { 0.0 };
        let late = servo.loop_delay_s / step_s;
        let whole = late.floor();
        let two_masses = servo.table_pulsation_1_s > 0.0;
        Self {
            servo,
            step_s,
            friction,
            level,
            motor_mass: if two_masses { 1.0 - servo.table_mass } else { 1.0 },
            motor_viscous: if two_masses { servo.viscous * (1.0 - servo.table_viscous) } else { servo.viscous },
            constant,
            table_force: 0.0,
            motor: position,
            velocity,
            sensor: position,
            logged: position,
            table: Table::at(servo, position, velocity),
            motor_contacts: contacts,
            table_contacts: contacts,
            integral,
            position_integral,
            slopes: Ring::filled(velocity, steps),
            late: Ring::filled(velocity, whole as usize + 1),
            late_part: late - whole,
            period_s: step_s * steps as f64,
        }
    }

    /// Friction changes along the axis much more slowly than from step to step.
    fn take_level(&mut self) {
        self.level = self.servo.level(self.logged);
    }

    /// The logged position, mm.
    pub fn logged(&self) -> f64 {
        self.logged
    }

    /// Sets a force, as the deflection of the loops without integrator, and the share of it that acts on the table.
    pub fn push(&mut self, deflection_mm: f64, on_table: f64) {
        let force = deflection_mm * self.servo.bandwidth_1_s * self.servo.position_gain_1_s;
        self.constant = (1.0 - on_table) * force;
        self.table_force = on_table * force;
    }

    /// One step of the integration under a command, mm, and its slope, mm/s.
    pub fn step(&mut self, command: f64, slope: f64) {
        let Servo { position_gain_1_s, feed_forward, bandwidth_1_s, integral, position_integral_1_s, .. } = *self.servo;
        let error = command - self.sensor;
        self.position_integral += position_integral_1_s * error * self.step_s;
        let acceleration = (slope - self.slopes.replaced(slope)) / self.period_s;
        let fed_forward = feed_forward * slope + self.servo.velocity_per_acceleration_s * acceleration;
        let wanted = self.late.delayed(position_gain_1_s * (error + self.position_integral) + fed_forward, self.late_part);
        self.integral += integral * bandwidth_1_s * bandwidth_1_s * (wanted - self.velocity) * self.step_s;
        let torque = bandwidth_1_s * wanted + self.integral + self.servo.acceleration_feed_forward * acceleration + self.constant;
        let damping = bandwidth_1_s * (1.0 + self.motor_viscous) / self.motor_mass;
        let level = self.friction * self.level;
        let Servo { table_pulsation_1_s, table_friction, table_mass, .. } = *self.servo;
        if table_pulsation_1_s == 0.0 {
            let friction = level * self.motor_contacts.step(self.servo, self.velocity, self.step_s) - self.table_force;
            self.velocity = (self.velocity + self.step_s * (torque - friction)) / (1.0 + self.step_s * damping);
            self.motor += self.step_s * self.velocity;
            (self.sensor, self.logged) = (self.motor, self.motor);
            return;
        }
        let screw = self.table.pulled(self.servo, self.motor, self.velocity);
        let on_motor = (1.0 - table_friction) * level * self.motor_contacts.step(self.servo, self.velocity, self.step_s);
        let on_table =
            table_friction * level * self.table_contacts.step(self.servo, self.table.velocity, self.step_s) / table_mass;
        let motor = (torque - on_motor - table_mass * screw) / self.motor_mass;
        self.velocity = (self.velocity + self.step_s * motor) / (1.0 + self.step_s * damping);
        self.motor += self.step_s * self.velocity;
        let table_damping = bandwidth_1_s * (self.servo.viscous - self.motor_viscous) / table_mass;
        let table = screw - on_table + self.table_force / table_mass;
        self.table.velocity = (self.table.velocity + self.step_s * table) / (1.0 + self.step_s * table_damping);
        self.table.position += self.step_s * self.table.velocity;
        self.logged = if self.servo.hides_table { self.motor } else { self.table.position };
        self.sensor = if self.servo.outer_backlash_mm > 0.0 { self.motor } else { self.logged };
    }
}

/// The last values of a signal.
struct Ring {
    values: Vec<f64>,
    next: usize,
}

impl Ring {
    fn filled(value: f64, count: usize) -> Self {
        Self { values: vec![value; count.max(1)], next: 0 }
    }

    /// Takes in a value and returns the one that it displaces, from as many steps ago as the ring holds.
    fn replaced(&mut self, value: f64) -> f64 {
        let oldest = std::mem::replace(&mut self.values[self.next], value);
        self.next = if self.next + 1 == self.values.len() { 0 } else { self.next + 1 };
        oldest
    }

    /// Takes in a value and returns the one of `len − 1 + part` steps ago.
    fn delayed(&mut self, value: f64, part: f64) -> f64 {
        let oldest = self.replaced(value);
        part * oldest + (1.0 - part) * self.values[self.next]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_S: f64 = 0.002;

    fn error_at_the_end(servo: &Servo, speed: f64) -> f64 {
        let ramp: Vec<f64> = (0..1500).map(|k| speed * PERIOD_S * f64::from(k)).collect();
        let actual = simulate(servo, &ramp, PERIOD_S, (0.0, 0.0));
        ramp[1499] - actual[1499]
    }

    #[test]
    fn a_ramp_lags_by_the_stated_time() {
        let cascade = Servo { coulomb_mm: 0.0, ..Servo::usual(50.0, 0.6) };
        for servo in [
            cascade,
            Servo { integral: 0.0, viscous: 0.05, ..cascade },
            Servo { channel_delay_s: 0.0031, command_average_s: 0.012, ..cascade },
            Servo { loop_delay_s: 0.0023, ..cascade },
        ] {
            let error = error_at_the_end(&servo, 40.0);
            assert!((error - 40.0 * servo.lag_s()).abs() < 1e-4, "{error} {servo:?}");
        }
    }

    #[test]
    fn friction_deflects_a_loop_without_integrator_by_its_own_measure() {
        let servo = Servo { integral: 0.0, coulomb_mm: 7e-3, ..Servo::usual(60.0, 1.0) };
        for sign in [1.0, -1.0] {
            let error = error_at_the_end(&servo, sign * 30.0);
            assert!((sign * error - 7e-3).abs() < 1e-5, "{error}");
        }
        let asymmetric = Servo { asymmetry: 0.1, ..servo };
        assert!((error_at_the_end(&asymmetric, 30.0) - 7.7e-3).abs() < 1e-5);
        assert!((error_at_the_end(&asymmetric, -30.0) + 6.3e-3).abs() < 1e-5);
    }

    #[test]
    fn the_table_stands_while_the_motor_crosses_the_backlash() {
        let servo = Servo { backlash_mm: 0.02, table_pulsation_1_s: 1500.0, coulomb_mm: 0.0, ..Servo::usual(60.0, 1.0) };
        let wave: Vec<f64> = (0..2000).map(|k| 5.0 - 5.0 * (3.0 * PERIOD_S * f64::from(k)).cos()).collect();
        let swing = |servo: &Servo| {
            let actual = simulate(servo, &wave, PERIOD_S, (0.0, 0.0));
            wave.iter().zip(&actual).skip(500).map(|(r, x)| (r - x).abs()).fold(0.0, f64::max)
        };
        // Crossed within a few milliseconds near standstill: the error is most of the width, then decays by K_v.
        let (with, without) = (swing(&servo), swing(&Servo { backlash_mm: 0.0, ..servo }));
        assert!(with - without > 0.006 && with < 0.03, "{with} {without}");
    }
}
