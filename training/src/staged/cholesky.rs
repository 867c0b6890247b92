//! Cholesky factorisation in blocks, so that nearly all of the work is matrix products.

use nalgebra::DMatrix;

/// Columns of one panel.
const PANEL: usize = 64;
/// Columns of the trailing matrix that one product covers.
const TILE: usize = 192;

/// Solves `A·X = B` for a symmetric positive definite `A`, of which only the lower triangle is read; `None` where it is not definite.
pub fn solve_definite(mut a: DMatrix<f64>, b: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let size = a.nrows();
    for start in (0..size).step_by(PANEL) {
        let width = PANEL.min(size - start);
        let rest = size - start - width;
        let diagonal = a.view((start, start), (width, width)).into_owned();
        let factor = diagonal.cholesky()?.unpack();
        a.view_mut((start, start), (width, width)).copy_from(&factor);
        if rest == 0 {
            break;
        }
        let inverse = factor.solve_lower_triangular(&DMatrix::identity(width, width))?;
        let below = a.view((start + width, start), (rest, width)) * inverse.transpose();
        let transposed = below.transpose();
        a.view_mut((start + width, start), (rest, width)).copy_from(&below);
        for tile in (0..rest).step_by(TILE) {
            let (columns, rows) = (TILE.min(rest - tile), rest - tile);
            let corner = start + width + tile;
            a.view_mut((corner, corner), (rows, columns)).gemm(
                -1.0,
                &below.rows(tile, rows),
                &transposed.columns(tile, columns),
                1.0,
            );
        }
    }
    let half = a.solve_lower_triangular(b)?;
    a.tr_solve_lower_triangular(&half)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_the_plain_factorisation() {
        let size = 3 * PANEL + 17;
        let root = DMatrix::from_fn(size, size, |i, j| ((i * 31 + j * 17) % 101) as f64 / 101.0 - 0.5);
        let a = &root * root.transpose() + DMatrix::identity(size, size);
        let b = DMatrix::from_fn(size, 2, |i, j| ((i + 7 * j) as f64).sin());
        let plain = a.clone().cholesky().map(|factor| factor.solve(&b));
        let blocked = solve_definite(a, &b);
        assert!(blocked.zip(plain).is_some_and(|(x, y)| (x - y).amax() < 1e-10));
    }

    #[test]
    fn an_indefinite_matrix_is_refused() {
        let a = DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 2.0, 1.0]);
        assert!(solve_definite(a, &DMatrix::from_element(2, 1, 1.0)).is_none());
    }
}
