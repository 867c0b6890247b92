//! A layer's gradients, backwards through time.

use std::ops::Range;

use super::{
    Kind, Shape, Tape, Weights,
    buffer::Buffer,
    cells::{GruBackward, LstmBackward},
    level::Level,
    product::{Left, Packed, Product, Store, VECTORS, fed_product, gate_columns, transpose},
};

/// Rows of a block of steps.
const ROWS: usize = 128;

/// Gradients of all inputs of a layer.
#[derive(Debug, Clone, Default)]
pub struct Gradients {
    /// Of the state before the first step, `[batch][hidden]`.
    pub h0: Vec<f32>,
    /// Of the cells before the first step, `[batch][hidden]`; empty for a GRU.
    pub c0: Vec<f32>,
    /// Of the input weights, in their layout.
    pub input: Vec<f32>,
    /// Of the hidden weights.
    pub hidden: Vec<f32>,
    /// Of the biases.
    pub bias: Vec<f32>,
}

/// Working memory of the backward pass; reused from call to call.
#[derive(Debug, Clone, Default)]
pub struct Work {
    /// Hidden weights, for the gradient of the state.
    to_state: Packed,
    /// Input weights, for the gradient of the input.
    to_input: Packed,
    /// Gradients of a block's gates.
    gates: Packed,
    /// Inputs of the gates.
    fed: Packed,
    input: Buffer,
    hidden: Buffer,
    bias: Buffer,
}

/// Inputs of [`backward`]: a layer, its input, and the tape of its forward pass.
#[derive(Debug)]
pub struct Pass<'a> {
    /// The weights.
    pub weights: Weights<'a>,
    /// The sizes.
    pub shape: Shape,
    /// The input, `[steps][batch][input]`.
    pub x: &'a [f32],
    /// Tape of the forward pass.
    pub tape: &'a Tape,
}

/// Destination of the gradient of the input, `[steps][batch][input]`.
#[derive(Debug)]
pub enum AtInput<'a> {
    /// Not computed.
    Nowhere,
    /// In the memory of the outputs' gradient, if an input is as wide as an output: it is in the
    /// cache already.
    OverOutputs,
    /// In this slice.
    Into(&'a mut [f32]),
}

/// Gradients of a layer's input and output.
#[derive(Debug)]
pub struct Ends<'a> {
    /// Of the outputs, `[steps][batch][hidden]`; the content after the call is unspecified.
    pub outputs: &'a mut [f32],
    /// Of the input; computed here.
    pub input: AtInput<'a>,
}

/// Gradients of a layer, given those of its outputs.
///
/// Processes blocks of steps backwards in time. The products of a block follow at once, while the
/// gradients of its gates are in the cache.
pub fn backward(level: Level, pass: &Pass<'_>, mut ends: Ends<'_>, work: &mut Work) -> Gradients {
    let &Pass { weights, shape, .. } = pass;
    let (n, features, kind) = (shape.hidden, shape.input, weights.kind);
    let cells = if kind == Kind::Lstm { shape.state() } else { 0 };
    let mut out = Gradients {
        h0: vec![0.0; shape.state()],
        c0: vec![0.0; cells],
        input: vec![0.0; weights.input.len()],
        hidden: vec![0.0; weights.hidden.len()],
        bias: vec![0.0; 4 * n],
    };
    let (input, hidden) = (kind.input_gates(), kind.hidden_gates());
    work.to_state.gate_rows(level, kind.gate_weights(weights.hidden, hidden.clone()), n, n);
    work.to_input.gate_rows(level, kind.gate_weights(weights.input, input.clone()), n, features);
    let columns = gate_columns(level, n);
    work.input.zeros(features * columns);
    work.hidden.zeros(n * columns);
    work.bias.zeros(columns);
    let together = ROWS.div_ceil(shape.batch.max(1));
    for block in (0..shape.steps.div_ceil(together)).rev() {
        let steps = block * together..((block + 1) * together).min(shape.steps);
        work.gates.reshape_gates(level, steps.len() * shape.batch, n);
        for step in steps.clone().rev() {
            step_back(level, pass, &mut ends, step, step - steps.start, work, &mut out);
        }
        block_products(level, pass, steps, work);
    }
    unpack(level, kind, &input, &work.input, n, &mut out.input);
    unpack(level, kind, &hidden, &work.hidden, n, &mut out.hidden);
    for (from, to) in kind.bias_blocks(level, n) {
        out.bias[to].copy_from_slice(&work.bias[from]);
    }
    out
}

