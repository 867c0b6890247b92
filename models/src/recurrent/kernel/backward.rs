//! A layer's gradients, backwards through time.

use super::{
    Kind, Shape, Tape, Weights,
    buffer::Buffer,
    cells::{GruBackward, LstmBackward},
    level::Level,
    product::{Left, Packed, Product, transpose},
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
    /// Gradients at a block's gates.
    gates: Buffer,
    /// They again, for the weights' products with what the gates were `fed`.
    packed: Packed,
    fed: Packed,
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
    /// The forward pass's tape.
    pub tape: &'a Tape,
}

/// Gradients of a layer, given those at its outputs (`[steps][batch][hidden]`); `want_x`: the one at the input, too.
///
/// Goes back through time block by block of steps; each block's products follow at once, while the gradients at its gates are
/// still in the cache.
pub fn backward(level: Level, pass: &Pass<'_>, d_output: &[f32], want_x: bool, work: &mut Work) -> Gradients {
    let &Pass { weights, shape, .. } = pass;
    let (n, features, kind) = (shape.hidden, shape.input, weights.kind);
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
    let units = kind.gates() * n;
    work.input.zeros(features * units);
    work.hidden.zeros(n * units);
    work.bias.zeros(4 * n);
    let together = ROWS.div_ceil(shape.batch.max(1));
    work.gates.resize(together * shape.batch * 4 * n);
    for block in (0..shape.steps.div_ceil(together)).rev() {
        let steps = block * together..((block + 1) * together).min(shape.steps);
        for step in steps.clone().rev() {
            step_back(level, pass, d_output, step, step - steps.start, work, &mut out);
        }
        block_products(level, pass, steps, work);
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

/// One step back, the `index`-th of its block: makes the gradients at the gates' inputs and at `x`, and turns `out`'s state from
/// after to before the step.
fn step_back(level: Level, pass: &Pass<'_>, d_output: &[f32], step: usize, index: usize, work: &mut Work, out: &mut Gradients) {
    let n = pass.shape.hidden;
    let state = pass.shape.state();
    let (before, after) = (step * state..(step + 1) * state, (step + 1) * state..(step + 2) * state);
    let Tape { gates, outputs, cells, .. } = pass.tape;
    let gates = &gates[4 * before.start..4 * before.end];
    let d_gates = &mut work.gates[index * 4 * state..][..4 * state];
    let (d_output, d_bias) = (&d_output[before.clone()], &mut work.bias);
    let kind = pass.weights.kind;
    match kind {
        Kind::Lstm => level.run(LstmBackward {
            hidden: n,
            gates,
            cell_before: &cells[before],
            output: &outputs[after],
            d_output,
            d_gates,
            d_bias,
            d_hidden: &mut out.h0,
            d_cell: &mut out.c0,
        }),
        Kind::Gru => level.run(GruBackward {
            hidden: n,
            gates,
            output_before: &outputs[before],
            d_output,
            d_gates,
            d_bias,
            d_hidden: &mut out.h0,
        }),
    }
    level.run(Product {
        a: Left::Rows(&d_gates[kind.hidden_column(n)..], 4 * n),
        m: pass.shape.batch,
        b: &work.to_state,
        c: &mut out.h0,
        c_stride: n,
        add: true,
    });
    if !out.x.is_empty() {
        let features = pass.shape.input;
        let rows = step * pass.shape.batch * features..(step + 1) * pass.shape.batch * features;
        level.run(Product {
            a: Left::Rows(d_gates, 4 * n),
            m: pass.shape.batch,
            b: &work.to_input,
            c: &mut out.x[rows],
            c_stride: features,
            add: false,
        });
    }
}

/// Adds what the gradients at a block of steps' gates give to the weights' gradients.
fn block_products(level: Level, pass: &Pass<'_>, steps: std::ops::Range<usize>, work: &mut Work) {
    let (n, features, kind) = (pass.shape.hidden, pass.shape.input, pass.weights.kind);
    let (width, units, start) = (4 * n, kind.gates() * n, kind.hidden_column(n));
    let rows = steps.start * pass.shape.batch..steps.end * pass.shape.batch;
    let gates = &work.gates[..rows.len() * width];
    let outer = |fed: &Packed, gates: &Packed, sum: &mut [f32]| {
        level.run(Product { a: Left::Turned(fed), m: sum.len() / units, b: gates, c: sum, c_stride: units, add: true });
    };
    work.packed.rows(level, &[gates], width, units);
    work.fed.turned(&pass.x[rows.start * features..rows.end * features], features);
    outer(&work.fed, &work.packed, &mut work.input);
    if start > 0 {
        work.packed.rows(level, &[&gates[start..]], width, units);
    }
    work.fed.turned(&pass.tape.outputs[rows.start * n..rows.end * n], n);
    outer(&work.fed, &work.packed, &mut work.hidden);
}
