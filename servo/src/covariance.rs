//! Covariance of fitted parameters from residuals that are correlated in time.

use nalgebra::{DMatrix, DVector};

/// Length of a block, s: friction levels drift over seconds, loops settle in a tenth of one.
const BLOCK_S: f64 = 1.0;

/// `H⁻¹ (Σ s_b s_bᵀ) H⁻¹` with the score `s_b = Σ J_k r_k` of every block of a second: residuals may be correlated within a block and
/// differ in size between blocks (cluster-robust, Liang and Zeger 1986). `pieces` are the residuals of connected samples, in the order of the
/// columns' rows. `None` where `normal` is singular.
#[must_use]
pub fn clustered(normal: &DMatrix<f64>, columns: &[Vec<f64>], pieces: &[&[f64]], period_s: f64) -> Option<DMatrix<f64>> {
    let count = columns.len();
    let block = ((BLOCK_S / period_s).round() as usize).max(1);
    let mut meat = DMatrix::zeros(count, count);
    let (mut blocks, mut at) = (0_usize, 0);
    for piece in pieces {
        for part in piece.chunks(block) {
            let score = DVector::from_iterator(
                count,
                columns.iter().map(|column| part.iter().zip(&column[at..at + part.len()]).map(|(r, j)| r * j).sum::<f64>()),
            );
            meat += &score * score.transpose();
            blocks += 1;
            at += part.len();
        }
    }
    let bread = inverse(normal)?;
    // Few blocks understate the spread.
    let few = blocks as f64 / blocks.saturating_sub(count).max(1) as f64;
    Some(&bread * meat * &bread * few)
}

/// Inverse of a positive definite matrix, of widely different scales.
pub fn inverse(matrix: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let count = matrix.nrows();
    let scale: Vec<f64> = (0..count).map(|i| matrix[(i, i)].max(f64::MIN_POSITIVE).sqrt().recip()).collect();
    let mut scaled = DMatrix::from_fn(count, count, |i, j| matrix[(i, j)] * scale[i] * scale[j]);
    for i in 0..count {
        // A parameter without effect keeps a finite, large variance.
        scaled[(i, i)] += 1e-10;
    }
    let inverse = scaled.cholesky()?.inverse();
    Some(DMatrix::from_fn(count, count, |i, j| inverse[(i, j)] * scale[i] * scale[j]))
}
