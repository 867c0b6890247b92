//! A layer over a sequence.

use super::{
    Kind, Shape, Weights,
    buffer::Buffer,
    cells::{GruForward, LstmForward},
    level::Level,
    product::{Left, Packed, Product},
};

/// Rows whose input product is made at once: many enough to be efficient, few enough to be in the cache when their steps come.
const ROWS: usize = 128;

/// A layer's weights, packed for the forward products.
#[derive(Debug, Clone)]
pub struct PackedLayer {
    level: Level,
    kind: Kind,
    input: Packed,
    hidden: Packed,
    bias: Vec<f32>,
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
            bias: vec![0.0; weights.bias.len()],
            sizes: (input, hidden),
        };
        let parts = weights.kind.input_parts(weights.input);
        packed.input.transposed(level, &parts, input);
        packed.hidden.transposed(level, &[weights.hidden], hidden);
        weights.kind.reorder_bias(weights.bias, &mut packed.bias, false);
        packed
    }

    /// Input features and units.
    #[must_use]
    pub fn sizes(&self) -> (usize, usize) {
        self.sizes
    }
}

/// What a forward pass leaves behind for the backward pass; reused from call to call.
#[derive(Debug, Clone, Default)]
pub struct Tape {
    /// The gates' values, `[steps][batch][4·hidden]`.
    pub(super) gates: Buffer,
    /// The outputs, with the state before the first step in front, `[steps + 1][batch][hidden]`.
    pub(super) outputs: Buffer,
    /// The cells, likewise (LSTM).
    pub(super) cells: Buffer,
    /// Products of the steps at hand.
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

/// Runs a layer over `x` (`[steps][batch][input]`) from the state `h0`, `c0` (`[batch][hidden]`; `c0` is empty for a GRU).
pub fn forward(layer: &PackedLayer, shape: Shape, x: &[f32], h0: &[f32], c0: &[f32], tape: &mut Tape) {
    let n = shape.hidden;
    let state = shape.state();
    let width = 4 * n;
    let lstm = layer.kind == Kind::Lstm;
    tape.skip = state;
    tape.gates.resize(shape.rows() * width);
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
        // The products of a few steps meet in the cache; only the gates' values go to the large tape.
        tape.sums.resize(rows.len() * width);
        if layer.kind == Kind::Gru {
            // The input does not feed `q`.
            for row in tape.sums.chunks_exact_mut(width) {
                row[3 * n..].fill(0.0);
            }
        }
        layer.level.run(Product {
            a: Left::Rows(&x[rows.start * shape.input..rows.end * shape.input], shape.input),
            m: rows.len(),
            b: &layer.input,
            c: &mut tape.sums,
            c_stride: width,
            add: false,
        });
        for step in first..last {
            advance(layer, shape, step, step - first, tape);
        }
    }
}

/// One time step, the `index`-th of those whose input products are in `tape.sums`: the hidden product, then the cell.
fn advance(layer: &PackedLayer, shape: Shape, step: usize, index: usize, tape: &mut Tape) {
    let n = shape.hidden;
    let state = shape.state();
    let sums = &mut tape.sums[index * 4 * state..(index + 1) * 4 * state];
    let gates = &mut tape.gates[step * 4 * state..(step + 1) * 4 * state];
    let (before, output) = tape.outputs[step * state..(step + 2) * state].split_at_mut(state);
    layer.level.run(Product {
        a: Left::Rows(before, n),
        m: shape.batch,
        b: &layer.hidden,
        c: &mut sums[layer.kind.hidden_column(n)..],
        c_stride: 4 * n,
        add: true,
    });
    let bias = &layer.bias;
    match layer.kind {
        Kind::Lstm => {
            let (cell_before, cell) = tape.cells[step * state..(step + 2) * state].split_at_mut(state);
            layer.level.run(LstmForward { hidden: n, bias, sums, gates, cell_before, cell, output });
        }
        Kind::Gru => layer.level.run(GruForward { hidden: n, bias, sums, gates, output_before: before, output }),
    }
}
