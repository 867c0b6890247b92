//! Response of an axis in motion to a force.

use nalgebra::Complex;

use crate::axis::{Axis, Start};
use crate::lanes::Lanes;
use crate::parameters::Servo;
use crate::simulate::STEP_S;

/// Deviation of the logged position by a force, mm, at the samples of `deflection_mm`. The force is stated as the deflection that it
/// makes of the loops without integrator, positive in positive direction. `on_table` of it acts on the table, the rest on the motor.
/// Friction and backlash are left out: the axis answers as in motion.
#[must_use]
pub fn disturbed(servo: &Servo, deflection_mm: &[f64], on_table: f64, period_s: f64) -> Vec<f64> {
    let steps = (period_s / STEP_S).ceil().max(1.0) as usize;
    let servos = [servo.linear()];
    let mut axis = Axis::at(&servos, period_s / steps as f64, steps, Lanes([0.0]), [Start::from((0.0, 0.0))]);
    let mut out = Vec::with_capacity(deflection_mm.len());
    for (k, &here) in deflection_mm.iter().enumerate() {
        out.push(axis.logged().0[0]);
        let ahead = deflection_mm.get(k + 1).copied().unwrap_or(here);
        for i in 0..steps {
            let deflection = here + (ahead - here) * i as f64 / steps as f64;
            axis.push(Lanes([deflection * servo.stiffness_1_s2()]), on_table);
            axis.step(Lanes([0.0]), Lanes([0.0]));
        }
    }
    out
}

impl Servo {
    /// The response of [`disturbed`] to a sine of a force on the motor, at a pulsation in 1/s.
    #[must_use]
    pub fn disturbance_response(&self, pulsation: f64) -> Complex<f64> {
        // At 0 the integrators leave nothing.
        let s = Complex::new(0.0, if pulsation == 0.0 { 1e-6 } else { pulsation });
        let bandwidth = self.bandwidth_1_s;
        let velocity_loop = s.inv() * (self.integral * bandwidth * bandwidth) + bandwidth;
        let late = Complex::from_polar(self.position_gain_1_s, -s.im * self.loop_delay_s);
        let position_loop = late * (s.inv() * self.position_integral_1_s + 1.0);
        // Position of the table over that of the motor.
        let table = if self.table_pulsation_1_s > 0.0 {
            let spring = s * (2.0 * self.table_damping * self.table_pulsation_1_s) + self.table_pulsation_1_s.powi(2);
            spring / (s * s + spring)
        } else {
            Complex::new(1.0, 0.0)
        };
        let share = if self.table_pulsation_1_s > 0.0 { self.table_mass } else { 0.0 };
        let inertia = (table * share + (1.0 - share)) * s * s;
        let sensor = if self.outer_backlash_mm > 0.0 { Complex::new(1.0, 0.0) } else { table };
        let viscous = s * (self.viscous * bandwidth);
        let motor = (inertia + viscous + velocity_loop * s + velocity_loop * position_loop * sensor).inv();
        motor * table * (bandwidth * self.position_gain_1_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_force_deflects_a_stiff_loop_and_is_removed_by_an_integrator() {
        let stiff = Servo { integral: 0.0, ..Servo::usual(60.0, 0.0) };
        let force = vec![5e-3; 1000];
        assert!((disturbed(&stiff, &force, 0.0, 0.002)[999] - 5e-3).abs() < 1e-6);
        let cascade = disturbed(&Servo::usual(60.0, 0.0), &force, 0.0, 0.002);
        assert!(cascade[999].abs() < 1e-5 && cascade.iter().any(|x| *x > 1e-3));
    }

    #[test]
    fn a_wave_of_a_force_answers_with_its_response() {
        let one_mass = Servo::usual(60.0, 0.5);
        let two_masses = Servo { table_pulsation_1_s: 400.0, table_mass: 0.4, table_damping: 0.05, ..one_mass };
        let motor_sensor = Servo { outer_backlash_mm: 1e-3, ..two_masses };
        for servo in [one_mass, two_masses, motor_sensor, Servo { integral: 0.0, position_integral_1_s: 5.0, ..one_mass }] {
            for pulsation in [30.0, 150.0, 350.0] {
                let period_s = 5e-4;
                let phase = |k: usize| pulsation * period_s * k as f64;
                let force: Vec<f64> = (0..20_000).map(|k| 1e-3 * phase(k).cos()).collect();
                let moved = disturbed(&servo, &force, 0.0, period_s);
                let of = |part: fn(f64) -> f64| {
                    let cycles = (10_000..20_000).map(|k| moved[k] * part(phase(k)));
                    2.0 * cycles.sum::<f64>() / 10_000.0 / 1e-3
                };
                let (expected, found) = (servo.disturbance_response(pulsation), Complex::new(of(f64::cos), -of(f64::sin)));
                assert!((found - expected).norm() < 0.12 * expected.norm(), "{pulsation}: {found} {expected} {servo:?}");
            }
        }
    }
}
