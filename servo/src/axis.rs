//! The servo models of several axes, step by step.
//!
//! ```text
//! position loop   v* = K_v (e + k_i ∫e dt) + k_ff ṙ,  e = r − x,  delayed
//! velocity loop   u = ω_b (v* − θ̇) + k ω_b² ∫(v* − θ̇) dt + k_a r̈ − β ω_b θ̇ + c
//! one mass        θ̈ = u − f(θ̇),  x = θ
//! two masses      (1 − μ) θ̈ = u − (1 − σ) f(θ̇) − μ s,  ẍ = s − σ/μ f(ẋ) − τβ/μ ω_b ẋ,  s = Ω² dead(θ − x) + 2ζΩ (θ̇ − ẋ) in contact;
//!                 β (1 − τ) is left on the motor; the loop is closed, and logged, on the table, on the motor (hidden table), or on each
//! friction        f = F λ(x) c (1 + α sign v), with the contacts' force c of `contacts` and the level λ of the place
//! ```
//! The cascade and the two masses of a feed drive (Paper D, eq. 1-7), per moved mass, with the current loop in the delay. Without integrals
//! it is the PD law of simple controls, with that of the position loop their PID.

use crate::contacts::Contacts;
use crate::lanes::Lanes;
use crate::parameters::Servo;
use crate::table::Table;

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

/// State of the models of several axes of one structure: an axis per lane, at `r` and `ṙ` of its own.
pub struct Axis<'a, const L: usize> {
    servos: &'a [Servo; L],
    step_s: f64,
    period_s: f64,
    gains: Gains<L>,
    /// Friction of the motor and of the table at the present place, mm/s².
    level: Lanes<L>,
    /// Constant force on the motor and on the table, mm/s².
    force: [Lanes<L>; 2],
    motor: Lanes<L>,
    velocity: Lanes<L>,
    sensor: Lanes<L>,
    logged: Lanes<L>,
    table: Table<L>,
    motor_contacts: Contacts<L>,
    table_contacts: Contacts<L>,
    integral: Lanes<L>,
    position_integral: Lanes<L>,
    /// Slopes of the last sampling period, for the acceleration of the command.
    slopes: Ring<L>,
    /// Velocity commands on their way.
    late: Ring<L>,
    /// Whole steps by which they are late, and the fraction of a further one.
    late_steps: [usize; L],
    late_part: Lanes<L>,
}

/// The parameters, as the steps need them.
struct Gains<const L: usize> {
    position_1_s: Lanes<L>,
    feed_forward: Lanes<L>,
    velocity_per_acceleration_s: Lanes<L>,
    acceleration_feed_forward: Lanes<L>,
    bandwidth_1_s: Lanes<L>,
    /// Integrals per step.
    integral: Lanes<L>,
    position_integral: Lanes<L>,
    /// One over the motor's share of the mass, and what damping leaves of its velocity after a step.
    motor: Lanes<L>,
    motor_damped: Lanes<L>,
    /// Coulomb friction, mm/s²; its share on the motor, and that on the table over the table's mass.
    friction: Lanes<L>,
    on_motor: Lanes<L>,
    on_table: Lanes<L>,
    table_mass: Lanes<L>,
    table_damped: Lanes<L>,
    /// −1 where the motor encoder closes the loop of an axis that is logged on its table.
    sees_motor: Lanes<L>,
    two_masses: bool,
}

