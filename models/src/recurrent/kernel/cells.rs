//! One time step of a cell: what happens between the products, for all rows of a batch.
//!
//! The vector arithmetic of a step is written once, in a function on vectors; `over` feeds it whole vectors and then the rest.

use pulp::{Simd, WithSimd};

use super::activation;

/// Applies `f` to the vectors of `N` inputs and `M` outputs of equal length; the outputs' old values are passed, too.
#[inline(always)]
fn over<S: Simd, const N: usize, const M: usize>(
    simd: S,
    inputs: [&[f32]; N],
    outputs: [&mut [f32]; M],
    f: impl Fn([S::f32s; N], [S::f32s; M]) -> [S::f32s; M],
) {
    let len = outputs.first().map_or(0, |slice| slice.len());
    let whole = len / S::F32_LANES;
    // Plain loops: calls of closures on arrays are not always inlined, and then lose the wide instructions.
    let mut heads: [&[S::f32s]; N] = [&[]; N];
    let mut tails: [&[f32]; N] = [&[]; N];
    for i in 0..N {
        let (head, tail) = S::as_simd_f32s(&inputs[i][..len]);
        heads[i] = &head[..whole];
        tails[i] = tail;
    }
    let mut heads_out: [&mut [S::f32s]; M] = [(); M].map(|()| Default::default());
    let mut tails_out: [&mut [f32]; M] = [(); M].map(|()| Default::default());
    for (i, slice) in outputs.into_iter().enumerate() {
        let (head, tail) = S::as_mut_simd_f32s(&mut slice[..len]);
        heads_out[i] = &mut head[..whole];
        tails_out[i] = tail;
    }
    let zero = simd.splat_f32s(0.0);
    let (mut x, mut y) = ([zero; N], [zero; M]);
    for index in 0..whole {
        for i in 0..N {
            x[i] = heads[i][index];
        }
        for i in 0..M {
            y[i] = heads_out[i][index];
        }
        let made = f(x, y);
        for i in 0..M {
            heads_out[i][index] = made[i];
        }
    }
    if len > whole * S::F32_LANES {
        for i in 0..N {
            x[i] = simd.partial_load_f32s(tails[i]);
        }
        for i in 0..M {
            y[i] = simd.partial_load_f32s(tails_out[i]);
        }
        let made = f(x, y);
        for i in 0..M {
            simd.partial_store_f32s(tails_out[i], made[i]);
        }
    }
}

/// The four blocks of a row of gates.
#[inline(always)]
fn blocks(row: &[f32], hidden: usize) -> [&[f32]; 4] {
    let (a, row) = row.split_at(hidden);
    let (b, row) = row.split_at(hidden);
    let (c, d) = row.split_at(hidden);
    [a, b, c, &d[..hidden]]
}

/// The four blocks of a row of gates, to change.
#[inline(always)]
fn blocks_mut(row: &mut [f32], hidden: usize) -> [&mut [f32]; 4] {
    let (a, row) = row.split_at_mut(hidden);
    let (b, row) = row.split_at_mut(hidden);
    let (c, d) = row.split_at_mut(hidden);
    [a, b, c, &mut d[..hidden]]
}

/// LSTM: turns the products in `sums` (rows `i f g o`) into the `gates`' values, and makes `c` and `h` of them:
/// `c = σ(f)·c' + σ(i)·tanh(g)`, `h = σ(o)·tanh(c)`. All other arrays have rows of `hidden`; `bias` is one row of gates.
pub(crate) struct LstmForward<'a> {
    pub hidden: usize,
    pub bias: &'a [f32],
    pub sums: &'a [f32],
    pub gates: &'a mut [f32],
    pub cell_before: &'a [f32],
    pub cell: &'a mut [f32],
    pub output: &'a mut [f32],
}

