//! Direction of motion of an axis.

/// Speed below which an axis counts as at standstill, mm/s or rad/s.
const STILL: f64 = 0.05;

/// Direction of a commanded position, as its samples come.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Heading {
    last: Option<f64>,
    /// Sign of the last motion; 0 before the first one.
    pub sign: f64,
}

impl Heading {
    /// Whether the position (mm or rad) rose before, where it reverses with this sample. Standstills in between do not matter.
    pub fn turns(&mut self, position: f64, period_s: f64) -> Option<bool> {
        let speed = self.last.map_or(0.0, |last| (position - last) / period_s);
        self.last = Some(position);
        if speed.abs() < STILL {
            return None;
        }
        let before = std::mem::replace(&mut self.sign, speed.signum());
        (before * speed < 0.0).then_some(before > 0.0)
    }
}
