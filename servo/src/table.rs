//! The tables of feed drives behind their screws.

use crate::lanes::Lanes;
use crate::parameters::Servo;

/// Tables behind backlash and elastic screw.
pub struct Table<const L: usize> {
    /// Position, mm.
    pub position: Lanes<L>,
    /// Velocity, mm/s.
    pub velocity: Lanes<L>,
    /// Half the width of the backlash, mm.
    half_mm: Lanes<L>,
    /// `Ω²`, 1/s².
    spring_1_s2: Lanes<L>,
    /// `2ζΩ`, 1/s.
    damper_1_s: Lanes<L>,
}

impl<const L: usize> Table<L> {
    /// The tables of axes in this state. One that the loop does not see lies on the flank that drove it there.
    pub fn at(servos: &[Servo; L], position: Lanes<L>, velocity: Lanes<L>) -> Self {
        let behind = |lane: usize| {
            let (servo, velocity): (&Servo, f64) = (&servos[lane], velocity.0[lane]);
            let side = if velocity == 0.0 { servo.start_deflection } else { velocity };
            if servo.hides_table && side != 0.0 { (0.5 * servo.backlash_mm).copysign(side) } else { 0.0 }
        };
        Self {
            position: position - Lanes::of(behind),
            velocity,
            half_mm: Lanes::each(servos, |servo| 0.5 * (servo.backlash_mm + servo.outer_backlash_mm)),
            spring_1_s2: Lanes::each(servos, |servo| servo.table_pulsation_1_s.powi(2)),
            damper_1_s: Lanes::each(servos, |servo| 2.0 * servo.table_damping * servo.table_pulsation_1_s),
        }
    }

    /// Acceleration of the tables by the screws: none inside the backlash.
    #[inline(always)]
    pub fn pulled(&self, motor: Lanes<L>, speed: Lanes<L>) -> Lanes<L> {
        let twist = motor - self.position;
        let beyond = twist.abs() - self.half_mm;
        let pulled = self.spring_1_s2 * beyond.copysign(twist) + self.damper_1_s * (speed - self.velocity);
        beyond.where_below(0.0, Lanes::all(0.0), pulled)
    }
}