/// One step back, the `index`-th of its block: computes the gradients of the gates' inputs and of
/// `x`, and moves `out`'s state from after to before the step.
fn step_back(
    level: Level,
    pass: &Pass<'_>,
    ends: &mut Ends<'_>,
    step: usize,
    index: usize,
    work: &mut Work,
    out: &mut Gradients,
) {
    let Shape { batch, hidden, input: features, .. } = pass.shape;
    let state = pass.shape.state();
    let (before, after) = (step * state..(step + 1) * state, (step + 1) * state..(step + 2) * state);
    let Tape { gates, outputs, cells, .. } = pass.tape;
    let gates = &gates[step * batch * work.bias.len()..][..batch * work.bias.len()];
    let rows = index * batch..(index + 1) * batch;
    let (d_output, d_bias, d_gates) = (&ends.outputs[before.clone()], &mut work.bias, &mut work.gates);
    let kind = pass.weights.kind;
    match kind {
        Kind::Lstm => level.run(LstmBackward {
            hidden,
            gates,
            cell_before: &cells[before.clone()],
            output: &outputs[after],
            d_output,
            d_gates,
            rows: rows.clone(),
            d_bias,
            d_hidden: &out.h0,
            d_cell: &mut out.c0,
        }),
        Kind::Gru => level.run(GruBackward {
            hidden,
            gates,
            output_before: &outputs[before.clone()],
            d_output,
            d_gates,
            rows: rows.clone(),
            d_bias,
            d_hidden: &mut out.h0,
        }),
    }
    level.run(Product::<_, 0, VECTORS> {
        a: Left::gates(&work.gates, rows.start, kind.hidden_gates()),
        m: batch,
        b: &work.to_state,
        finish: Store { c: &mut out.h0, columns: hidden, from: 0, add: kind == Kind::Gru },
    });
    let c = match &mut ends.input {
        AtInput::Nowhere => return,
        AtInput::OverOutputs => &mut ends.outputs[before],
        AtInput::Into(x) => &mut x[step * batch * features..][..batch * features],
    };
    level.run(Product::<_, 0, VECTORS> {
        a: Left::gates(&work.gates, rows.start, kind.input_gates()),
        m: batch,
        b: &work.to_input,
        finish: Store { c, columns: features, from: 0, add: false },
    });
}

/// Adds the contribution of a block of steps to the weights' gradients.
fn block_products(level: Level, pass: &Pass<'_>, steps: Range<usize>, work: &mut Work) {
    let (n, features, kind) = (pass.shape.hidden, pass.shape.input, pass.weights.kind);
    let rows = steps.start * pass.shape.batch..steps.end * pass.shape.batch;
    let columns = work.bias.len();
    let Work { gates, fed, input, hidden, .. } = work;
    let mut outer = |x: &[f32], m: usize, gates_fed: Range<usize>, sum: &mut [f32]| {
        fed.turned(x, m);
        let finish = Store { c: sum, columns, from: gates_fed.start * level.lanes(), add: true };
        fed_product(level, &gates_fed, Product { a: Left::Turned(fed), m, b: gates, finish });
    };
    outer(&pass.x[rows.start * features..rows.end * features], features, kind.input_gates(), input);
    outer(&pass.tape.outputs[rows.start * n..rows.end * n], n, kind.hidden_gates(), hidden);
}

/// Reorders a weight gradient, `[features]` rows of gates, into PyTorch's order.
fn unpack(level: Level, kind: Kind, fed: &Range<usize>, sums: &[f32], hidden: usize, out: &mut [f32]) {
    let (columns, lanes) = (gate_columns(level, hidden), level.lanes());
    let features = sums.len() / columns;
    for (gate, position) in kind.positions(fed) {
        for unit in (0..hidden).step_by(lanes) {
            let units = lanes.min(hidden - unit);
            let to = &mut out[(position * hidden + unit) * features..][..units * features];
            transpose(&sums[VECTORS * unit + gate * lanes..], columns, units, to);
        }
    }
}
