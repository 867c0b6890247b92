//! Quantiles of samples.

/// The `share` quantile, by rank; zero of nothing.
pub(crate) fn quantile(mut values: Vec<f64>, share: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let rank = ((values.len() - 1) as f64 * share).ceil() as usize;
    *values.select_nth_unstable_by(rank, f64::total_cmp).1
}
