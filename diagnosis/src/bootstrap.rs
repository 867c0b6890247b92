//! Intervals by resampling.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use crate::finding::Estimate;

/// Resamples of an interval.
const RESAMPLES: usize = 200;
/// Seed of the resamples: the same logs give the same figures.
const SEED: u64 = 20_041;

/// A statistic of `items` with its 95 % percentile interval (Efron 1979). `items` are what may be exchanged: events, or stretches of a
/// log long enough to be independent. `None` for fewer than three items.
pub fn interval<T>(items: &[T], statistic: impl Fn(&[&T]) -> f64) -> Option<Estimate> {
    if items.len() < 3 {
        return None;
    }
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let all: Vec<&T> = items.iter().collect();
    let value = statistic(&all);
    let mut draws: Vec<f64> = (0..RESAMPLES)
        .map(|_| {
            let drawn: Vec<&T> = (0..items.len()).map(|_| &items[rng.random_range(0..items.len())]).collect();
            statistic(&drawn)
        })
        .filter(|draw| draw.is_finite())
        .collect();
    if draws.len() < RESAMPLES / 2 {
        return None;
    }
    draws.sort_by(f64::total_cmp);
    let at = |share: f64| draws[((draws.len() - 1) as f64 * share).round() as usize];
    Some(Estimate { value, low: at(0.025).min(value), high: at(0.975).max(value) })
}

/// Median of values; 0 of none.
pub fn median(mut values: Vec<f64>) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_of_a_known_spread_has_its_interval() {
        let items: Vec<f64> = (0..100).map(|k| f64::from((k * 37) % 100)).collect();
        let mean = |items: &[&f64]| items.iter().copied().sum::<f64>() / items.len() as f64;
        let found = interval(&items, mean).unwrap();
        // σ of the mean: 28.87 / 10.
        assert!((found.value - 49.5).abs() < 1e-9);
        assert!((found.high - found.low - 2.0 * 1.96 * 2.887).abs() < 2.0, "{found:?}");
        assert!(interval(&items[..2], mean).is_none());
    }
}