impl<const L: usize> Gains<L> {
    fn of(servos: &[Servo; L], step_s: f64) -> Self {
        let two_masses = servos[0].table_pulsation_1_s > 0.0;
        let motor_mass = |servo: &Servo| if two_masses { 1.0 - servo.table_mass } else { 1.0 };
        let on_table = |servo: &Servo| if two_masses { servo.table_viscous * servo.viscous } else { 0.0 };
        let motor_damping = |servo: &Servo| servo.bandwidth_1_s * (1.0 + servo.viscous - on_table(servo)) / motor_mass(servo);
        Self {
            position_1_s: Lanes::each(servos, |servo| servo.position_gain_1_s),
            feed_forward: Lanes::each(servos, |servo| servo.feed_forward),
            velocity_per_acceleration_s: Lanes::each(servos, |servo| servo.velocity_per_acceleration_s),
            acceleration_feed_forward: Lanes::each(servos, |servo| servo.acceleration_feed_forward),
            bandwidth_1_s: Lanes::each(servos, |servo| servo.bandwidth_1_s),
            integral: Lanes::each(servos, |servo| servo.integral * servo.bandwidth_1_s.powi(2) * step_s),
            position_integral: Lanes::each(servos, |servo| servo.position_integral_1_s * step_s),
            motor: Lanes::each(servos, |servo| motor_mass(servo).recip()),
            motor_damped: Lanes::each(servos, |servo| (1.0 + step_s * motor_damping(servo)).recip()),
            friction: Lanes::each(servos, |servo| servo.coulomb_mm * servo.stiffness_1_s2()),
            on_motor: Lanes::each(servos, |servo| if two_masses { 1.0 - servo.table_friction } else { 1.0 }),
            on_table: Lanes::each(servos, |servo| servo.table_friction / servo.table_mass),
            table_mass: Lanes::each(servos, |servo| servo.table_mass),
            table_damped: Lanes::each(servos, |servo| {
                (1.0 + step_s * servo.bandwidth_1_s * on_table(servo) / servo.table_mass).recip()
            }),
            sees_motor: Lanes::each(servos, |servo| if servo.outer_backlash_mm > 0.0 { -1.0 } else { 0.0 }),
            two_masses,
        }
    }
}

impl<'a, const L: usize> Axis<'a, L> {
    /// The axes at rest or in steady motion.
    pub fn at(servos: &'a [Servo; L], step_s: f64, steps: usize, command: Lanes<L>, starts: [Start; L]) -> Self {
        let position = Lanes::each(&starts, |start| start.position_mm);
        let velocity = Lanes::each(&starts, |start| start.velocity_mm_s);
        let contacts = Contacts::at(servos, velocity, step_s);
        let gains = Gains::of(servos, step_s);
        let constant = Lanes::each(servos, |servo| servo.offset_mm * servo.stiffness_1_s2());
        let level = Lanes::of(|lane| servos[lane].level(position.0[lane]));
        // What the integrators have to hold against, mm/s².
        let viscous = Lanes::each(servos, |servo| servo.viscous);
        let needed = gains.friction * level * contacts.force() + viscous * gains.bandwidth_1_s * velocity - constant;
        let fed = velocity * (Lanes::all(1.0) - gains.feed_forward) + needed / gains.bandwidth_1_s;
        let behind = fed / gains.position_1_s - (command - position);
        let held = |lane: usize, gain: f64, value: f64| if starts[lane].held && gain > 0.0 { value } else { 0.0 };
        let late = Lanes::each(servos, |servo| servo.loop_delay_s / step_s);
        let late_steps = late.0.map(|late| late as usize);
        Self {
            servos,
            step_s,
            period_s: step_s * steps as f64,
            level: gains.friction * level,
            force: [constant, Lanes::all(0.0)],
            motor: position,
            velocity,
            sensor: position,
            logged: position,
            table: Table::at(servos, position, velocity),
            motor_contacts: contacts,
            table_contacts: contacts,
            integral: Lanes::of(|lane| held(lane, servos[lane].integral, needed.0[lane])),
            position_integral: Lanes::of(|lane| held(lane, servos[lane].position_integral_1_s, behind.0[lane])),
            slopes: Ring::filled(velocity, steps),
            // The present one, the latest whole step, and the one before it.
            late: Ring::filled(velocity, late_steps.iter().max().map_or(0, |most| most + 2)),
            late_part: Lanes::of(|lane| late.0[lane] - late_steps[lane] as f64),
            late_steps,
            gains,
        }
    }

    /// Friction changes along the axis much more slowly than from step to step.
    #[inline(always)]
    pub fn take_level(&mut self) {
        self.level = self.gains.friction * Lanes::of(|lane| self.servos[lane].level(self.logged.0[lane]));
    }

