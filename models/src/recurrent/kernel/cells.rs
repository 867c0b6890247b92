//! One time step of a cell after its product, vector by vector of units.
//!
//! A row of gates has the four gates of a vector of units side by side. A row of the state is
//! unpadded, so that its last vector may be partial.

use std::ops::Range;

use pulp::{Simd, WithSimd};

use super::{
    activation,
    product::{Finish, Packed, VECTORS},
};

/// The gates' vectors at `at`.
#[inline(always)]
fn gates_at<S: Simd>(row: &[f32], at: usize) -> [S::f32s; VECTORS] {
    let (vectors, _) = S::as_simd_f32s(&row[at..][..VECTORS * S::F32_LANES]);
    let (vectors, _) = vectors.as_chunks::<VECTORS>();
    vectors[0]
}

/// The gates' vectors at `at`, mutable.
#[inline(always)]
fn gates_at_mut<S: Simd>(row: &mut [f32], at: usize) -> &mut [S::f32s; VECTORS] {
    let (vectors, _) = S::as_mut_simd_f32s(&mut row[at..][..VECTORS * S::F32_LANES]);
    let (vectors, _) = vectors.as_chunks_mut::<VECTORS>();
    &mut vectors[0]
}

/// A vector of units, padded with zeros if it is partial.
#[inline(always)]
fn load<S: Simd>(simd: S, units: &[f32]) -> S::f32s {
    match S::as_simd_f32s(units) {
        (&[whole], _) => whole,
        _ => simd.partial_load_f32s(units),
    }
}

/// Writes a vector of units, or the part that fits.
#[inline(always)]
fn store<S: Simd>(simd: S, units: &mut [f32], values: S::f32s) {
    match S::as_mut_simd_f32s(units) {
        ([whole], _) => *whole = values,
        _ => simd.partial_store_f32s(units, values),
    }
}

/// Range of the vector in a row of `hidden` units whose gates start at `column`.
#[inline(always)]
fn units(row: usize, column: usize, hidden: usize, lanes: usize) -> Range<usize> {
    let first = column / VECTORS;
    row * hidden + first..row * hidden + hidden.min(first + lanes)
}

/// LSTM: computes the `gates`' values from the hidden product, the input product in `sums` and the
/// `bias`, then `c` and `h`: `c = σ(f)·c' + σ(i)·tanh(g)`, `h = σ(o)·tanh(c)`. Gates are `i f g o`;
/// `bias` is one row of them, `columns` long.
pub(crate) struct LstmForward<'a> {
    pub hidden: usize,
    pub columns: usize,
    pub bias: &'a [f32],
    pub sums: &'a [f32],
    pub gates: &'a mut [f32],
    pub cell_before: &'a [f32],
    pub cell: &'a mut [f32],
    pub output: &'a mut [f32],
}

impl Finish<4> for LstmForward<'_> {
    #[inline(always)]
    fn finish<S: Simd, const R: usize>(&mut self, simd: S, row: usize, column: usize, products: [[S::f32s; 4]; R]) {
        for (r, product) in products.into_iter().enumerate() {
            self.cells(simd, row + r, column, product);
        }
    }
}

impl LstmForward<'_> {
    /// A vector of cells.
    #[inline(always)]
    fn cells<S: Simd>(&mut self, simd: S, row: usize, column: usize, product: [S::f32s; 4]) {
        let at = row * self.columns + column;
        let (input, bias) = (gates_at::<S>(self.sums, at), gates_at::<S>(self.bias, column));
        let mut sums = product;
        for gate in 0..4 {
            sums[gate] = simd.add_f32s(simd.add_f32s(sums[gate], input[gate]), bias[gate]);
        }
        let gates = activation::gates(simd, sums);
        let [i, f, g, o] = gates;
        let units = units(row, column, self.hidden, S::F32_LANES);
        let cell = simd.mul_add_e_f32s(f, load(simd, &self.cell_before[units.clone()]), simd.mul_f32s(i, g));
        *gates_at_mut::<S>(self.gates, at) = gates;
        store(simd, &mut self.cell[units.clone()], cell);
        store(simd, &mut self.output[units], simd.mul_f32s(o, activation::tanh(simd, cell)));
    }
}

/// GRU: computes the `gates`' values from the hidden product (of the gates `r z q`), the input
/// product in `sums` (for `n r z`) and the `bias`: `r = σ(r)`, `z = σ(z)`, `q = q + b_hn`, `n =
/// tanh(n + r·q)`, then `h = (1 − z)·n + z·h'`. Gates are `n r z q`.
pub(crate) struct GruForward<'a> {
    pub hidden: usize,
    pub columns: usize,
    pub bias: &'a [f32],
    pub sums: &'a [f32],
    pub gates: &'a mut [f32],
    pub output_before: &'a [f32],
    pub output: &'a mut [f32],
}

impl Finish<3> for GruForward<'_> {
    #[inline(always)]
    fn finish<S: Simd, const R: usize>(&mut self, simd: S, row: usize, column: usize, products: [[S::f32s; 3]; R]) {
        for (r, product) in products.into_iter().enumerate() {
            self.cells(simd, row + r, column, product);
        }
    }
}

