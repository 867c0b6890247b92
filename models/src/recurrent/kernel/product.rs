//! The dense product of the layers, `A·B`, with `B` packed into panels beforehand.
//!
//! `B` is a weight matrix that every time step uses, so it is packed once per sequence; the small
//! products of a step (such as 32 × 128 × 512) then run from the second-level cache. The caller
//! receives the sums while they are in registers.

use std::ops::Range;

use pulp::{Simd, WithSimd};

use super::{buffer::Buffer, level::Level};

/// Vectors in a row of a panel; one per gate if its columns are gates.
pub(crate) const VECTORS: usize = 4;
/// Rows of `A` that stay in the second-level cache during all panels.
const ROWS: usize = 128;

/// Width of the panels of a transposed `A`, one cache line. Read directly from the matrix, a few
/// columns would touch a page for every one or two rows, more than the first-level translation
/// buffer holds.
const TURNED: usize = 16;

/// Columns of a row of gates of `hidden` units: for every vector of units, the four gates' vectors
/// side by side. The last units may be padding.
pub(crate) fn gate_columns(level: Level, hidden: usize) -> usize {
    VECTORS * hidden.next_multiple_of(level.lanes())
}

/// A matrix cut into panels a few vectors wide, each stored row by row; the last one is padded with
/// zeros.
#[derive(Debug, Clone, Default)]
pub(crate) struct Packed {
    data: Buffer,
    rows: usize,
    columns: usize,
    width: usize,
}

impl Packed {
    /// Sets the size to panels of a `width` for a matrix `rows × columns`; old values remain.
    fn reshape(&mut self, width: usize, rows: usize, columns: usize) {
        self.width = width;
        self.rows = rows;
        self.columns = columns;
        self.data.resize(columns.next_multiple_of(width) * rows);
    }

    /// Sets the size to panels of gates, `rows` of them, to be filled by [`Self::panel_row`].
    pub fn reshape_gates(&mut self, level: Level, rows: usize, hidden: usize) {
        self.reshape(VECTORS * level.lanes(), rows, gate_columns(level, hidden));
    }

    /// A row of the panel that starts at `column`.
    #[inline(always)]
    pub fn panel_row(&mut self, row: usize, column: usize) -> &mut [f32] {
        &mut self.data[column * self.rows + row * self.width..][..self.width]
    }

    /// Packs the transpose of the gates' weights, each gate's rows `k` long; gates without weights get zeros.
    pub fn gates(&mut self, level: Level, weights: [&[f32]; VECTORS], hidden: usize, k: usize) {
        self.reshape_gates(level, k, hidden);
        let (lanes, width) = (level.lanes(), self.width);
        self.data.fill(0.0);
        for (gate, weights) in weights.into_iter().enumerate() {
            for (unit, row) in weights.chunks_exact(k).enumerate() {
                let panel = &mut self.data[unit / lanes * k * width..][..k * width];
                for (slot, &value) in panel[gate * lanes + unit % lanes..].iter_mut().step_by(width).zip(row) {
                    *slot = value;
                }
            }
        }
    }

    /// Packs the rows of the gates' weights, `n` columns each, in the order of a row of gates; gates without weights are left out.
    pub fn gate_rows(&mut self, level: Level, weights: [&[f32]; VECTORS], hidden: usize, n: usize) {
        let lanes = level.lanes();
        let present = || weights.into_iter().filter(|gate| !gate.is_empty());
        let gates = present().count();
        self.reshape(VECTORS * lanes, gates * hidden.next_multiple_of(lanes), n);
        self.data.fill(0.0);
        for (gate, weights) in present().enumerate() {
            for (unit, row) in weights.chunks_exact(n).enumerate() {
                self.set_row((unit / lanes * gates + gate) * lanes + unit % lanes, row);
            }
        }
    }

