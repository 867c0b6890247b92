//! Error figures of what is not held: sums, and a histogram for the 95th percentile.

use motion::contour::ContourSummary;

/// Ratio of neighbouring bounds of the histogram.
const RATIO: f64 = 1.005;
/// Least error of the histogram, mm, and its number of bins: up to 40 m.
const LEAST_MM: f64 = 1e-9;
const BINS: usize = 4900;

/// Errors of samples.
#[derive(Debug, Clone)]
pub(crate) struct Tally {
    count: u64,
    sum: f64,
    square: f64,
    max_mm: f64,
    max_at: usize,
    bins: Vec<u32>,
}

impl Default for Tally {
    fn default() -> Self {
        Self { count: 0, sum: 0.0, square: 0.0, max_mm: 0.0, max_at: 0, bins: vec![0; BINS] }
    }
}

impl Tally {
    /// Adds the error of the sample with this index, mm.
    pub(crate) fn note(&mut self, sample: usize, error_mm: f64) {
        self.count += 1;
        self.sum += error_mm;
        self.square += error_mm * error_mm;
        if error_mm > self.max_mm {
            (self.max_mm, self.max_at) = (error_mm, sample);
        }
        let bin = ((error_mm / LEAST_MM).max(1.0).ln() / RATIO.ln()) as usize;
        self.bins[bin.min(BINS - 1)] += 1;
    }

    /// Adds other samples, whose indices begin at `first`.
    pub(crate) fn add(&mut self, other: &Self, first: usize) {
        if other.max_mm > self.max_mm {
            (self.max_mm, self.max_at) = (other.max_mm, first + other.max_at);
        }
        self.count += other.count;
        self.sum += other.sum;
        self.square += other.square;
        self.bins.iter_mut().zip(&other.bins).for_each(|(bin, more)| *bin += more);
    }

    /// The figures; the percentile to half a per cent. `None` without a sample.
    pub(crate) fn summary(&self) -> Option<ContourSummary> {
        let wanted = (0.95 * self.count as f64).ceil() as u64;
        let mut below = 0;
        let (bin, count) = self.bins.iter().enumerate().find(|(_, count)| {
            let is_in = below + u64::from(**count) >= wanted;
            below += if is_in { 0 } else { u64::from(**count) };
            is_in
        })?;
        // Within a bin samples are taken to lie evenly.
        let within = (wanted - below) as f64 / f64::from(*count).max(1.0);
        let p95_mm = (LEAST_MM * RATIO.powf(bin as f64 + within)).min(self.max_mm);
        let (rms_mm, mean_mm) = ((self.square / self.count as f64).sqrt(), self.sum / self.count as f64);
        (self.count > 0).then_some(ContourSummary { rms_mm, mean_mm, max_mm: self.max_mm, p95_mm, max_at: self.max_at })
    }
}

#[cfg(test)]
mod tests {
    use motion::contour::summary_of;

    use super::*;

    #[test]
    fn the_figures_are_those_of_all_samples() {
        let errors: Vec<f64> = (0..4000).map(|k| 1e-4 * (1.0 + (f64::from(k) * 0.7).sin()).powi(3)).collect();
        let mut all = Tally::default();
        for (window, errors) in errors.chunks(1500).enumerate() {
            let mut one = Tally::default();
            errors.iter().enumerate().for_each(|(k, error)| one.note(k, *error));
            all.add(&one, 1500 * window);
        }
        let (found, wanted) = (all.summary().unwrap(), summary_of(&errors, None).unwrap());
        assert!(
            (found.rms_mm / wanted.rms_mm - 1.0).abs() < 1e-12 && found.max_mm == wanted.max_mm && found.max_at == wanted.max_at
        );
        assert!((found.mean_mm / wanted.mean_mm - 1.0).abs() < 1e-12);
        assert!((found.p95_mm / wanted.p95_mm - 1.0).abs() < 0.006, "{} {}", found.p95_mm, wanted.p95_mm);
        assert!(Tally::default().summary().is_none());
    }
}
