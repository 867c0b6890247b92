//! The table of a feed drive behind its screw.

use crate::parameters::Servo;

/// The table behind backlash and elastic screw.
pub struct Table {
    /// Position, mm.
    pub position: f64,
    /// Velocity, mm/s.
    pub velocity: f64,
}

impl Table {
    /// Acceleration of the table by the screw: none inside the backlash.
    pub fn pulled(&self, servo: &Servo, motor: f64, speed: f64) -> f64 {
        let twist = motor - self.position;
        let beyond = twist.abs() - 0.5 * (servo.backlash_mm + servo.outer_backlash_mm);
        if beyond < 0.0 {
            return 0.0;
        }
        let pulsation = servo.table_pulsation_1_s;
        pulsation * (pulsation * beyond.copysign(twist) + 2.0 * servo.table_damping * (speed - self.velocity))
    }
}