    /// Packs a matrix, rows of `n` in sequence, as the transposed `A` of a product; values beyond
    /// its columns are unspecified.
    pub fn turned(&mut self, matrix: &[f32], n: usize) {
        self.reshape(TURNED, matrix.len() / n.max(1), n);
        let panel = self.rows;
        let (panels, _) = self.data.as_chunks_mut::<TURNED>();
        for (index, row) in matrix.chunks_exact(n).enumerate() {
            // Whole lines are moved in registers: a function call per line would cost more than the
            // move.
            let (lines, rest) = row.as_chunks::<TURNED>();
            let mut slots = panels[index..].iter_mut().step_by(panel);
            for (line, slot) in lines.iter().zip(slots.by_ref()) {
                *slot = *line;
            }
            if let Some(slot) = slots.next() {
                slot[..rest.len()].copy_from_slice(rest);
            }
        }
    }

    /// Sets a row.
    fn set_row(&mut self, index: usize, row: &[f32]) {
        let (panel, width) = (self.rows * self.width, self.width);
        for (panel, piece) in self.data.chunks_exact_mut(panel).zip(row.chunks(width)) {
            panel[index * width..][..piece.len()].copy_from_slice(piece);
        }
    }
}

/// The left factor of a product.
#[derive(Clone, Copy)]
pub(crate) enum Left<'a> {
    /// Terms side by side.
    Rows(Rows<'a>),
    /// Output of [`Packed::turned`] for its transpose.
    Turned(&'a Packed),
}

/// Rows of terms, in one or several pieces.
#[derive(Clone, Copy)]
pub(crate) struct Rows<'a> {
    data: &'a [f32],
    /// Stride of the rows.
    stride: usize,
    /// Terms in a piece.
    terms: usize,
    /// Stride of the pieces.
    step: usize,
}

impl<'a> Left<'a> {
    /// A matrix with rows of `terms`.
    pub fn matrix(data: &'a [f32], terms: usize) -> Self {
        Self::Rows(Rows { data, stride: terms, terms, step: 0 })
    }

    /// Panels of gates from the row `top` on, of each panel's row the `vectors`.
    pub fn gates(gates: &'a Packed, top: usize, vectors: Range<usize>) -> Self {
        let lanes = gates.width / VECTORS;
        Self::Rows(Rows {
            data: &gates.data[top * gates.width + vectors.start * lanes..],
            stride: gates.width,
            terms: vectors.len() * lanes,
            step: gates.rows * gates.width,
        })
    }
}

/// Receives the sums of a product.
pub(crate) trait Finish<const V: usize> {
    /// Takes, of the `R` rows from `row` on, the `V` vectors of the panel that starts at `column`.
    fn finish<S: Simd, const R: usize>(&mut self, simd: S, row: usize, column: usize, sums: [[S::f32s; V]; R]);
}

/// The product of `A`, `m` rows of it, and of each panel's row of `B` the `V` vectors after the first `SKIP`.
pub(crate) struct Product<'a, F, const SKIP: usize, const V: usize> {
    pub a: Left<'a>,
    pub m: usize,
    pub b: &'a Packed,
    pub finish: F,
}

impl<F: Finish<V>, const SKIP: usize, const V: usize> WithSimd for Product<'_, F, SKIP, V> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        for top in (0..self.m).step_by(ROWS) {
            let bottom = (top + ROWS).min(self.m);
            for column in (0..self.b.columns).step_by(self.b.width) {
                self.panel(simd, top..bottom, column);
            }
        }
    }
}