impl GruForward<'_> {
    /// A vector of cells.
    #[inline(always)]
    fn cells<S: Simd>(&mut self, simd: S, row: usize, column: usize, [r, z, q]: [S::f32s; 3]) {
        let at = row * self.columns + column;
        let ([sn, sr, sz, _], [bn, br, bz, bq]) = (gates_at::<S>(self.sums, at), gates_at::<S>(self.bias, column));
        let sum = |a, b, c| simd.add_f32s(simd.add_f32s(a, b), c);
        let (r, z) = activation::sigmoids(simd, sum(r, sr, br), sum(z, sz, bz));
        let q = simd.add_f32s(q, bq);
        let n = activation::tanh(simd, simd.mul_add_e_f32s(r, q, simd.add_f32s(sn, bn)));
        let units = units(row, column, self.hidden, S::F32_LANES);
        let before = load(simd, &self.output_before[units.clone()]);
        *gates_at_mut::<S>(self.gates, at) = [n, r, z, q];
        store(simd, &mut self.output[units], simd.mul_add_e_f32s(z, simd.sub_f32s(before, n), n));
    }
}

/// LSTM backwards: computes the gradients of the gates' inputs from the gates' values, rows `rows`
/// of `d_gates`, and adds them to `d_bias`. `d_hidden` is the gradient of `h` from later steps
/// (without `d_output`); `d_cell` changes from `c` to `c'`.
pub(crate) struct LstmBackward<'a> {
    pub hidden: usize,
    pub gates: &'a [f32],
    pub cell_before: &'a [f32],
    pub output: &'a [f32],
    pub d_output: &'a [f32],
    pub d_gates: &'a mut Packed,
    pub rows: Range<usize>,
    pub d_bias: &'a mut [f32],
    pub d_hidden: &'a [f32],
    pub d_cell: &'a mut [f32],
}

impl WithSimd for LstmBackward<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let one = simd.splat_f32s(1.0);
        let slope = |s| simd.mul_f32s(s, simd.sub_f32s(one, s));
        let columns = self.d_bias.len();
        let width = VECTORS * S::F32_LANES;
        for row in 0..self.rows.len() {
            for column in (0..columns).step_by(width) {
                let [i, f, g, o] = gates_at::<S>(self.gates, row * columns + column);
                let units = units(row, column, self.hidden, S::F32_LANES);
                let unit = |array: &[f32]| load(simd, &array[units.clone()]);
                // Faster than another exponential; `o` is never zero.
                let tanh_cell = simd.div_f32s(unit(self.output), o);
                let d_h = simd.add_f32s(unit(self.d_output), unit(self.d_hidden));
                let steep = simd.negate_mul_add_e_f32s(tanh_cell, tanh_cell, one);
                let d_c = simd.mul_add_e_f32s(simd.mul_f32s(d_h, o), steep, unit(self.d_cell));
                let d_i = simd.mul_f32s(simd.mul_f32s(d_c, g), slope(i));
                let d_f = simd.mul_f32s(simd.mul_f32s(d_c, unit(self.cell_before)), slope(f));
                let d_g = simd.mul_f32s(simd.mul_f32s(d_c, i), simd.negate_mul_add_e_f32s(g, g, one));
                let d_o = simd.mul_f32s(simd.mul_f32s(d_h, tanh_cell), slope(o));
                let made = [d_i, d_f, d_g, d_o];
                let d_bias = gates_at_mut::<S>(self.d_bias, column);
                for gate in 0..4 {
                    d_bias[gate] = simd.add_f32s(d_bias[gate], made[gate]);
                }
                *gates_at_mut::<S>(self.d_gates.panel_row(self.rows.start + row, column), 0) = made;
                store(simd, &mut self.d_cell[units], simd.mul_f32s(d_c, f));
            }
        }
    }
}

/// GRU backwards: computes the gradients of the gates' inputs (for `q`: of the hidden product) from
/// the gates' values, rows `rows` of `d_gates`, and adds them to `d_bias`. `d_hidden` is the
/// gradient of `h` from later steps (without `d_output`) on entry, and `z·d_h` on return, without
/// the hidden product.
pub(crate) struct GruBackward<'a> {
    pub hidden: usize,
    pub gates: &'a [f32],
    pub output_before: &'a [f32],
    pub d_output: &'a [f32],
    pub d_gates: &'a mut Packed,
    pub rows: Range<usize>,
    pub d_bias: &'a mut [f32],
    pub d_hidden: &'a mut [f32],
}

impl WithSimd for GruBackward<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let one = simd.splat_f32s(1.0);
        let slope = |s| simd.mul_f32s(s, simd.sub_f32s(one, s));
        let columns = self.d_bias.len();
        let width = VECTORS * S::F32_LANES;
        for row in 0..self.rows.len() {
            for column in (0..columns).step_by(width) {
                let [n, r, z, q] = gates_at::<S>(self.gates, row * columns + column);
                let units = units(row, column, self.hidden, S::F32_LANES);
                let unit = |array: &[f32]| load(simd, &array[units.clone()]);
                let d_h = simd.add_f32s(unit(self.d_output), unit(self.d_hidden));
                let d_z = simd.mul_f32s(simd.mul_f32s(d_h, simd.sub_f32s(unit(self.output_before), n)), slope(z));
                let d_n = simd.mul_f32s(d_h, simd.sub_f32s(one, z));
                let d_n = simd.mul_f32s(d_n, simd.negate_mul_add_e_f32s(n, n, one));
                let d_r = simd.mul_f32s(simd.mul_f32s(d_n, q), slope(r));
                let made = [d_n, d_r, d_z, simd.mul_f32s(d_n, r)];
                let d_bias = gates_at_mut::<S>(self.d_bias, column);
                for gate in 0..4 {
                    d_bias[gate] = simd.add_f32s(d_bias[gate], made[gate]);
                }
                *gates_at_mut::<S>(self.d_gates.panel_row(self.rows.start + row, column), 0) = made;
                store(simd, &mut self.d_hidden[units], simd.mul_f32s(d_h, z));
            }
        }
    }
}
