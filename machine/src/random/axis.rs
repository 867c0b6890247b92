//! One random axis.

use std::f64::consts::TAU;

use super::common::{Common, FrictionKind, Smoothing, Structure, Train};
use super::draw::Draw;
use crate::spec::{
    DriveSpec, FrictionSpec, Harmonic, LoopSpec, MotorSpec, Patch, PreslidingSpec, ScrewSpec, TableSpec, TorqueHarmonic, Warming,
    Wave,
};

/// Draws of one axis.
pub(super) struct AxisDraw<'a> {
    pub common: Common,
    pub draw: &'a mut Draw,
}

/// Masses, forces and loops of an axis, referred to the table.
struct Masses {
    lead_mm: f64,
    table_kg: f64,
    motor_kg: f64,
    position_gain_1_s: f64,
    bandwidth_1_s: f64,
    coulomb_n: f64,
    static_n: f64,
}

impl Masses {
    /// Travel per rad of the motor, m.
    fn per_rad(&self) -> f64 {
        self.lead_mm * 1e-3 / TAU
    }

    fn total_kg(&self) -> f64 {
        self.table_kg + self.motor_kg
    }
}

/// Lead of a linear motor: 1 m per radian, so that torque is force and inertia is mass.
const LINEAR_LEAD_MM: f64 = 1e3 * TAU;
/// Period of the velocity loop, ms.
const VELOCITY_PERIOD_MS: f64 = 0.25;
/// Integral time for "no integral": a million seconds, ms.
const NO_INTEGRAL_MS: f64 = 1e9;
/// Viscous friction of motor and of table, referred to the table, N·s/m.
const VISCOUS_N_S_M: [f64; 2] = [10.0, 500.0];
/// Correlation time of force noise, ms, as in the built-in machines.
const NOISE_MS: f64 = 10.0;