impl<F: Finish<V>, const SKIP: usize, const V: usize> Product<'_, F, SKIP, V> {
    /// The product of some rows with one panel.
    #[inline(always)]
    fn panel<S: Simd>(&mut self, simd: S, rows: Range<usize>, column: usize) {
        let (panel, _) = S::as_simd_f32s(&self.b.data[column * self.b.rows..][..self.b.rows * self.b.width]);
        let (panel, _) = panel.as_chunks::<VECTORS>();
        let most = if S::REGISTER_COUNT >= 32 { 6 } else { 2 };
        let together = if let Left::Turned(_) = self.a { TURNED } else { ROWS };
        let mut row = rows.start;
        while row < rows.end {
            // As many rows at once as the registers hold, shared out evenly: tiles of few rows would leave the units idle.
            let left = rows.end.min((row / together + 1) * together) - row;
            let height = left.div_ceil(left.div_ceil(most));
            match height {
                6 => self.tile::<S, 6, 1>(simd, row, column, panel),
                5 => self.tile::<S, 5, 1>(simd, row, column, panel),
                4 => self.tile::<S, 4, 1>(simd, row, column, panel),
                3 => self.tile::<S, 3, 1>(simd, row, column, panel),
                2 => self.tile::<S, 2, 1>(simd, row, column, panel),
                _ => self.tile::<S, 1, 2>(simd, row, column, panel),
            }
            row += height;
        }
    }

    /// `R` rows at one panel, summed in `U` interleaved parts.
    #[inline(always)]
    fn tile<S: Simd, const R: usize, const U: usize>(
        &mut self,
        simd: S,
        row: usize,
        column: usize,
        panel: &[[S::f32s; VECTORS]],
    ) {
        let sums = match self.a {
            Left::Turned(a) => {
                let (a_column, a_panel) = (row % TURNED, row / TURNED);
                let (a, _) = a.data[a_panel * TURNED * a.rows..][..panel.len() * TURNED].as_chunks::<TURNED>();
                multiply_turned::<S, R, SKIP, V>(simd, a, a_column, panel)
            }
            Left::Rows(a) => multiply::<S, R, U, SKIP, V>(simd, a, row, panel),
        };
        self.finish.finish(simd, row, column, sums);
    }
}

/// `a·panel` for `R` rows of `a`, from `row` on.
#[inline(always)]
fn multiply<S: Simd, const R: usize, const U: usize, const SKIP: usize, const V: usize>(
    simd: S,
    a: Rows<'_>,
    row: usize,
    panel: &[[S::f32s; VECTORS]],
) -> [[S::f32s; V]; R] {
    let mut sums = [[[simd.splat_f32s(0.0); V]; R]; U];
    for (piece, panel) in panel.chunks(a.terms).enumerate() {
        let (groups, rest) = panel.as_chunks::<U>();
        let mut head: [&[[f32; U]]; R] = [&[]; R];
        let mut tail: [&[f32]; R] = [&[]; R];
        for r in 0..R {
            let (whole, left) = a.data[piece * a.step + (row + r) * a.stride..][..panel.len()].as_chunks::<U>();
            head[r] = &whole[..groups.len()];
            tail[r] = &left[..rest.len()];
        }
        for (index, group) in groups.iter().enumerate() {
            for u in 0..U {
                for r in 0..R {
                    let factor = simd.splat_f32s(head[r][index][u]);
                    for v in 0..V {
                        sums[u][r][v] = simd.mul_add_e_f32s(factor, group[u][SKIP + v], sums[u][r][v]);
                    }
                }
            }
        }
        for (index, vectors) in rest.iter().enumerate() {
            for r in 0..R {
                let factor = simd.splat_f32s(tail[r][index]);
                for v in 0..V {
                    sums[0][r][v] = simd.mul_add_e_f32s(factor, vectors[SKIP + v], sums[0][r][v]);
                }
            }
        }
    }
    let mut total = sums[0];
    for part in &sums[1..] {
        for r in 0..R {
            for v in 0..V {
                total[r][v] = simd.add_f32s(total[r][v], part[r][v]);
            }
        }
    }
    total
}

