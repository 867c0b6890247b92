//! The servo model that the passes of a staged predictor may start from.

use serde::{Deserialize, Serialize};
use servo::Servo;

use crate::AxisSignal;

/// A servo model in the axis's unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ServoBase {
    /// The model, in mm.
    pub servo: Servo,
    /// Millimetres per unit of the axis: 1, or the lever arm of a rotary axis.
    pub mm_per_unit: f64,
}

/// Largest lever arm of a rotary axis, mm.
const LARGEST_MM_PER_UNIT: f64 = 1e4;

impl ServoBase {
    /// Expected position, in the axis's unit. Without machine coordinates friction is the same everywhere.
    #[must_use]
    pub fn follow(&self, signal: &AxisSignal<'_>) -> Vec<f64> {
        let servo = if signal.placed { self.servo } else { self.servo.without_places() };
        if self.mm_per_unit == 1.0 {
            return servo.follow(signal.reference, signal.period_s);
        }
        let reference: Vec<f64> = signal.reference.iter().map(|x| x * self.mm_per_unit).collect();
        let mut position = servo.follow(&reference, signal.period_s);
        position.iter_mut().for_each(|x| *x /= self.mm_per_unit);
        position
    }

    /// The axis without friction and backlash.
    #[must_use]
    pub fn linear(&self) -> Self {
        Self { servo: self.servo.linear(), ..*self }
    }

    /// Checks that all numbers are valid.
    pub(super) fn check(&self) -> Result<(), String> {
        crate::ranges::within("mm_per_unit", self.mm_per_unit, [1e-3, LARGEST_MM_PER_UNIT])?;
        self.servo.check()
    }
}