impl WithSimd for LstmForward<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let n = self.hidden;
        let [bi, bf, bg, bo] = blocks(self.bias, n);
        let rows = self.sums.chunks_exact(4 * n).zip(self.cell_before.chunks_exact(n));
        let made = self.cell.chunks_exact_mut(n).zip(self.output.chunks_exact_mut(n));
        let made = self.gates.chunks_exact_mut(4 * n).zip(made);
        for ((sums, before), (gates, (cell, output))) in rows.zip(made) {
            let [si, sf, sg, so] = blocks(sums, n);
            let [i, f, g, o] = blocks_mut(gates, n);
            over(
                simd,
                [before, si, sf, sg, so, bi, bf, bg, bo],
                [i, f, g, o, cell, output],
                #[inline(always)]
                |[before, i, f, g, o, bi, bf, bg, bo], _| {
                    let sums = [simd.add_f32s(i, bi), simd.add_f32s(f, bf), simd.add_f32s(g, bg), simd.add_f32s(o, bo)];
                    let [i, f, g, o] = activation::gates(simd, sums);
                    let cell = simd.mul_add_e_f32s(f, before, simd.mul_f32s(i, g));
                    [i, f, g, o, cell, simd.mul_f32s(o, activation::tanh(simd, cell))]
                },
            );
        }
    }
}

/// LSTM backwards: makes of the gates' values the gradients at their inputs, `d_gates`, and adds them to
/// `d_bias`. `d_hidden` comes in as what later steps send to `h` (without `d_output`) and leaves as zero, for the hidden product
/// to be added; `d_cell` goes from `c` to `c'`.
pub(crate) struct LstmBackward<'a> {
    pub hidden: usize,
    pub gates: &'a [f32],
    pub cell_before: &'a [f32],
    pub output: &'a [f32],
    pub d_output: &'a [f32],
    pub d_gates: &'a mut [f32],
    pub d_bias: &'a mut [f32],
    pub d_hidden: &'a mut [f32],
    pub d_cell: &'a mut [f32],
}

impl WithSimd for LstmBackward<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let n = self.hidden;
        let one = simd.splat_f32s(1.0);
        let slope = |s| simd.mul_f32s(s, simd.sub_f32s(one, s));
        let saved = self.cell_before.chunks_exact(n).zip(self.output.chunks_exact(n));
        let rows = self.gates.chunks_exact(4 * n).zip(saved.zip(self.d_output.chunks_exact(n)));
        let carried = self.d_hidden.chunks_exact_mut(n).zip(self.d_cell.chunks_exact_mut(n));
        let made = self.d_gates.chunks_exact_mut(4 * n).zip(carried);
        let [bi, bf, bg, bo] = blocks_mut(self.d_bias, n);
        for ((gates, ((before, output), d_output)), (d_gates, (d_hidden, d_cell))) in rows.zip(made) {
            let [i, f, g, o] = blocks(gates, n);
            let [di, df, dg, d_o] = blocks_mut(d_gates, n);
            over(
                simd,
                [i, f, g, o, before, output, d_output],
                [d_hidden, d_cell, di, df, dg, d_o, &mut *bi, &mut *bf, &mut *bg, &mut *bo],
                #[inline(always)]
                |[i, f, g, o, before, output, d_output], [d_hidden, d_cell, _, _, _, _, bi, bf, bg, bo]| {
                    // Cheaper than another exponential; `o` is never zero.
                    let tanh_cell = simd.div_f32s(output, o);
                    let d_h = simd.add_f32s(d_output, d_hidden);
                    let steep = simd.negate_mul_add_e_f32s(tanh_cell, tanh_cell, one);
                    let d_c = simd.mul_add_e_f32s(simd.mul_f32s(d_h, o), steep, d_cell);
                    let d_i = simd.mul_f32s(simd.mul_f32s(d_c, g), slope(i));
                    let d_f = simd.mul_f32s(simd.mul_f32s(d_c, before), slope(f));
                    let d_g = simd.mul_f32s(d_c, i);
                    let d_g = simd.mul_f32s(d_g, simd.negate_mul_add_e_f32s(g, g, one));
                    let d_o = simd.mul_f32s(simd.mul_f32s(d_h, tanh_cell), slope(o));
                    let [bi, bf] = [simd.add_f32s(bi, d_i), simd.add_f32s(bf, d_f)];
                    let [bg, bo] = [simd.add_f32s(bg, d_g), simd.add_f32s(bo, d_o)];
                    [simd.splat_f32s(0.0), simd.mul_f32s(d_c, f), d_i, d_f, d_g, d_o, bi, bf, bg, bo]
                },
            );
        }
    }
}

