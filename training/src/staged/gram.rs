//! Normal equations: collected in blocks of rows, separately for each fold, solved with a ridge.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::cholesky::solve_definite;

/// Columns of one product; only the lower triangle of tiles is computed.
const TILE: usize = 128;

/// Penalty of a weight in the fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Penalty {
    /// Ridge: share of the column's sum of squares, times the weight squared.
    pub ridge: f64,
    /// Variance of the noise over the prior variance of the weight, times the weight squared.
    pub prior: f64,
}

impl Penalty {
    /// A ridge only.
    pub fn ridge(ridge: f64) -> Self {
        Self { ridge, prior: 0.0 }
    }
}

/// Sums of products of columns; the last column is the target.
#[derive(Debug, Clone)]
pub struct Gram {
    products: DMatrix<f64>,
    samples: usize,
}

impl Gram {
    /// Zero sums for `columns` columns and a target.
    pub fn new(columns: usize) -> Self {
        Self { products: DMatrix::zeros(columns + 1, columns + 1), samples: 0 }
    }

    /// Adds a block of rows, the target in its last column. Only the lower triangle is updated; see
    /// [`Self::finish`].
    pub fn add(&mut self, block: &DMatrix<f64>) {
        let transposed = block.transpose();
        let size = self.products.nrows();
        for start in (0..size).step_by(TILE) {
            let width = TILE.min(size - start);
            let height = size - start;
            self.products.view_mut((start, start), (height, width)).gemm(
                1.0,
                &transposed.rows(start, height),
                &block.columns(start, width),
                1.0,
            );
        }
        self.samples += block.nrows();
    }

    /// Mirrors the lower triangle to the upper one.
    pub fn finish(&mut self) {
        self.products.fill_upper_triangle_with_lower_triangle();
    }

    /// Adds another sum of the same columns.
    pub fn merge(&mut self, other: &Self) {
        self.products += &other.products;
        self.samples += other.samples;
    }

    /// This sum without the rows of `part`.
    pub fn without(&self, part: &Self) -> Self {
        Self { products: &self.products - &part.products, samples: self.samples - part.samples }
    }

    /// Number of rows collected.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Number of columns without the target.
    pub fn columns(&self) -> usize {
        self.products.nrows() - 1
    }

    /// The same sum over fewer columns, in the order given.
    pub fn select(&self, columns: &[usize]) -> Self {
        let target = self.columns();
        let pick: Vec<usize> = columns.iter().copied().chain([target]).collect();
        Self { products: self.products.select_rows(&pick).select_columns(&pick), samples: self.samples }
    }

    /// Weights that minimise the squared error plus the penalties; a column of zeros gets none.
    ///
    /// `None` where the equations are singular to working precision.
    pub fn solve(&self, penalties: &[Penalty]) -> Option<Vec<f64>> {
        let count = self.columns();
        let weights = self.solve_first(penalties, count..count + 1)?;
        Some(weights.column(0).iter().copied().collect())
    }

    /// Weights of the first columns, one per penalty, that fit each of the columns `wanted` with
    /// these penalties; one column each.
    ///
    /// `None` where the equations are singular to working precision.
    fn solve_first(&self, penalties: &[Penalty], wanted: Range<usize>) -> Option<DMatrix<f64>> {
        let count = penalties.len();
        let scale: Vec<f64> = (0..count)
            .map(|i| {
                let square = self.products[(i, i)];
                if square > 0.0 { square.sqrt().recip() } else { 0.0 }
            })
            .collect();
        let mut normal = DMatrix::from_fn(count, count, |i, j| self.products[(i, j)] * scale[i] * scale[j]);
        for (i, penalty) in penalties.iter().enumerate() {
            normal[(i, i)] = 1.0 + penalty.ridge + penalty.prior * scale[i] * scale[i];
        }
        let right = DMatrix::from_fn(count, wanted.len(), |i, j| self.products[(i, wanted.start + j)] * scale[i]);
        let mut weights = solve_definite(normal, &right)?;
        for mut column in weights.column_iter_mut() {
            column.iter_mut().zip(&scale).for_each(|(weight, scale)| *weight *= scale);
        }
        weights.iter().all(|w| w.is_finite()).then_some(weights)
    }

    /// The normal equations of the columns after the first, once the first, one per penalty, are
    /// projected out.
    ///
    /// `None` where the equations are singular to working precision.
    pub fn reduced(&self, penalties: &[Penalty]) -> Option<Reduced> {
        let (first, last) = (penalties.len(), self.columns());
        let weights = self.solve_first(penalties, first..last + 1)?;
        let own = self.products.view((first, first), (last - first, last + 1 - first));
        let left = own - self.products.view((first, 0), (last - first, first)) * &weights;
        Some(Reduced { left, weights })
    }

