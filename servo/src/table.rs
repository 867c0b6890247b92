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
    /// The table of an axis in this state. One that the loop does not see lies on the flank that drove it there.
    pub fn at(servo: &Servo, position: f64, velocity: f64) -> Self {
        let side = if velocity == 0.0 { servo.start_deflection } else { velocity };
        let behind = if servo.hides_table && side != 0.0 { (0.5 * servo.backlash_mm).copysign(side) } else { 0.0 };
        Self { position: position - behind, velocity }
    }

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
