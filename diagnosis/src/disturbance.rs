//! How disturbances of the drive show in the logged position, and regressions of the residual on them.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::context::AxisContext;
use crate::servo::{clustered, disturbed};

/// Ridge of a regression against the mean diagonal: keeps regressors without data at zero.
const RIDGE: f64 = 1e-6;

/// Responses of an axis to signals of every run, as the logged position shows them: a signal of 1 is a force that would deflect the loops
/// without integrator by 1 mm.
pub fn responses(axis: &AxisContext<'_>, signal: impl Fn(usize, usize) -> f64 + Sync) -> Vec<Vec<f64>> {
    let servo = axis.fit.servo;
    let run = |(index, run): (usize, &crate::record::Run)| {
        let signal: Vec<f64> = (0..run.len()).map(|k| signal(index, k)).collect();
        disturbed(&servo, &signal, axis.record.period_s)
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
        let ridge = RIDGE * normal.trace() / count.max(1) as f64;
        for i in 0..count {
            normal[(i, i)] += ridge;
        }
        let right = DVector::from_iterator(count, columns.iter().map(|column| dot(column, &target)));
        let weights = normal.clone().cholesky()?.solve(&right);
        let mut left = residuals.to_vec();
        for (run, values) in left.iter_mut().enumerate() {
            for (k, value) in values.iter_mut().enumerate() {
                *value -= (0..count).map(|i| weights[i] * regressors[i][run].get(k).copied().unwrap_or(0.0)).sum::<f64>();
            }
        }
        let covariance = clustered(&normal, &columns, &left, first, period_s)?;
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