/// GRU: turns the products in `sums` (rows `n r z q`: `q` is the hidden product of the new state's gate) into the `gates`' values
/// `r = σ(r)`, `z = σ(z)`, `q = q + b_hn`, `n = tanh(n + r·q)`, and makes `h = (1 − z)·n + z·h'`.
pub(crate) struct GruForward<'a> {
    pub hidden: usize,
    pub bias: &'a [f32],
    pub sums: &'a [f32],
    pub gates: &'a mut [f32],
    pub output_before: &'a [f32],
    pub output: &'a mut [f32],
}

impl WithSimd for GruForward<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let width = self.hidden;
        let [bn, br, bz, bq] = blocks(self.bias, width);
        let rows = self.sums.chunks_exact(4 * width).zip(self.output_before.chunks_exact(width));
        let made = self.gates.chunks_exact_mut(4 * width).zip(self.output.chunks_exact_mut(width));
        for ((sums, before), (gates, output)) in rows.zip(made) {
            let [sn, sr, sz, sq] = blocks(sums, width);
            let [n, r, z, q] = blocks_mut(gates, width);
            over(
                simd,
                [before, sn, sr, sz, sq, bn, br, bz, bq],
                [n, r, z, q, output],
                #[inline(always)]
                |[before, n, r, z, q, bn, br, bz, bq], _| {
                    let (r, z) = activation::sigmoids(simd, simd.add_f32s(r, br), simd.add_f32s(z, bz));
                    let q = simd.add_f32s(q, bq);
                    let n = activation::tanh(simd, simd.mul_add_e_f32s(r, q, simd.add_f32s(n, bn)));
                    let output = simd.mul_add_e_f32s(z, simd.sub_f32s(before, n), n);
                    [n, r, z, q, output]
                },
            );
        }
    }
}

/// GRU backwards: makes of the gates' values the gradients at their inputs (at `q`: at the hidden product), `d_gates`, and adds them to `d_bias`. `d_hidden` comes in as what later steps send to `h` (without `d_output`) and leaves
/// as `z·d_h`, for the hidden product to be added.
pub(crate) struct GruBackward<'a> {
    pub hidden: usize,
    pub gates: &'a [f32],
    pub output_before: &'a [f32],
    pub d_output: &'a [f32],
    pub d_gates: &'a mut [f32],
    pub d_bias: &'a mut [f32],
    pub d_hidden: &'a mut [f32],
}

impl WithSimd for GruBackward<'_> {
    type Output = ();
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let width = self.hidden;
        let one = simd.splat_f32s(1.0);
        let slope = |s| simd.mul_f32s(s, simd.sub_f32s(one, s));
        let rows = self.output_before.chunks_exact(width).zip(self.d_output.chunks_exact(width));
        let rows = self.gates.chunks_exact(4 * width).zip(rows);
        let made = self.d_gates.chunks_exact_mut(4 * width).zip(self.d_hidden.chunks_exact_mut(width));
        let [bn, br, bz, bq] = blocks_mut(self.d_bias, width);
        for ((gates, (before, d_output)), (d_gates, d_hidden)) in rows.zip(made) {
            let [n, r, z, q] = blocks(gates, width);
            let [dn, dr, dz, dq] = blocks_mut(d_gates, width);
            over(
                simd,
                [n, r, z, q, before, d_output],
                [d_hidden, dn, dr, dz, dq, &mut *bn, &mut *br, &mut *bz, &mut *bq],
                #[inline(always)]
                |[n, r, z, q, before, d_output], [d_hidden, _, _, _, _, bn, br, bz, bq]| {
                    let d_h = simd.add_f32s(d_output, d_hidden);
                    let d_z = simd.mul_f32s(simd.mul_f32s(d_h, simd.sub_f32s(before, n)), slope(z));
                    let d_n = simd.mul_f32s(d_h, simd.sub_f32s(one, z));
                    let d_n = simd.mul_f32s(d_n, simd.negate_mul_add_e_f32s(n, n, one));
                    let d_r = simd.mul_f32s(simd.mul_f32s(d_n, q), slope(r));
                    let d_q = simd.mul_f32s(d_n, r);
                    let [bn, br] = [simd.add_f32s(bn, d_n), simd.add_f32s(br, d_r)];
                    let [bz, bq] = [simd.add_f32s(bz, d_z), simd.add_f32s(bq, d_q)];
                    [simd.mul_f32s(d_h, z), d_n, d_r, d_z, d_q, bn, br, bz, bq]
                },
            );
        }
    }
}
