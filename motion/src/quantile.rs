//! Quantiles of samples.

/// Quantile by nearest rank at the fraction `share`, in `[0, 1]`. `None` for empty input. Reorders
/// the samples.
#[must_use]
pub fn quantile(values: &mut [f64], share: f64) -> Option<f64> {
    let last = values.len().checked_sub(1)?;
    let rank = (last as f64 * share).round() as usize;
    Some(*values.select_nth_unstable_by(rank, f64::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_are_the_nearest() {
        let mut values = [5.0, 1.0, 4.0, 2.0, 3.0];
        assert_eq!([0.0, 0.12, 0.13, 0.5, 1.0].map(|share| quantile(&mut values, share)), [1.0, 1.0, 2.0, 3.0, 5.0].map(Some));
        assert_eq!(quantile(&mut [], 0.5), None);
    }
}