    /// Sum of squared errors of `weights` on the collected rows.
    pub fn squared_error(&self, weights: &[f64]) -> f64 {
        let count = self.columns();
        let extended = DVector::from_fn(count + 1, |i, _| if i < count { -weights[i] } else { 1.0 });
        extended.dot(&(&self.products * &extended)).max(0.0)
    }
}

/// Normal equations of some columns after the other columns are projected out.
#[derive(Debug, Clone)]
pub struct Reduced {
    /// The equations, the right-hand side last.
    left: DMatrix<f64>,
    /// Weights of the other columns on each of the columns and on the target.
    weights: DMatrix<f64>,
}

impl Reduced {
    /// Weights of all columns, the others first. The prior of these columns is a normal
    /// distribution with zero mean and inverse covariance `precision`, in units of the noise.
    ///
    /// `None` where the equations are singular to working precision.
    pub fn solve(&self, precision: &DMatrix<f64>) -> Option<Vec<f64>> {
        let count = precision.nrows();
        let normal = self.left.columns(0, count) + precision;
        let own = solve_definite(normal, &self.left.columns(count, 1).into_owned())?;
        let others = self.weights.column(count) - self.weights.columns(0, count) * &own;
        let weights: Vec<f64> = others.iter().chain(own.iter()).copied().collect();
        weights.iter().all(|w| w.is_finite()).then_some(weights)
    }
}

/// Sums of the rows, divided in two ways: by fold, and by speed band.
#[derive(Debug, Clone)]
pub struct FoldGrams {
    folds: Vec<Gram>,
    bands: Vec<Gram>,
    total: Gram,
}

impl FoldGrams {
    /// Combines sums of each fold (outer) and speed band (inner).
    pub fn new(cells: &[Vec<Gram>], columns: usize) -> Self {
        let bands = cells.first().map_or(0, Vec::len);
        let sum = |parts: &mut dyn Iterator<Item = &Gram>| {
            let mut gram = Gram::new(columns);
            for part in parts {
                gram.merge(part);
            }
            gram
        };
        let folds: Vec<Gram> = cells.iter().map(|fold| sum(&mut fold.iter())).collect();
        Self {
            total: sum(&mut folds.iter()),
            bands: (0..bands).map(|band| sum(&mut cells.iter().filter_map(|fold| fold.get(band)))).collect(),
            folds,
        }
    }

    /// All rows.
    pub fn total(&self) -> &Gram {
        &self.total
    }

    /// The same over fewer columns.
    pub fn select(&self, columns: &[usize]) -> Self {
        let select = |grams: &[Gram]| grams.iter().map(|gram| gram.select(columns)).collect();
        Self { folds: select(&self.folds), bands: select(&self.bands), total: self.total.select(columns) }
    }

    /// Squared error on each fold of the weights fitted to all other folds; `None` if a fit is
    /// singular.
    pub fn cross_validate(&self, penalties: &[Penalty]) -> Option<FoldErrors> {
        self.leave_out(&self.folds, penalties)
    }

    /// Squared error on each fold for each of `precisions` of the columns after the first, one per
    /// penalty, as in [`Reduced::solve`]. `None` for one whose equations are singular, or if those
    /// of the first columns are.
    pub fn cross_validate_reduced(&self, penalties: &[Penalty], precisions: &[DMatrix<f64>]) -> Vec<Option<FoldErrors>> {
        let mut squares: Vec<Option<Vec<f64>>> = vec![Some(Vec::new()); precisions.len()];
        for part in &self.folds {
            let reduced = self.total.without(part).reduced(penalties);
            for (squares, precision) in squares.iter_mut().zip(precisions) {
                let weights = reduced.as_ref().and_then(|reduced| reduced.solve(precision));
                match weights {
                    Some(weights) => squares.iter_mut().for_each(|squares| squares.push(part.squared_error(&weights))),
                    None => *squares = None,
                }
            }
        }
        let samples: Vec<usize> = self.folds.iter().map(Gram::samples).collect();
        squares.into_iter().map(|squares| Some(FoldErrors { squares: squares?, samples: samples.clone() })).collect()
    }

    /// As [`Self::cross_validate`], with one speed band left out in turn: how the columns
    /// extrapolate to speeds outside the fit.
    pub fn carry_over(&self, penalties: &[Penalty]) -> Option<FoldErrors> {
        self.leave_out(&self.bands, penalties)
    }

    fn leave_out(&self, parts: &[Gram], penalties: &[Penalty]) -> Option<FoldErrors> {
        let squares = parts
            .iter()
            .map(|part| {
                let weights = self.total.without(part).solve(penalties)?;
                Some(part.squared_error(&weights))
            })
            .collect::<Option<_>>()?;
        Some(FoldErrors { squares, samples: parts.iter().map(Gram::samples).collect() })
    }
}

