//! Quantiles of samples.

/// The `share` quantile; zero for no samples. It is the smallest sample whose rank is not below
/// that share, so that a bound is never too narrow. `motion::quantile` takes the nearest rank.
pub(crate) fn quantile(mut values: Vec<f64>, share: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let rank = ((values.len() - 1) as f64 * share).ceil() as usize;
    *values.select_nth_unstable_by(rank, f64::total_cmp).1
}
