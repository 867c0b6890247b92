//! Root mean square and largest magnitude, as samples come.

/// Root mean square and largest magnitude of samples, as [`rms_max`](crate::statistics::rms_max) finds them of all.
#[derive(Debug, Default, Clone)]
pub(crate) struct RmsMax {
    count: usize,
    square: f64,
    max: f64,
}

impl RmsMax {
    pub fn note(&mut self, value: f64) {
        self.count += 1;
        self.square += value * value;
        self.max = self.max.max(value.abs());
    }

    pub fn figures(&self) -> (f64, f64) {
        ((self.square / self.count.max(1) as f64).sqrt(), self.max)
    }
}