    /// The logged positions, mm.
    #[inline(always)]
    pub fn logged(&self) -> Lanes<L> {
        self.logged
    }

    /// Friction of the motors, mm/s².
    pub fn friction(&self) -> Lanes<L> {
        self.level * self.motor_contacts.force()
    }

    /// Sets a force, mm/s², and the share of it that acts on the table.
    pub fn push(&mut self, force: Lanes<L>, on_table: f64) {
        self.force = [force * (1.0 - on_table), force * on_table];
    }

    /// One step of the integration under a command, mm, and its slope, mm/s.
    #[inline(always)]
    pub fn step(&mut self, command: Lanes<L>, slope: Lanes<L>) {
        let gains = &self.gains;
        let error = command - self.sensor;
        self.position_integral += gains.position_integral * error;
        let acceleration = (slope - self.slopes.replaced(slope)) * self.period_s.recip();
        let fed_forward = gains.feed_forward * slope + gains.velocity_per_acceleration_s * acceleration;
        let wanted = self.late.delayed(
            gains.position_1_s * (error + self.position_integral) + fed_forward,
            &self.late_steps,
            self.late_part,
        );
        self.integral += gains.integral * (wanted - self.velocity);
        let [on_motor, on_table] = self.force;
        let torque = gains.bandwidth_1_s * wanted + self.integral + gains.acceleration_feed_forward * acceleration + on_motor;
        let friction = self.level * self.motor_contacts.step(self.velocity);
        if !gains.two_masses {
            self.velocity = (self.velocity + (torque - friction + on_table) * self.step_s) * gains.motor_damped;
            self.motor += self.velocity * self.step_s;
            (self.sensor, self.logged) = (self.motor, self.motor);
            return;
        }
        let screw = self.table.pulled(self.motor, self.velocity);
        let on_slide = self.level * self.table_contacts.step(self.table.velocity);
        let motor = (torque - gains.on_motor * friction - gains.table_mass * screw) * gains.motor;
        self.velocity = (self.velocity + motor * self.step_s) * gains.motor_damped;
        self.motor += self.velocity * self.step_s;
        let table = screw - gains.on_table * on_slide + on_table / gains.table_mass;
        self.table.velocity = (self.table.velocity + table * self.step_s) * gains.table_damped;
        self.table.position += self.table.velocity * self.step_s;
        self.logged = if self.servos[0].hides_table { self.motor } else { self.table.position };
        self.sensor = gains.sees_motor.where_below(0.0, self.motor, self.logged);
    }
}

/// The last values of a signal.
struct Ring<const L: usize> {
    values: Vec<Lanes<L>>,
    next: usize,
}

impl<const L: usize> Ring<L> {
    fn filled(value: Lanes<L>, count: usize) -> Self {
        Self { values: vec![value; count.max(1)], next: 0 }
    }

    /// Takes in a value and returns the one that it displaces, from as many steps ago as the ring holds.
    #[inline(always)]
    fn replaced(&mut self, value: Lanes<L>) -> Lanes<L> {
        let oldest = std::mem::replace(&mut self.values[self.next], value);
        self.next = if self.next + 1 == self.values.len() { 0 } else { self.next + 1 };
        oldest
    }

    /// Takes in a value and returns the one of `steps + part` steps ago, for every lane.
    #[inline(always)]
    fn delayed(&mut self, value: Lanes<L>, steps: &[usize; L], part: Lanes<L>) -> Lanes<L> {
        let (now, count) = (self.next, self.values.len());
        self.replaced(value);
        let ago = |lane: usize, steps: usize| {
            let place = if now >= steps { now - steps } else { now + count - steps };
            self.values[place].0[lane]
        };
        let (late, before) = (Lanes::of(|lane| ago(lane, steps[lane])), Lanes::of(|lane| ago(lane, steps[lane] + 1)));
        part * before + (Lanes::all(1.0) - part) * late
    }
}
