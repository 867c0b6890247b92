//! A layer over a sequence.

use super::{
    Kind, Shape, Weights,
    buffer::Buffer,
    cells::{GruForward, LstmForward},
    level::Level,
    product::{Left, Packed, Product, Store, fed_product, gate_columns},
};

/// Rows per input product: enough for efficiency, few enough to stay in the cache until their
/// steps.
const ROWS: usize = 128;

/// A layer's weights, packed for the forward products.
#[derive(Debug, Clone)]
pub struct PackedLayer {
    level: Level,
    kind: Kind,
    input: Packed,
    hidden: Packed,
    bias: Buffer,
    sizes: (usize, usize),
}

impl PackedLayer {
    /// Packs `weights` for a layer of `input` features and `hidden` units.
    #[must_use]
    pub fn new(level: Level, weights: &Weights<'_>, input: usize, hidden: usize) -> Self {
        let mut packed = Self {
            level,
            kind: weights.kind,
            input: Packed::default(),
            hidden: Packed::default(),
            bias: Buffer::default(),
            sizes: (input, hidden),
        };
        let kind = weights.kind;
        packed.input.gates(level, kind.gate_weights(weights.input, kind.input_gates()), hidden, input);
        packed.hidden.gates(level, kind.gate_weights(weights.hidden, kind.hidden_gates()), hidden, hidden);
        packed.bias.zeros(gate_columns(level, hidden));
        for (to, from) in kind.bias_blocks(level, hidden) {
            packed.bias[to].copy_from_slice(&weights.bias[from]);
        }
        packed
    }

    /// Input features and units.
    #[must_use]
    pub fn sizes(&self) -> (usize, usize) {
        self.sizes
    }
}

/// Tape of a forward pass for the backward pass; reused from call to call.
#[derive(Debug, Clone, Default)]
pub struct Tape {
    /// The gates' values, `[steps][batch]` rows of gates.
    pub(super) gates: Buffer,
    /// The outputs, preceded by the state before the first step, `[steps + 1][batch][hidden]`.
    pub(super) outputs: Buffer,
    /// The cells, in the same layout (LSTM).
    pub(super) cells: Buffer,
    /// Input products of the present steps.
    sums: Buffer,
    skip: usize,
}

impl Tape {
    /// The layer's outputs, `[steps][batch][hidden]`.
    #[must_use]
    pub fn outputs(&self) -> &[f32] {
        &self.outputs[self.skip..]
    }

    /// The output after the last step, `[batch][hidden]`.
    #[must_use]
    pub fn last_output(&self) -> &[f32] {
        &self.outputs[self.outputs.len() - self.skip..]
    }

    /// The cells after the last step, `[batch][hidden]`; empty for a GRU.
    #[must_use]
    pub fn last_cell(&self) -> &[f32] {
        &self.cells[self.cells.len().saturating_sub(self.skip)..]
    }
}

/// Runs a layer over `x` (`[steps][batch][input]`) from the state `h0`, `c0` (`[batch][hidden]`;
/// `c0` is empty for a GRU). `see` receives the outputs of every step, `[batch][hidden]`, while
/// they are in the cache.
pub fn forward(
    layer: &PackedLayer,
    shape: Shape,
    x: &[f32],
    h0: &[f32],
    c0: &[f32],
    tape: &mut Tape,
    mut see: impl FnMut(&[f32]),
) {
    let state = shape.state();
    let columns = layer.bias.len();
    let lstm = layer.kind == Kind::Lstm;
    tape.skip = state;
    tape.gates.resize(shape.rows() * columns);
    tape.outputs.resize((shape.steps + 1) * state);
    tape.outputs[..state].copy_from_slice(h0);
    tape.cells.resize(if lstm { (shape.steps + 1) * state } else { 0 });
    if lstm {
        tape.cells[..state].copy_from_slice(c0);
    }
    let together = ROWS.div_ceil(shape.batch.max(1)).max(1);
    for first in (0..shape.steps).step_by(together) {
        let last = (first + together).min(shape.steps);
        let rows = first * shape.batch..last * shape.batch;
        // The products of a few steps stay in the cache until their steps.
        tape.sums.resize(rows.len() * columns);
        let a = Left::matrix(&x[rows.start * shape.input..rows.end * shape.input], shape.input);
        let finish = Store { c: &mut tape.sums, columns, from: 0, add: false };
        fed_product(layer.level, &layer.kind.input_gates(), Product { a, m: rows.len(), b: &layer.input, finish });
        for step in first..last {
            advance(layer, shape, step, step - first, tape);
            see(&tape.outputs[(step + 1) * state..(step + 2) * state]);
        }
    }
}

/// One time step, the `index`-th of those whose input products are in `tape.sums`: the hidden
/// product, then the cell.
fn advance(layer: &PackedLayer, shape: Shape, step: usize, index: usize, tape: &mut Tape) {
    let Shape { batch, hidden, .. } = shape;
    let (state, columns, bias) = (shape.state(), layer.bias.len(), &layer.bias);
    let row = batch * columns;
    let sums = &tape.sums[index * row..(index + 1) * row];
    let gates = &mut tape.gates[step * row..(step + 1) * row];
    let (output_before, output) = tape.outputs[step * state..(step + 2) * state].split_at_mut(state);
    let (a, b) = (Left::matrix(output_before, hidden), &layer.hidden);
    match layer.kind {
        Kind::Lstm => {
            let (cell_before, cell) = tape.cells[step * state..(step + 2) * state].split_at_mut(state);
            let finish = LstmForward { hidden, columns, bias, sums, gates, cell_before, cell, output };
            layer.level.run(Product::<_, 0, 4> { a, m: batch, b, finish });
        }
        Kind::Gru => {
            let finish = GruForward { hidden, columns, bias, sums, gates, output_before, output };
            layer.level.run(Product::<_, 1, 3> { a, m: batch, b, finish });
        }
    }
}