impl AxisDraw<'_> {
    /// The whole drive.
    pub(super) fn drive(mut self) -> DriveSpec {
        let masses = self.masses();
        let screw = self.screw(&masses);
        let loops = self.loops(&masses);
        let motor = self.motor(&masses);
        let table = TableSpec {
            mass_kg: masses.table_kg,
            viscous_n_s_m: self.draw.log_uniform(VISCOUS_N_S_M[0], VISCOUS_N_S_M[1]),
            force_noise_n: self.draw.log_uniform(0.005, 0.05) * masses.coulomb_n,
            noise_time_ms: NOISE_MS,
            scale_resolution_um: self.common.encoder_step_um,
        };
        let friction = self.friction(&masses);
        let mut drive = DriveSpec { loops, motor, screw, table, friction };
        let mut steps = 2.0;
        // The coarsest step that the description allows.
        while steps < 512.0 && drive.loops.integration_step_us * 1e-6 > drive.largest_step_s() {
            steps *= 2.0;
            drive.loops.integration_step_us = VELOCITY_PERIOD_MS * 1e3 / steps;
        }
        drive
    }

    fn masses(&mut self) -> Masses {
        let table_kg = self.draw.log_uniform(10.0, 200.0);
        let lead_mm = self.draw.uniform(4.0, 20.0);
        let ratio = self.draw.log_uniform(0.5, 8.0);
        let linear = self.common.train == Train::LinearMotor;
        let (lead_mm, ratio) = if linear { (LINEAR_LEAD_MM, 0.1) } else { (lead_mm, ratio) };
        let motor_kg = ratio * table_kg;
        let total_kg = table_kg + motor_kg;
        let position_gain_1_s = self.common.position_gain_1_s * self.draw.uniform(0.99, 1.01);
        let bandwidth_1_s = position_gain_1_s * self.common.bandwidth_ratio * self.draw.uniform(0.95, 1.05);
        // Deflection of the loops without their integrators.
        let stiffness_n_m = total_kg * bandwidth_1_s * position_gain_1_s;
        let coulomb_n = stiffness_n_m * self.draw.log_uniform(1.0, 20.0) * 1e-6;
        let above = match self.common.friction {
            FrictionKind::Coulomb => 1.0,
            FrictionKind::Stribeck => self.draw.uniform(1.2, 1.6),
            FrictionKind::LuGre | FrictionKind::Maxwell => self.draw.uniform(1.0, 1.5),
        };
        Masses { lead_mm, table_kg, motor_kg, position_gain_1_s, bandwidth_1_s, coulomb_n, static_n: above * coulomb_n }
    }

    fn loops(&mut self, masses: &Masses) -> LoopSpec {
        let common = self.common;
        let Masses { position_gain_1_s, bandwidth_1_s, .. } = *masses;
        let feed_forward =
            if common.feed_forward > 0.0 { (common.feed_forward + self.draw.uniform(-0.01, 0.01)).max(0.0) } else { 0.0 };
        let integral_time_ms = 1e3 * self.draw.log_uniform(4.0, 15.0) / bandwidth_1_s;
        let pid = common.structure == Structure::Pid;
        let (command_average_ms, command_lag_ms) = match common.smoothing {
            Smoothing::None => (0.0, 0.0),
            Smoothing::Average(time) => (time, 0.0),
            Smoothing::Lag(time) => (0.0, time),
        };
        LoopSpec {
            position_gain_1_s,
            feed_forward,
            velocity_gain_n_m_s_rad: bandwidth_1_s * masses.total_kg() * masses.per_rad().powi(2),
            integral_time_ms: if pid { NO_INTEGRAL_MS } else { integral_time_ms },
            current_lag_ms: self.draw.log_uniform(0.2, 0.8),
            position_period_ms: 1.0,
            velocity_period_ms: VELOCITY_PERIOD_MS,
            integration_step_us: 0.5 * VELOCITY_PERIOD_MS * 1e3,
            position_integral_ms: pid.then_some(common.position_integral_ms),
            position_derivative: if pid { common.position_derivative } else { 0.0 },
            acceleration_feed_forward: common.acceleration_feed_forward,
            command_average_ms,
            command_lag_ms,
            delay_periods: common.delay_periods,
        }
    }

    fn motor(&mut self, masses: &Masses) -> MotorSpec {
        let per_rad = masses.per_rad();
        let force_n = masses.total_kg() * self.common.acceleration_mm_s2 * 1e-3;
        // Upper bound, of motor and table at the largest speed.
        let viscous_n = 2.0 * VISCOUS_N_S_M[1] * self.common.velocity_mm_s * 1e-3;
        // Ripple every 30 mm and cogging every 15 mm from the magnets of a linear motor.
        let linear = self.common.train == Train::LinearMotor;
        let per_turn = if linear { [masses.lead_mm / 30.0, masses.lead_mm / 15.0] } else { [6.0, 12.0] };
        let mut phase = || self.draw.uniform(0.0, TAU);
        let phases = [phase(), phase()];
        MotorSpec {
            inertia_kg_m2: masses.motor_kg * per_rad * per_rad,
            viscous_n_m_s_rad: self.draw.log_uniform(VISCOUS_N_S_M[0], VISCOUS_N_S_M[1]) * per_rad * per_rad,
            // Four times the demand of acceleration and friction: saturation is excluded.
            torque_limit_n_m: 4.0 * (force_n + 2.0 * masses.static_n + viscous_n) * per_rad,
            counts_per_turn: masses.lead_mm / (self.common.encoder_step_um * 1e-3),
            ripple: vec![Harmonic { amplitude: self.draw.uniform(0.0, 0.01), per_turn: per_turn[0], phase_rad: phases[0] }],
            cogging: vec![TorqueHarmonic {
                amplitude_n_m: self.draw.uniform(0.0, 0.05) * masses.coulomb_n * per_rad,
                per_turn: per_turn[1],
                phase_rad: phases[1],
            }],
            torque_noise_n_m: self.draw.log_uniform(0.005, 0.05) * masses.coulomb_n * per_rad,
            noise_time_ms: NOISE_MS,
        }
    }

    fn screw(&mut self, masses: &Masses) -> ScrewSpec {
        let resonance = TAU * self.draw.log_uniform(25.0, 150.0);
        let damping_ratio = self.draw.log_uniform(0.02, 0.1);
        let backlash_um = self.draw.log_uniform(0.5, 20.0);
        let rigid = self.common.train != Train::ElasticScrew;
        let backlash = !self.draw.chance(0.35) && !rigid;
        ScrewSpec {
            lead_mm: masses.lead_mm,
            stiffness_n_m: masses.table_kg * resonance * resonance,
            damping_n_s_m: 2.0 * damping_ratio * masses.table_kg * resonance,
            backlash_half_width_um: if backlash { 0.5 * backlash_um } else { 0.0 },
            rigid,
        }
    }

    fn friction(&mut self, masses: &Masses) -> FrictionSpec {
        let motor_share = self.draw.uniform(0.2, 0.8);
        let stribeck_mm_s = self.draw.log_uniform(0.5, 10.0);
        let presliding = self.presliding(masses, motor_share, stribeck_mm_s);
        let direction_asymmetry = self.draw.uniform(-0.12, 0.12);
        let (run_level, drift, drift_time_s) =
            (self.draw.uniform(0.0, 0.04), self.draw.uniform(0.0, 0.04), self.draw.log_uniform(1.0, 10.0));
        let waves = (0..*self.draw.one_of(&[0, 1, 2]))
            .map(|_| Wave {
                amplitude: self.draw.uniform(0.0, 0.12),
                period_mm: self.draw.uniform(15.0, 80.0),
                phase_rad: self.draw.uniform(0.0, TAU),
            })
            .collect();
        let patches = (0..*self.draw.one_of(&[0, 1, 2]))
            .map(|_| Patch {
                amplitude: self.draw.uniform(-0.25, 0.6),
                centre_mm: self.draw.uniform(-50.0, 50.0),
                width_mm: self.draw.uniform(3.0, 12.0),
            })
            .collect();
        let turn = Harmonic { amplitude: self.draw.uniform(0.0, 0.08), per_turn: 1.0, phase_rad: self.draw.uniform(0.0, TAU) };
        let screw = self.common.train != Train::LinearMotor;
        FrictionSpec {
            coulomb_n: masses.coulomb_n,
            static_n: masses.static_n,
            stribeck_mm_s,
            motor_share,
            direction_asymmetry,
            run_level,
            drift,
            drift_time_s,
            presliding,
            waves,
            screw_waves: if screw { vec![turn] } else { Vec::new() },
            patches,
            warming: self.common.warming.map(|(share, time_s)| Warming { share, time_s }),
        }
    }

    fn presliding(&mut self, masses: &Masses, motor_share: f64, stribeck_mm_s: f64) -> PreslidingSpec {
        let weaker_n = masses.coulomb_n * motor_share.min(1.0 - motor_share);
        let damping_ratio = self.draw.uniform(0.02, 0.15);
        // Below half of the damping up to which the models are passive with the friction of the
        // weaker side.
        let damping_n_s_m = |stiffness_n_m: f64| {
            (2.0 * damping_ratio * (stiffness_n_m * masses.table_kg).sqrt()).min(4.0 * weaker_n / (stribeck_mm_s * 1e-3))
        };
        let distance_um = match self.common.friction {
            FrictionKind::Maxwell => {
                let mut slip_um: Vec<f64> = (0..4).map(|_| self.draw.log_uniform(1.0, 30.0)).collect();
                slip_um.sort_by(f64::total_cmp);
                let raw: Vec<f64> = (0..4).map(|_| self.draw.uniform(0.5, 1.5)).collect();
                let sum: f64 = raw.iter().sum();
                let shares: Vec<f64> = raw.iter().map(|share| share / sum).collect();
                let stiffness_n_m =
                    0.5 * masses.coulomb_n * shares.iter().zip(&slip_um).map(|(share, um)| share / (um * 1e-6)).sum::<f64>();
                return PreslidingSpec::Maxwell { shares, slip_um, damping_n_s_m: damping_n_s_m(stiffness_n_m) };
            }
            FrictionKind::LuGre => self.draw.log_uniform(2.0, 20.0),
            FrictionKind::Coulomb | FrictionKind::Stribeck => self.draw.uniform(0.5, 1.0),
        };
        let stiffness_n_m = 0.5 * masses.coulomb_n / (distance_um * 1e-6);
        PreslidingSpec::Lugre { stiffness_n_m, damping_n_s_m: damping_n_s_m(stiffness_n_m) }
    }
}
