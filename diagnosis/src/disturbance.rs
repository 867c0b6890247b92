//! How disturbances of the drive show in the logged position, and regressions of the residual on them.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use servo::{clustered, disturbed};

use crate::context::AxisContext;

/// Ridge of a regression against each regressor's own square: the scales of regressors differ by many orders.
const RIDGE: f64 = 1e-6;

/// Responses of an axis to signals of every run, as the logged position shows them: a signal of 1 is a force that would deflect the loops
/// without integrator by 1 mm, `on_table` of it on the table.
pub fn responses(axis: &AxisContext<'_>, on_table: f64, signal: impl Fn(usize, usize) -> f64 + Sync) -> Vec<Vec<f64>> {
    let servo = axis.fit.servo;
    let run = |(index, run): (usize, &crate::record::Run)| {
        let signal: Vec<f64> = (0..run.len()).map(|k| signal(index, k)).collect();
        disturbed(&servo, &signal, on_table, axis.record.period_s)
    };
    axis.record.runs.par_iter().enumerate().map(run).collect()
}

/// A regression of the residuals.
pub struct Regression {
    /// Weights.
    pub weights: DVector<f64>,
    /// Their covariance, from blocks of a second.
    pub covariance: DMatrix<f64>,
}

impl Regression {
    /// Least squares of the residuals on `regressors` (by regressor, run, sample) over the scored samples. `None` where they are dependent.
    pub fn of(residuals: &[Vec<f64>], regressors: &[Vec<Vec<f64>>], first: usize, period_s: f64) -> Option<Self> {
        let flat = |runs: &[Vec<f64>]| -> Vec<f64> { runs.iter().flat_map(|run| run.iter().skip(first).copied()).collect() };
        let columns: Vec<Vec<f64>> = regressors.par_iter().map(|regressor| flat(regressor)).collect();
        let target = flat(residuals);
        let count = columns.len();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut normal = DMatrix::zeros(count, count);
        for i in 0..count {
            for j in 0..=i {
                let value = dot(&columns[i], &columns[j]);
                (normal[(i, j)], normal[(j, i)]) = (value, value);
            }
        }
        for i in 0..count {
            // A regressor without data stays at zero.
            normal[(i, i)] += RIDGE * normal[(i, i)] + f64::MIN_POSITIVE;
        }
        let right = DVector::from_iterator(count, columns.iter().map(|column| dot(column, &target)));
        let weights = normal.clone().cholesky()?.solve(&right);
        let mut left = residuals.to_vec();
        for (run, values) in left.iter_mut().enumerate() {
            for (k, value) in values.iter_mut().enumerate() {
                *value -= (0..count).map(|i| weights[i] * regressors[i][run].get(k).copied().unwrap_or(0.0)).sum::<f64>();
            }
        }
        let pieces: Vec<&[f64]> = left.iter().map(|run| run.get(first..).unwrap_or_default()).collect();
        let covariance = clustered(&normal, &columns, &pieces, period_s)?;
        Some(Self { weights, covariance })
    }

    /// Wald statistic of the weights `from..to` being zero, per weight: about 1 where they are.
    pub fn wald(&self, from: usize, to: usize) -> f64 {
        let weights = self.weights.rows(from, to - from).into_owned();
        let covariance = self.covariance.view((from, from), (to - from, to - from)).into_owned();
        match covariance.cholesky() {
            Some(root) => weights.dot(&root.solve(&weights)) / (to - from) as f64,
            None => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regressors_of_very_different_scale_keep_their_weights() {
        let wave =
            |step: f64, size: f64| -> Vec<Vec<f64>> { vec![(0..4000).map(|k| size * (step * f64::from(k)).sin()).collect()] };
        let (large, small) = (wave(0.013, 50.0), wave(0.05, 1e-4));
        let residuals = vec![large[0].iter().zip(&small[0]).map(|(a, b)| 2e-6 * a - 0.3 * b).collect::<Vec<f64>>()];
        let found = Regression::of(&residuals, &[large, small], 0, 0.002).unwrap();
        assert!((found.weights[0] - 2e-6).abs() < 1e-9 && (found.weights[1] + 0.3).abs() < 1e-4, "{}", found.weights);
    }
}
