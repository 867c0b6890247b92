//! Distribution of error magnitudes over logarithmic bins.

/// Decades below the largest magnitude that the bins cover.
const DECADES: f64 = 4.0;
/// Bins in a decade.
const BINS_PER_DECADE: f64 = 12.0;

/// Shares of the samples of several runs in common bins.
#[derive(Debug, Clone, PartialEq)]
pub struct Distribution {
    /// Upper edge of every bin, in the unit of the magnitudes, ascending. The first bin holds all that is smaller.
    pub upper: Vec<f64>,
    /// Share of the samples in every bin, one entry a run.
    pub shares: Vec<Vec<f64>>,
}

/// Distribution of the magnitudes of each run. Magnitudes that are not finite do not count. `None` where no run has a magnitude above zero.
#[must_use]
pub fn distribution(runs: &[&[f64]]) -> Option<Distribution> {
    let finite = |run: &&[f64]| run.iter().copied().filter(|value| value.is_finite()).collect::<Vec<f64>>();
    let runs: Vec<Vec<f64>> = runs.iter().map(finite).collect();
    let largest = runs.iter().flatten().copied().fold(0.0, f64::max);
    if largest <= 0.0 {
        return None;
    }
    let bins = (DECADES * BINS_PER_DECADE) as usize;
    let upper: Vec<f64> = (0..=bins).map(|bin| largest * 10_f64.powf((bin as f64 - bins as f64) / BINS_PER_DECADE)).collect();
    let of = |run: &Vec<f64>| {
        let mut counts = vec![0_usize; upper.len()];
        for value in run {
            counts[upper.partition_point(|edge| edge < value).min(bins)] += 1;
        }
        counts.into_iter().map(|count| count as f64 / run.len().max(1) as f64).collect()
    };
    Some(Distribution { shares: runs.iter().map(of).collect(), upper })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sample_falls_into_one_bin() {
        let first: Vec<f64> = (1..=1000).map(|k| f64::from(k) * 0.01).collect();
        let second = [0.0, 1e-9, 10.0, f64::NAN];
        let found = distribution(&[&first, &second]).unwrap();
        for shares in &found.shares {
            assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
        assert_eq!(found.upper.last().copied(), Some(10.0));
        // Two of three finite values lie below all bins, one in the last.
        assert!((found.shares[1][0] - 2.0 / 3.0).abs() < 1e-12 && (found.shares[1][48] - 1.0 / 3.0).abs() < 1e-12);
        assert!(distribution(&[&[0.0, f64::NAN]]).is_none());
    }
}
