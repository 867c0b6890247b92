//! The one dense product of the layers: `C (+)= A·B`, with `B` packed into panels beforehand.
//!
//! `B` is a weight matrix that is used at every time step, so packing it once a sequence pays, and the small products of a
//! step (32 × 128 × 512, say) run from the second-level cache without being repacked.

use std::ops::Range;

use pulp::{Simd, WithSimd};

use super::{buffer::Buffer, level::Level};

/// Vectors in a panel's row.
const VECTORS: usize = 4;
/// Rows of a panel that are multiplied before the next panel's turn. Each turn writes `C`, and from the second on reads it, which
/// costs more than a panel that comes from the second-level cache.
const DEPTH: usize = 512;
/// Rows of `A` that stay in the second-level cache meanwhile.
const ROWS: usize = 128;

/// Width of a turned `A`'s panels, one cache line: read straight from the matrix, a few columns would touch a page for every row
/// or two, more than the first-level translation buffer holds.
const TURNED: usize = 16;

/// A matrix `k × n` cut into panels of a few vectors' width, each stored row by row; the last one is padded with zeros.
#[derive(Debug, Clone, Default)]
pub(crate) struct Packed {
    data: Buffer,
    rows: usize,
    columns: usize,
    width: usize,
}

impl Packed {
    /// Sizes panels of a `width` for a matrix `rows × columns`.
    fn reshape(&mut self, width: usize, rows: usize, columns: usize) {
        self.width = width;
        self.rows = rows;
        self.columns = columns;
        let panel = rows * self.width;
        self.data.resize(columns.div_ceil(self.width) * panel);
        if !columns.is_multiple_of(self.width) {
            let last = self.data.len() - panel;
            self.data[last..].fill(0.0);
        }
    }

    /// Packs the transpose of the matrix whose rows, each `k` long, are those of `parts` one after the other.
    pub fn transposed(&mut self, level: Level, parts: &[&[f32]], k: usize) {
        let n = parts.iter().map(|part| part.len()).sum::<usize>() / k.max(1);
        let width = VECTORS * level.lanes();
        self.reshape(width, k, n);
        let rows = parts.iter().flat_map(|part| part.chunks_exact(k));
        for (column, row) in rows.enumerate() {
            let panel = &mut self.data[column / width * k * width..][..k * width];
            for (slot, &value) in panel[column % width..].iter_mut().step_by(width).zip(row) {
                *slot = value;
            }
        }
    }

    /// Packs the first `n` columns of the rows of `parts`, which are `stride` apart.
    pub fn rows(&mut self, level: Level, parts: &[&[f32]], stride: usize, n: usize) {
        self.cut(VECTORS * level.lanes(), parts, stride, n);
    }

    /// Packs a matrix, rows of `n` one after the other, to be the turned `A` of a product.
    pub fn turned(&mut self, matrix: &[f32], n: usize) {
        self.cut(TURNED, &[matrix], n, n);
    }

    /// Packs the first `n` columns of the rows of `parts`, which are `stride` apart, into panels of a `width`.
    fn cut(&mut self, width: usize, parts: &[&[f32]], stride: usize, n: usize) {
        let k = parts.iter().map(|part| part.len().div_ceil(stride)).sum();
        self.reshape(width, k, n);
        let rows = parts.iter().flat_map(|part| part.chunks(stride));
        for (index, row) in rows.enumerate() {
            for (panel, piece) in row[..n].chunks(width).enumerate() {
                self.data[(panel * k + index) * width..][..piece.len()].copy_from_slice(piece);
            }
        }
    }
}

/// The left factor of a product.
#[derive(Clone, Copy)]
pub(crate) enum Left<'a> {
    /// The matrix, its rows so far apart.
    Rows(&'a [f32], usize),
    /// What [`Packed::turned`] made of its transpose.
    Turned(&'a Packed),
}

/// `C = A·B`, or `C += A·B` with `add`: `A` is `m × k` and `C` `m × n`, its rows `c_stride` apart.
pub(crate) struct Product<'a> {
    pub a: Left<'a>,
    pub m: usize,
    pub b: &'a Packed,
    pub c: &'a mut [f32],
    pub c_stride: usize,
    pub add: bool,
}

impl WithSimd for Product<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        for top in (0..self.m).step_by(ROWS) {
            let bottom = (top + ROWS).min(self.m);
            for first in (0..self.b.rows).step_by(DEPTH) {
                let last = (first + DEPTH).min(self.b.rows);
                for column in (0..self.b.columns).step_by(self.b.width) {
                    self.panel(simd, top..bottom, first..last, column);
                }
            }
        }
    }
}

