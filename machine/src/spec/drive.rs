//! Simulated linear drives in a machine file.

use serde::{Deserialize, Serialize};

use super::check::{Names, finite, multiple, not_negative, positive, within};
use super::friction::FrictionSpec;
use super::waves::{Harmonic, TorqueHarmonic};
use crate::MachineError;

/// A simulated ball-screw drive: loops, motor, screw, table and friction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DriveSpec {
    /// The cascaded controller.
    pub loops: LoopSpec,
    /// The motor and its encoder.
    pub motor: MotorSpec,
    /// Screw between motor and table.
    pub screw: ScrewSpec,
    /// The table and its scale.
    pub table: TableSpec,
    /// Friction on both sides of the screw.
    pub friction: FrictionSpec,
}

/// Position, velocity and current loop.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoopSpec {
    /// Position gain `K_pp`, 1/s.
    pub position_gain_1_s: f64,
    /// Feed-forward `k_ff` of the reference velocity, as a fraction.
    pub feed_forward: f64,
    /// Proportional gain of the velocity loop, N·m·s/rad.
    pub velocity_gain_n_m_s_rad: f64,
    /// Integral time of the velocity loop, ms.
    pub integral_time_ms: f64,
    /// Time constant of the current loop, ms.
    pub current_lag_ms: f64,
    /// Period of the position loop, ms.
    pub position_period_ms: f64,
    /// Period of the velocity loop, ms. Ripple, noise and friction levels are updated at this rate.
    pub velocity_period_ms: f64,
    /// Integration step of the mechanics, µs.
    pub integration_step_us: f64,
    /// Integral time of the position loop, ms, for PI or PID. Absent: no integral.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position_integral_ms: Option<f64>,
    /// Derivative gain of the position loop: speed per rate of the tracking error, no unit.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub position_derivative: f64,
    /// Feed-forward of the torque for the reference acceleration, as a fraction, with motor and
    /// table as one mass.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub acceleration_feed_forward: f64,
    /// Moving average over the reference before the position loop, ms.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub command_average_ms: f64,
    /// Time constant of a first-order lag on the reference before the position loop, ms.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub command_lag_ms: f64,
    /// Delay of the position loop output, periods of the position loop.
    #[serde(default, skip_serializing_if = "is_none")]
    pub delay_periods: u8,
}

#[allow(clippy::trivially_copy_pass_by_ref)] // serde passes a reference
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

#[allow(clippy::trivially_copy_pass_by_ref)] // serde passes a reference
fn is_none(count: &u8) -> bool {
    *count == 0
}

/// A motor with an encoder on its shaft.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MotorSpec {
    /// Inertia of the motor and of the parts on its shaft (screw, worm), kg·m².
    pub inertia_kg_m2: f64,
    /// Viscous friction, N·m·s/rad.
    pub viscous_n_m_s_rad: f64,
    /// Largest commanded torque, N·m.
    pub torque_limit_n_m: f64,
    /// Encoder counts per turn.
    pub counts_per_turn: f64,
    /// Ripple, as a fraction of the torque.
    pub ripple: Vec<Harmonic>,
    /// Cogging torque.
    pub cogging: Vec<TorqueHarmonic>,
    /// Standard deviation of the torque noise, N·m.
    pub torque_noise_n_m: f64,
    /// Correlation time of the torque noise, ms.
    pub noise_time_ms: f64,
}

/// A screw with a nut.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScrewSpec {
    /// Travel per turn, mm.
    pub lead_mm: f64,
    /// Stiffness `K_s`, N/m.
    pub stiffness_n_m: f64,
    /// Damping `C_s`, N·s/m.
    pub damping_n_s_m: f64,
    /// Half the width of the dead zone, µm.
    pub backlash_half_width_um: f64,
    /// Whether motor and table form one mass: a linear motor (a lead of 2000π mm, 1 m per radian),
    /// or a screw far stiffer than the loops. Stiffness, damping and backlash then have no effect.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub rigid: bool,
}

/// A table with a scale.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TableSpec {
    /// Moved mass, kg.
    pub mass_kg: f64,
    /// Viscous friction `B_t`, N·s/m.
    pub viscous_n_s_m: f64,
    /// Standard deviation of the force noise, N.
    pub force_noise_n: f64,
    /// Correlation time of the force noise, ms.
    pub noise_time_ms: f64,
    /// Resolution of the table's scale, µm.
    pub scale_resolution_um: f64,
}

/// Ratios of the rates of a drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Rates {
    /// Position loop periods per sampling period of the reference.
    pub position_per_sample: usize,
    /// Velocity loop periods per position loop period.
    pub velocity_per_position: usize,
    /// Integration steps per velocity loop period.
    pub steps_per_velocity: usize,
}

