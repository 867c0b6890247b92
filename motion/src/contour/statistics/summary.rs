//! RMS, maximum and 95 % quantile of the contour errors of a path.

use crate::Vec3;
use crate::contour::ContourError;

/// Statistics of a path, mm (Paper D, eq. 29, 31).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContourSummary {
    /// Root mean square.
    pub rms_mm: f64,
    /// Arithmetic mean.
    pub mean_mm: f64,
    /// Maximum.
    pub max_mm: f64,
    /// 95 % quantile, over samples or over length.
    pub p95_mm: f64,
    /// Index of the sample with the maximum.
    pub max_at: usize,
}

/// Statistics over samples. `None` if there is none.
#[must_use]
pub fn summary(errors: &[ContourError]) -> Option<ContourSummary> {
    let magnitudes: Vec<f64> = errors.iter().map(|error| error.magnitude_mm).collect();
    summary_of(&magnitudes, None)
}

/// Statistics over the length of the path `from` with these errors (Paper A). A sample has the
/// weight of half the distance to either neighbour, so standstill and slow corners have no more
/// weight than their length. Over samples if the path has no length. `None` if there is no sample
/// or the numbers differ.
#[must_use]
pub fn summary_by_length(errors: &[ContourError], from: &[Vec3]) -> Option<ContourSummary> {
    if errors.len() != from.len() {
        return None;
    }
    let mut weights = vec![0.0; from.len()];
    for (k, pair) in from.windows(2).enumerate() {
        let half = 0.5 * (pair[1] - pair[0]).norm();
        weights[k] += half;
        weights[k + 1] += half;
    }
    let magnitudes: Vec<f64> = errors.iter().map(|error| error.magnitude_mm).collect();
    summary_of(&magnitudes, Some(&weights))
}

/// Statistics of magnitudes (mm), weighted (any unit, non-negative) or unweighted. Without a
/// positive weight all count equally. `None` if there is no magnitude or the numbers differ.
#[must_use]
pub fn summary_of(magnitudes_mm: &[f64], weights: Option<&[f64]>) -> Option<ContourSummary> {
    if weights.is_some_and(|weights| weights.len() != magnitudes_mm.len()) {
        return None;
    }
    let weights = weights.filter(|weights| weights.iter().any(|weight| *weight > 0.0));
    let weight = |k: usize| weights.map_or(1.0, |weights| weights[k]);
    let (max_at, max) =
        magnitudes_mm.iter().enumerate().max_by(|one, other| one.1.total_cmp(other.1).then(other.0.cmp(&one.0)))?;
    let total: f64 = (0..magnitudes_mm.len()).map(weight).sum();
    let squares: f64 = magnitudes_mm.iter().enumerate().map(|(k, m)| weight(k) * m * m).sum();
    let sum: f64 = magnitudes_mm.iter().enumerate().map(|(k, m)| weight(k) * m).sum();
    let within = 0.95 * total * (1.0 - 1e-12);
    let p95_mm = match weights {
        Some(weights) => weighted_quantile(magnitudes_mm, weights, within).unwrap_or(*max),
        None => *magnitudes_mm.to_vec().select_nth_unstable_by((within.ceil() as usize).max(1) - 1, f64::total_cmp).1,
    };
    Some(ContourSummary { rms_mm: (squares / total).sqrt(), mean_mm: sum / total, max_mm: *max, p95_mm, max_at })
}

/// The least magnitude up to which the weights sum to `within`.
fn weighted_quantile(magnitudes_mm: &[f64], weights: &[f64], within: f64) -> Option<f64> {
    let mut order: Vec<usize> = (0..magnitudes_mm.len()).collect();
    order.sort_unstable_by(|one, other| magnitudes_mm[*one].total_cmp(&magnitudes_mm[*other]));
    let mut below = 0.0;
    let at = order.into_iter().find(|k| {
        below += weights[*k];
        below >= within
    });
    at.map(|k| magnitudes_mm[k])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_over_samples_and_over_length() {
        let magnitudes: Vec<f64> = (1..=100).map(f64::from).collect();
        let plain = summary_of(&magnitudes, None).unwrap();
        assert_eq!((plain.max_mm, plain.max_at, plain.p95_mm, plain.mean_mm), (100.0, 99, 95.0, 50.5));
        assert!((plain.rms_mm - (338_350.0_f64 / 100.0).sqrt()).abs() < 1e-12);
        assert!(summary_of(&[], None).is_none());
        assert!(summary_of(&[1.0], Some(&[])).is_none());

        // Standstill at a large error has no weight over length.
        let error = |magnitude_mm| ContourError { magnitude_mm, ..ContourError::default() };
        let errors = [error(1.0), error(9.0), error(9.0), error(9.0), error(1.0)];
        let at = |x| Vec3::new(x, 0.0, 0.0);
        let path = [at(0.0), at(1.0), at(1.0), at(1.0), at(2.0)];
        let by_length = summary_by_length(&errors, &path).unwrap();
        assert!((by_length.rms_mm - 41.0_f64.sqrt()).abs() < 1e-12 && (by_length.mean_mm - 5.0).abs() < 1e-12);
        assert!(summary(&errors).unwrap().rms_mm > by_length.rms_mm);
    }
}