/// Held-out squared errors per fold.
#[derive(Debug, Clone, PartialEq)]
pub struct FoldErrors {
    /// Sum of squares of each fold.
    pub squares: Vec<f64>,
    /// Samples of each fold.
    pub samples: Vec<usize>,
}

impl FoldErrors {
    /// Mean square over all samples.
    pub fn mean_square(&self) -> f64 {
        self.squares.iter().sum::<f64>() / self.samples.iter().sum::<usize>().max(1) as f64
    }

    /// Root mean square over all samples.
    pub fn rms(&self) -> f64 {
        self.mean_square().sqrt()
    }

    /// Whether the mean square is below `other`'s by more than the share `least_gain`, and the
    /// folds agree: the mean gain exceeds zero by more than `standard_errors` standard errors, in
    /// squares or in logarithms.
    ///
    /// With squares alone one fold of fast runs would dominate; with logarithms alone a fold in
    /// which the axis hardly moves.
    pub fn beats(&self, other: &Self, least_gain: f64, standard_errors: f64) -> bool {
        let pairs = || self.squares.iter().zip(&other.squares);
        let squares: Vec<f64> = pairs().map(|(mine, theirs)| theirs - mine).collect();
        let logarithms: Vec<f64> =
            pairs().filter(|(mine, theirs)| **mine > 0.0 && **theirs > 0.0).map(|(mine, theirs)| (theirs / mine).ln()).collect();
        self.mean_square() < (1.0 - least_gain) * other.mean_square()
            && (above_zero(&squares, standard_errors) || above_zero(&logarithms, standard_errors))
    }
}

/// Whether the mean of `values` is above zero by more than `standard_errors` of its standard errors.
fn above_zero(values: &[f64], standard_errors: f64) -> bool {
    let count = values.len() as f64;
    if count < 2.0 {
        return false;
    }
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
    mean > standard_errors * (variance / count).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn errors(squares: &[f64]) -> FoldErrors {
        FoldErrors { squares: squares.to_vec(), samples: vec![100; squares.len()] }
    }

    #[test]
    fn a_gain_has_to_show_in_most_folds() {
        let simple = errors(&[1.0, 100.0, 2.0, 3.0]);
        assert!(errors(&[0.8, 79.0, 1.5, 2.4]).beats(&simple, 0.02, 2.0));
        assert!(errors(&[0.4, 99.0, 0.9, 1.4]).beats(&simple, 0.01, 2.0));
        assert!(!errors(&[1.5, 50.0, 2.6, 3.9]).beats(&simple, 0.02, 2.0));
        assert!(!simple.beats(&simple, 0.02, 2.0));
    }

    #[test]
    fn equations_with_some_columns_taken_out_have_the_same_solution() {
        let block = DMatrix::from_fn(300, 6, |i, j| ((i * (j + 2)) as f64 * 0.37).sin() + 0.1 * j as f64);
        let mut gram = Gram::new(5);
        gram.add(&block);
        gram.finish();
        let penalties: Vec<Penalty> = (0..5).map(|i| Penalty { ridge: 0.0, prior: 0.5 * (i + 1) as f64 }).collect();
        let whole = gram.solve(&penalties).unwrap_or_default();
        let precision = DMatrix::from_diagonal(&DVector::from_row_slice(&[1.5, 2.0, 2.5]));
        let parts = gram.reduced(&penalties[..2]).and_then(|reduced| reduced.solve(&precision)).unwrap_or_default();
        assert_eq!((whole.len(), parts.len()), (5, 5));
        for (one, other) in whole.iter().zip(&parts) {
            assert!((one - other).abs() < 1e-9, "{whole:?} {parts:?}");
        }
    }

    #[test]
    fn weights_and_errors_come_from_the_sums() {
        let rows = 200;
        let block = DMatrix::from_fn(rows, 3, |i, j| {
            let x = i as f64 / 10.0;
            match j {
                0 => x.sin(),
                1 => 1.0,
                _ => 3.0 * x.sin() - 2.0 + if i % 2 == 0 { 0.1 } else { -0.1 },
            }
        });
        let mut gram = Gram::new(2);
        gram.add(&block);
        gram.finish();
        let weights = gram.solve(&[Penalty::ridge(0.0); 2]).unwrap_or_default();
        assert!((weights[0] - 3.0).abs() < 0.01 && (weights[1] + 2.0).abs() < 0.01);
        let direct: f64 = block.row_iter().map(|row| (row[2] - weights[0] * row[0] - weights[1] * row[1]).powi(2)).sum();
        assert!((gram.squared_error(&weights) - direct).abs() < 1e-9);
    }
}