/// `aᵀ·panel` for `R` columns of `a`, from `column` on.
#[inline(always)]
fn multiply_turned<S: Simd, const R: usize, const SKIP: usize, const V: usize>(
    simd: S,
    a: &[[f32; TURNED]],
    column: usize,
    panel: &[[S::f32s; VECTORS]],
) -> [[S::f32s; V]; R] {
    let mut sums = [[simd.splat_f32s(0.0); V]; R];
    for (row, vectors) in a.iter().zip(panel) {
        let row = &row[column..column + R];
        for r in 0..R {
            let factor = simd.splat_f32s(row[r]);
            for v in 0..V {
                sums[r][v] = simd.mul_add_e_f32s(factor, vectors[SKIP + v], sums[r][v]);
            }
        }
    }
    sums
}

/// Stores the product for the gates that are `fed`.
pub(crate) fn fed_product(level: Level, fed: &Range<usize>, product: Product<'_, Store<'_>, 0, 4>) {
    let Product { a, m, b, finish } = product;
    match (fed.start, fed.len()) {
        (0, 4) => level.run(Product::<_, 0, 4> { a, m, b, finish }),
        (0, _) => level.run(Product::<_, 0, 3> { a, m, b, finish }),
        _ => level.run(Product::<_, 1, 3> { a, m, b, finish }),
    }
}

/// Writes a product's sums, or adds them, to rows of `columns`.
pub(crate) struct Store<'a> {
    pub c: &'a mut [f32],
    pub columns: usize,
    /// Column of a row at which the panels' sums begin.
    pub from: usize,
    pub add: bool,
}

impl<const V: usize> Finish<V> for Store<'_> {
    #[inline(always)]
    fn finish<S: Simd, const R: usize>(&mut self, simd: S, row: usize, column: usize, sums: [[S::f32s; V]; R]) {
        let first = self.from + column;
        let last = self.columns.min(first + V * S::F32_LANES);
        if last - first < V * S::F32_LANES {
            for (r, sums) in sums.into_iter().enumerate() {
                self.part(simd, &(first..last), row + r, sums);
            }
            return;
        }
        // So short a loop is unrolled: the sums go from their registers straight to `c`.
        for (r, sums) in sums.into_iter().enumerate() {
            let c = &mut self.c[(row + r) * self.columns + first..][..V * S::F32_LANES];
            let (c, _) = S::as_mut_simd_f32s(c);
            for v in 0..V {
                c[v] = if self.add { simd.add_f32s(c[v], sums[v]) } else { sums[v] };
            }
        }
    }
}

impl Store<'_> {
    /// Writes, or adds, as much of a row's sums as there are `columns` for.
    #[inline(always)]
    fn part<S: Simd>(&mut self, simd: S, columns: &Range<usize>, row: usize, sums: impl IntoIterator<Item = S::f32s>) {
        let c = &mut self.c[row * self.columns..][columns.clone()];
        for (c, sum) in c.chunks_mut(S::F32_LANES).zip(sums) {
            let sum = if self.add { simd.add_f32s(simd.partial_load_f32s(c), sum) } else { sum };
            simd.partial_store_f32s(c, sum);
        }
    }
}

/// One cache line, in `f32`s.
const LINE: usize = 16;

/// Writes the transpose of the block of `from` (rows `stride` apart) that has `columns` columns into the contiguous rows of `to`.
pub(crate) fn transpose(from: &[f32], stride: usize, columns: usize, to: &mut [f32]) {
    let rows = to.len() / columns.max(1);
    // Blocks of one cache line each way: every line that is touched is used whole.
    for left in (0..columns).step_by(LINE) {
        for top in (0..rows).step_by(LINE) {
            let (width, height) = (LINE.min(columns - left), LINE.min(rows - top));
            let (from, to) = (&from[top * stride + left..], &mut to[left * rows + top..]);
            let mut block = [[0.0; LINE]; LINE];
            for (line, row) in block.iter_mut().zip(from.chunks(stride)).take(height) {
                line[..width].copy_from_slice(&row[..width]);
            }
            for (column, row) in to.chunks_mut(rows).take(width).enumerate() {
                let line: [f32; LINE] = std::array::from_fn(|k| block[k][column]);
                row[..height].copy_from_slice(&line[..height]);
            }
        }
    }
}
