//! Extents of columns.

/// Extent of a column, mm or rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// Least position.
    pub low: f64,
    /// Largest position.
    pub high: f64,
    /// Largest distance between a sample and the second one after it.
    pub two_steps: f64,
    /// Largest second difference of neighbouring samples.
    pub bend: f64,
    last: [f64; 2],
    seen: usize,
}

impl Default for Extent {
    fn default() -> Self {
        Self { low: f64::INFINITY, high: f64::NEG_INFINITY, two_steps: 0.0, bend: 0.0, last: [0.0; 2], seen: 0 }
    }
}

impl Extent {
    /// The extent of a column that is held.
    #[must_use]
    pub fn of(column: &[f64]) -> Self {
        let mut extent = Self::default();
        column.iter().for_each(|at| extent.note(*at));
        extent
    }

    pub(super) fn note(&mut self, at: f64) {
        (self.low, self.high) = (self.low.min(at), self.high.max(at));
        if self.seen >= 2 {
            let [before, last] = self.last;
            self.two_steps = self.two_steps.max((at - before).abs());
            self.bend = self.bend.max((at - 2.0 * last + before).abs());
        }
        self.last = [self.last[1], at];
        self.seen += 1;
    }
}