impl Product<'_> {
    /// Rows `rows` of `C` at one panel, for the terms `terms` of the sum.
    #[inline(always)]
    fn panel<S: Simd>(&mut self, simd: S, rows: Range<usize>, terms: Range<usize>, column: usize) {
        let width = self.b.width;
        let panel = &self.b.data[column * self.b.rows..][..self.b.rows * width];
        let (panel, _) = S::as_simd_f32s(&panel[terms.start * width..terms.end * width]);
        let (panel, _) = panel.as_chunks::<VECTORS>();
        let most = if S::REGISTER_COUNT >= 32 { 6 } else { 2 };
        let together = if let Left::Turned(_) = self.a { TURNED } else { ROWS };
        let mut row = rows.start;
        while row < rows.end {
            // As many rows at once as the registers hold, shared out evenly: tiles of few rows would leave the units idle.
            let left = rows.end.min((row / together + 1) * together) - row;
            let height = left.div_ceil(left.div_ceil(most));
            match height {
                6 => self.tile::<S, 6, 1>(simd, row, terms.start, column, panel),
                5 => self.tile::<S, 5, 1>(simd, row, terms.start, column, panel),
                4 => self.tile::<S, 4, 1>(simd, row, terms.start, column, panel),
                3 => self.tile::<S, 3, 1>(simd, row, terms.start, column, panel),
                2 => self.tile::<S, 2, 1>(simd, row, terms.start, column, panel),
                _ => self.tile::<S, 1, 2>(simd, row, terms.start, column, panel),
            }
            row += height;
        }
    }

    /// `R` rows of `C` at one panel, summed in `U` interleaved parts.
    #[inline(always)]
    fn tile<S: Simd, const R: usize, const U: usize>(
        &mut self,
        simd: S,
        row: usize,
        term: usize,
        column: usize,
        panel: &[[S::f32s; VECTORS]],
    ) {
        let columns = self.b.width.min(self.b.columns - column);
        let sums = match self.a {
            Left::Turned(a) => {
                let (first, column) = (row / TURNED * TURNED * a.rows + term * TURNED, row % TURNED);
                let (a, _) = a.data[first..][..panel.len() * TURNED].as_chunks::<TURNED>();
                multiply_turned::<S, R>(simd, a, column, panel)
            }
            Left::Rows(matrix, stride) => {
                let mut a: [&[f32]; R] = [&[]; R];
                for (r, a) in a.iter_mut().enumerate() {
                    *a = &matrix[(row + r) * stride + term..][..panel.len()];
                }
                multiply::<S, R, U>(simd, a, panel)
            }
        };
        let add = self.add || term > 0;
        for (r, sums) in sums.into_iter().enumerate() {
            store(simd, &mut self.c[(row + r) * self.c_stride + column..][..columns], sums, add);
        }
    }
}

/// `a·panel` for `R` rows.
#[inline(always)]
fn multiply<S: Simd, const R: usize, const U: usize>(
    simd: S,
    a: [&[f32]; R],
    panel: &[[S::f32s; VECTORS]],
) -> [[S::f32s; VECTORS]; R] {
    let mut sums = [[[simd.splat_f32s(0.0); VECTORS]; R]; U];
    let (groups, rest) = panel.as_chunks::<U>();
    let mut head: [&[[f32; U]]; R] = [&[]; R];
    let mut tail: [&[f32]; R] = [&[]; R];
    for r in 0..R {
        let (whole, left) = a[r].as_chunks::<U>();
        head[r] = &whole[..groups.len()];
        tail[r] = &left[..rest.len()];
    }
    for (index, group) in groups.iter().enumerate() {
        for u in 0..U {
            for r in 0..R {
                let factor = simd.splat_f32s(head[r][index][u]);
                for v in 0..VECTORS {
                    sums[u][r][v] = simd.mul_add_e_f32s(factor, group[u][v], sums[u][r][v]);
                }
            }
        }
    }
    for (index, vectors) in rest.iter().enumerate() {
        for r in 0..R {
            let factor = simd.splat_f32s(tail[r][index]);
            for v in 0..VECTORS {
                sums[0][r][v] = simd.mul_add_e_f32s(factor, vectors[v], sums[0][r][v]);
            }
        }
    }
    let mut total = sums[0];
    for part in &sums[1..] {
        for r in 0..R {
            for v in 0..VECTORS {
                total[r][v] = simd.add_f32s(total[r][v], part[r][v]);
            }
        }
    }
    total
}

/// `aᵀ·panel` for `R` columns of `a`, from `column` on.
#[inline(always)]
fn multiply_turned<S: Simd, const R: usize>(
    simd: S,
    a: &[[f32; TURNED]],
    column: usize,
    panel: &[[S::f32s; VECTORS]],
) -> [[S::f32s; VECTORS]; R] {
    let mut sums = [[simd.splat_f32s(0.0); VECTORS]; R];
    for (row, vectors) in a.iter().zip(panel) {
        let row = &row[column..column + R];
        for r in 0..R {
            let factor = simd.splat_f32s(row[r]);
            for v in 0..VECTORS {
                sums[r][v] = simd.mul_add_e_f32s(factor, vectors[v], sums[r][v]);
            }
        }
    }
    sums
}

/// Writes, or adds, a row of sums to at most a panel's width of `c`.
#[inline(always)]
fn store<S: Simd>(simd: S, c: &mut [f32], sums: [S::f32s; VECTORS], add: bool) {
    let (whole, _) = S::as_mut_simd_f32s(c);
    if let Some(whole) = whole.first_chunk_mut::<VECTORS>() {
        for (c, sum) in whole.iter_mut().zip(sums) {
            *c = if add { simd.add_f32s(*c, sum) } else { sum };
        }
        return;
    }
    for (c, sum) in c.chunks_mut(S::F32_LANES).zip(sums) {
        let sum = if add { simd.add_f32s(simd.partial_load_f32s(c), sum) } else { sum };
        simd.partial_store_f32s(c, sum);
    }
}

/// Writes the transpose of the block of `from` (rows `stride` apart) that has `columns` columns into the contiguous rows of `to`.
pub(crate) fn transpose(from: &[f32], stride: usize, columns: usize, to: &mut [f32]) {
    let rows = to.len() / columns.max(1);
    // Blocks of one cache line each way: every line that is touched is used whole.
    for left in (0..columns).step_by(16) {
        for top in (0..rows).step_by(16) {
            let height = 16.min(rows - top);
            for column in left..(left + 16).min(columns) {
                let source = from[top * stride + column..].iter().step_by(stride);
                let target = &mut to[column * rows + top..][..height];
                for (slot, &value) in target.iter_mut().zip(source) {
                    *slot = value;
                }
            }
        }
    }
}