impl DriveSpec {
    /// Refuses values out of range. `at` is the path of the drive in the file, `names` its key
    /// names.
    pub(super) fn check(&self, at: &str, names: Names, sampling_period_ms: f64) -> Result<(), MachineError> {
        let key = |name: &str| format!("{at}.{}", names.of(name));
        let (loops, motor, screw, table) = (&self.loops, &self.motor, &self.screw, &self.table);
        for (name, value) in [
            ("loops.position_gain_1_s", loops.position_gain_1_s),
            ("loops.velocity_gain_n_m_s_rad", loops.velocity_gain_n_m_s_rad),
            ("loops.integral_time_ms", loops.integral_time_ms),
            ("loops.current_lag_ms", loops.current_lag_ms),
            ("loops.position_period_ms", loops.position_period_ms),
            ("loops.velocity_period_ms", loops.velocity_period_ms),
            ("loops.integration_step_us", loops.integration_step_us),
            ("motor.inertia_kg_m2", motor.inertia_kg_m2),
            ("motor.torque_limit_n_m", motor.torque_limit_n_m),
            ("motor.counts_per_turn", motor.counts_per_turn),
            ("motor.noise_time_ms", motor.noise_time_ms),
            ("screw.lead_mm", screw.lead_mm),
            ("screw.stiffness_n_m", screw.stiffness_n_m),
            ("table.mass_kg", table.mass_kg),
            ("table.noise_time_ms", table.noise_time_ms),
            ("table.scale_resolution_um", table.scale_resolution_um),
        ] {
            positive(&key(name), value)?;
        }
        for (name, value) in [
            ("loops.feed_forward", loops.feed_forward),
            ("loops.position_derivative", loops.position_derivative),
            ("loops.acceleration_feed_forward", loops.acceleration_feed_forward),
            ("loops.command_average_ms", loops.command_average_ms),
            ("loops.command_lag_ms", loops.command_lag_ms),
            ("motor.viscous_n_m_s_rad", motor.viscous_n_m_s_rad),
            ("motor.torque_noise_n_m", motor.torque_noise_n_m),
            ("screw.damping_n_s_m", screw.damping_n_s_m),
            ("screw.backlash_half_width_um", screw.backlash_half_width_um),
            ("table.viscous_n_s_m", table.viscous_n_s_m),
            ("table.force_noise_n", table.force_noise_n),
        ] {
            not_negative(&key(name), value)?;
        }
        if let Some(time) = loops.position_integral_ms {
            positive(&key("loops.position_integral_ms"), time)?;
        }
        for (i, wave) in motor.ripple.iter().enumerate() {
            wave.check(&key(&format!("motor.ripple[{i}]")))?;
        }
        for (i, wave) in motor.cogging.iter().enumerate() {
            let at = key(&format!("motor.cogging[{i}]"));
            finite(&format!("{at}.amplitude_n_m"), wave.amplitude_n_m)?;
            Harmonic { amplitude: 0.0, per_turn: wave.per_turn, phase_rad: wave.phase_rad }.check(&at)?;
        }
        self.friction.check(&|name| key(&format!("friction.{name}")))?;
        self.rates(at, sampling_period_ms)?;
        self.check_step(&key("loops.integration_step_us"))
    }

    /// Ratios of the rates. Refused unless whole numbers.
    pub(crate) fn rates(&self, at: &str, sampling_period_ms: f64) -> Result<Rates, MachineError> {
        let position = format!("{at}.loops.position_period_ms");
        let velocity = format!("{at}.loops.velocity_period_ms");
        let step = format!("{at}.loops.integration_step_us");
        let loops = &self.loops;
        Ok(Rates {
            position_per_sample: multiple("sampling_period_ms", sampling_period_ms, &position, loops.position_period_ms)?,
            velocity_per_position: multiple(&position, loops.position_period_ms, &velocity, loops.velocity_period_ms)?,
            steps_per_velocity: multiple(&velocity, loops.velocity_period_ms, &step, loops.integration_step_us * 1e-3)?,
        })
    }

    /// Largest integration step for these stiffnesses, damping and masses, s. The semi-implicit
    /// integration is stable for `ω dt < 2`. A far smaller step keeps it accurate.
    pub(crate) fn largest_step_s(&self) -> f64 {
        let radius = self.screw.lead_mm * 1e-3 / std::f64::consts::TAU;
        let motor = self.motor.inertia_kg_m2 / (radius * radius);
        let presliding = self.friction.presliding_stiffness_n_m();
        let (mass, stiffness, damping) = if self.screw.rigid {
            // The friction of both sides acts on the single mass.
            (motor + self.table.mass_kg, 2.0 * presliding, self.table.viscous_n_s_m)
        } else {
            let damping = self.screw.damping_n_s_m + self.table.viscous_n_s_m;
            (motor.min(self.table.mass_kg), self.screw.stiffness_n_m + presliding, damping)
        };
        (0.3 * (mass / stiffness).sqrt()).min(0.3 * mass / damping.max(1e-9))
    }

    fn check_step(&self, key: &str) -> Result<(), MachineError> {
        let step_s = self.loops.integration_step_us * 1e-6;
        let largest = self.largest_step_s();
        within(
            key,
            self.loops.integration_step_us,
            (0.5e-6..=largest).contains(&step_s),
            &format!("at least 0.5 µs and at most {:.3} µs for these stiffnesses, damping and masses or inertias", largest * 1e6),
        )
    }
}
