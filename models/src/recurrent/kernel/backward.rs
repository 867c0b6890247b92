//! A layer's gradients, backwards through time.

use super::{
    Kind, Shape, Tape, Weights,
    buffer::Buffer,
    cells::{GruBackward, LstmBackward},
    level::Level,
    product::{Packed, Product, transpose},
};

/// Rows of a block of steps.
const ROWS: usize = 128;

/// Gradients of everything that a layer was given.
#[derive(Debug, Clone, Default)]
pub struct Gradients {
    /// At the input, `[steps][batch][input]`; empty if it was not asked for.
    pub x: Vec<f32>,
    /// At the state before the first step, `[batch][hidden]`.
    pub h0: Vec<f32>,
    /// At the cells before the first step, `[batch][hidden]`; empty for a GRU.
    pub c0: Vec<f32>,
    /// Of the input weights, as they are laid out.
    pub input: Vec<f32>,
    /// Of the hidden weights.
    pub hidden: Vec<f32>,
    /// Of the biases.
    pub bias: Vec<f32>,
}

/// Working memory of the backward pass; reused from call to call.
#[derive(Debug, Clone, Default)]
pub struct Work {
    /// Hidden weights, for the gradient at the state.
    to_state: Packed,
    /// Input weights, for the gradient at the input.
    to_input: Packed,
    gates: Packed,
    input: Buffer,
    hidden: Buffer,
    bias: Buffer,
}

/// What [`backward`] is about: a layer, its input, and what its forward pass made of it.
#[derive(Debug)]
pub struct Pass<'a> {
    /// The weights.
    pub weights: Weights<'a>,
    /// The sizes.
    pub shape: Shape,
    /// The input, `[steps][batch][input]`.
    pub x: &'a [f32],
    /// The forward pass's tape; its gates are used up.
    pub tape: &'a mut Tape,
}

/// Gradients of a layer, given those at its outputs (`[steps][batch][hidden]`); `want_x`: the one at the input, too.
///
/// Goes back through time block by block of steps; each block's products follow at once, while the gradients at its gates are
/// still in the cache.
pub fn backward(level: Level, mut pass: Pass<'_>, d_output: &[f32], want_x: bool, work: &mut Work) -> Gradients {
    let Pass { weights, shape, .. } = pass;
    let (n, features, kind) = (shape.hidden, shape.input, weights.kind);
    let units = kind.gates() * n;
    let cells = if kind == Kind::Lstm { shape.state() } else { 0 };
    let mut out = Gradients {
        x: vec![0.0; if want_x { pass.x.len() } else { 0 }],
        h0: vec![0.0; shape.state()],
        c0: vec![0.0; cells],
        input: vec![0.0; weights.input.len()],
        hidden: vec![0.0; weights.hidden.len()],
        bias: vec![0.0; 4 * n],
    };
    work.to_state.rows(level, &[weights.hidden], n, n);
    work.to_input.rows(level, &kind.input_parts(weights.input), features, features);
    work.input.zeros(features * units);
    work.hidden.zeros(n * units);
    work.bias.zeros(4 * n);
    let together = ROWS.div_ceil(shape.batch.max(1));
    for block in (0..shape.steps.div_ceil(together)).rev() {
        let steps = block * together..((block + 1) * together).min(shape.steps);
        for step in steps.clone().rev() {
            step_back(level, &mut pass, d_output, step, work, &mut out);
        }
        block_products(level, &pass, steps, want_x, work, &mut out);
    }
    match kind {
        Kind::Lstm => transpose(&work.input, units, units, &mut out.input),
        Kind::Gru => {
            // Columns `n r z` become rows `r z n`.
            let (rz, new) = out.input.split_at_mut(2 * n * features);
            transpose(&work.input[n..], units, 2 * n, rz);
            transpose(&work.input, units, n, new);
        }
    }
    transpose(&work.hidden, units, units, &mut out.hidden);
    kind.reorder_bias(&work.bias, &mut out.bias, true);
    out
}

/// One step back: turns the tape's gates into the gradients at the gates' inputs, and `out`'s state from after to before the step.
fn step_back(level: Level, pass: &mut Pass<'_>, d_output: &[f32], step: usize, work: &Work, out: &mut Gradients) {
    let n = pass.shape.hidden;
    let state = pass.shape.state();
    let here = step * state..(step + 1) * state;
    let tape = &mut *pass.tape;
    let gates = &mut tape.gates[step * 4 * state..(step + 1) * 4 * state];
    let kind = pass.weights.kind;
    match kind {
        Kind::Lstm => level.run(LstmBackward {
            hidden: n,
            gates: &mut *gates,
            cell_before: &tape.cells[here.clone()],
            cell: &tape.cells[here.start + state..here.end + state],
            d_output: &d_output[here],
            d_hidden: &mut out.h0,
            d_cell: &mut out.c0,
        }),
        Kind::Gru => level.run(GruBackward {
            hidden: n,
            gates: &mut *gates,
            output_before: &tape.outputs[here.clone()],
            d_output: &d_output[here],
            d_hidden: &mut out.h0,
        }),
    }
    level.run(Product {
        a: &gates[kind.hidden_column(n)..],
        a_stride: 4 * n,
        turned: false,
        m: pass.shape.batch,
        b: &work.to_state,
        c: &mut out.h0,
        c_stride: n,
        add: true,
    });
}

/// What the gradients at a block of steps' gates give: the gradient at the input, and shares of the weights' and biases'.
fn block_products(
    level: Level,
    pass: &Pass<'_>,
    steps: std::ops::Range<usize>,
    want_x: bool,
    work: &mut Work,
    out: &mut Gradients,
) {
    let (n, features, kind) = (pass.shape.hidden, pass.shape.input, pass.weights.kind);
    let (width, units, start) = (4 * n, kind.gates() * n, kind.hidden_column(n));
    let rows = steps.start * pass.shape.batch..steps.end * pass.shape.batch;
    let gates = &pass.tape.gates[rows.start * width..rows.end * width];
    if want_x {
        level.run(Product {
            a: gates,
            a_stride: width,
            turned: false,
            m: rows.len(),
            b: &work.to_input,
            c: &mut out.x[rows.start * features..rows.end * features],
            c_stride: features,
            add: false,
        });
    }
    for row in gates.chunks_exact(width) {
        for (sum, &d) in work.bias.iter_mut().zip(row) {
            *sum += d;
        }
    }
    work.gates.rows(level, &[gates], width, units);
    let x = &pass.x[rows.start * features..rows.end * features];
    outer(level, x, features, &work.gates, &mut work.input);
    if start > 0 {
        work.gates.rows(level, &[&gates[start..]], width, units);
    }
    let before = &pass.tape.outputs[rows.start * n..rows.end * n];
    outer(level, before, n, &work.gates, &mut work.hidden);
}

/// `sum += leftᵀ·gates` over a block of rows; `left` has rows of `columns`.
fn outer(level: Level, left: &[f32], columns: usize, gates: &Packed, sum: &mut [f32]) {
    level.run(Product {
        a: left,
        a_stride: columns,
        turned: true,
        m: columns,
        b: gates,
        c_stride: sum.len() / columns,
        c: sum,
        add: true,
    });
}
