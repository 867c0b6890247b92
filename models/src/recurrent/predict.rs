//! Prediction with plain weights: no tensors, no autodiff.

use std::collections::HashMap;

use burn::nn::Linear;

use super::{
    FusedRecurrent, Head, Kind, LayerWeights, Level, NamedTensor,
    kernel::{PackedLayer, Shape, Tape, forward},
    layer::{check_stack, malformed},
    module::read,
};
use crate::ModelError;

/// Rows (steps × sequences) that go through all layers before the next ones do: they stay in the cache.
const ROWS: usize = 256;
/// Chunks of a long sequence that are predicted side by side.
const SIDE_BY_SIDE: usize = 32;

/// A stack of recurrent layers with a linear head, ready to predict. Cheap to share: predicting does not change it.
#[derive(Debug, Clone)]
pub struct Recurrent {
    layers: Vec<LayerWeights>,
    head: Head,
    packed: Vec<PackedLayer>,
}

/// State of the layers between two calls, for a number of parallel sequences.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// Outputs of each layer, `[batch][hidden]`.
    pub outputs: Vec<Vec<f32>>,
    /// Cells of each layer; empty for a GRU.
    pub cells: Vec<Vec<f32>>,
    batch: usize,
}

impl Recurrent {
    /// A network from its weights, for the fastest instructions of this machine.
    ///
    /// # Errors
    /// When there is no layer, or parts do not fit each other.
    pub fn new(layers: Vec<LayerWeights>, head: Head) -> Result<Self, ModelError> {
        Self::with_level(layers, head, Level::detect())
    }

    /// A network from its weights, for given instructions.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_level(layers: Vec<LayerWeights>, head: Head, level: Level) -> Result<Self, ModelError> {
        check_stack(&layers)?;
        let hidden = layers.last().map_or(0, |layer| layer.hidden);
        if head.outputs == 0 || head.bias.len() != head.outputs || head.weight.len() != head.outputs * hidden {
            return Err(malformed(format!(
                "a head of {} outputs on {hidden} units has {} weights and {} biases",
                head.outputs,
                head.weight.len(),
                head.bias.len()
            )));
        }
        let packed = layers.iter().map(|layer| PackedLayer::new(level, &layer.weights(), layer.input, layer.hidden)).collect();
        Ok(Self { layers, head, packed })
    }

    /// A network from a trained stack and its linear head.
    ///
    /// # Errors
    /// When they do not fit each other or cannot be read.
    pub fn from_module(stack: &FusedRecurrent, head: &Linear) -> Result<Self, ModelError> {
        let weight = head.weight.val();
        let [_, outputs] = weight.dims();
        let bias = match &head.bias {
            Some(bias) => read(bias.val().into_data())?,
            None => vec![0.0; outputs],
        };
        let head = Head { outputs, weight: read(weight.transpose().into_data())?, bias };
        Self::new(stack.weights()?, head)
    }

    /// All weights by name: `layers.{i}.weight_ih`, `.weight_hh`, `.bias`, `head.weight` (`[outputs, hidden]`), `head.bias`.
    #[must_use]
    pub fn to_tensors(&self) -> Vec<NamedTensor> {
        let layers = self.layers.iter().enumerate();
        let mut tensors: Vec<NamedTensor> = layers.flat_map(|(i, layer)| layer.named(i)).collect();
        let outputs = self.head.outputs;
        let hidden = self.head.weight.len() / outputs;
        tensors.push(("head.weight".to_owned(), vec![outputs, hidden], self.head.weight.clone()));
        tensors.push(("head.bias".to_owned(), vec![outputs], self.head.bias.clone()));
        tensors
    }

    /// The inverse of [`Self::to_tensors`]; the sizes come from the shapes.
    ///
    /// # Errors
    /// When a tensor is missing or has the wrong shape.
    pub fn from_tensors(kind: Kind, tensors: Vec<NamedTensor>) -> Result<Self, ModelError> {
        let mut tensors: HashMap<String, (Vec<usize>, Vec<f32>)> =
            tensors.into_iter().map(|(name, shape, values)| (name, (shape, values))).collect();
        let mut layers = Vec::new();
        while tensors.contains_key(&format!("layers.{}.weight_ih", layers.len())) {
            let index = layers.len();
            let (_, input, weight_ih) = matrix(&mut tensors, &format!("layers.{index}.weight_ih"))?;
            let (_, hidden, weight_hh) = matrix(&mut tensors, &format!("layers.{index}.weight_hh"))?;
            let (_, _, bias) = matrix(&mut tensors, &format!("layers.{index}.bias"))?;
            layers.push(LayerWeights { kind, input, hidden, weight_ih, weight_hh, bias });
        }
        let (outputs, _, weight) = matrix(&mut tensors, "head.weight")?;
        let (_, _, bias) = matrix(&mut tensors, "head.bias")?;
        if let Some(name) = tensors.keys().next() {
            return Err(malformed(format!("`{name}` is not one of its tensors")));
        }
        Self::new(layers, Head { outputs, weight, bias })
    }

    /// The layers' weights.
    #[must_use]
    pub fn layers(&self) -> &[LayerWeights] {
        &self.layers
    }

    /// The head.
    #[must_use]
    pub fn head(&self) -> &Head {
        &self.head
    }

    /// Features of an input.
    #[must_use]
    pub fn inputs(&self) -> usize {
        self.layers.first().map_or(0, |layer| layer.input)
    }

    /// Outputs a step.
    #[must_use]
    pub fn outputs(&self) -> usize {
        self.head.outputs
    }

    /// The state of `batch` sequences before their first step: zeros.
    #[must_use]
    pub fn zero_state(&self, batch: usize) -> State {
        let zeros = |layer: &LayerWeights| vec![0.0; batch * layer.hidden];
        let cells = |layer: &LayerWeights| match layer.kind {
            Kind::Lstm => zeros(layer),
            Kind::Gru => Vec::new(),
        };
        State { outputs: self.layers.iter().map(zeros).collect(), cells: self.layers.iter().map(cells).collect(), batch }
    }

    /// Outputs for the next steps of the state's sequences: `inputs` is `[steps][batch][inputs]`, what comes back
    /// `[steps][batch][outputs]`; for one sequence simply one row a step. The state moves on: the same steps in one call
    /// or in many give the same outputs but for rounding.
    ///
    /// # Errors
    /// When `inputs` is not whole steps or the state is not this network's.
    pub fn predict(&self, inputs: &[f32], state: &mut State) -> Result<Vec<f32>, ModelError> {
        self.check_state(state)?;
        let row = self.inputs() * state.batch;
        if !inputs.len().is_multiple_of(row) {
            return Err(ModelError::Misfit(format!("{} numbers are not whole steps of {row}", inputs.len())));
        }
        let mut outputs = Vec::with_capacity(inputs.len() / self.inputs() * self.outputs());
        let mut tapes = [Tape::default(), Tape::default()];
        for block in inputs.chunks(row * ROWS.div_ceil(state.batch)) {
            for (index, packed) in self.packed.iter().enumerate() {
                let (input, hidden) = packed.sizes();
                let shape = Shape { steps: block.len() / row, batch: state.batch, input, hidden };
                let [before, tape] = &mut tapes;
                let x = if index == 0 { block } else { before.outputs() };
                let (h, c) = (&mut state.outputs[index], &mut state.cells[index]);
                forward(packed, shape, x, h, c, tape, |_| ());
                h.copy_from_slice(tape.last_output());
                c.copy_from_slice(tape.last_cell());
                tapes.swap(0, 1);
            }
            let hidden = self.head.weight.len() / self.outputs();
            self.head.apply(tapes[0].outputs(), hidden, &mut outputs);
        }
        Ok(outputs)
    }

    /// Whether a state has this network's sizes.
    fn check_state(&self, state: &State) -> Result<(), ModelError> {
        let zero = |vectors: &[Vec<f32>]| vectors.iter().map(Vec::len).collect::<Vec<_>>();
        let wanted = self.zero_state(state.batch);
        if state.batch == 0 || zero(&wanted.outputs) != zero(&state.outputs) || zero(&wanted.cells) != zero(&state.cells) {
            return Err(ModelError::Misfit("the state is another network's".to_owned()));
        }
        Ok(())
    }

    /// Outputs for one long sequence (`[steps][inputs]`) from a state of zeros, faster than [`Self::predict`]: the
    /// sequence is cut into chunks of `chunk` steps that run side by side, each of them started `warmup` steps early from zeros.
    /// What the network remembers for longer than `warmup` steps is lost at the cuts, so that the outputs are close to
    /// [`Self::predict`]'s but not equal; the first `warmup + chunk` of them are exact but for rounding.
    ///
    /// # Errors
    /// When `inputs` is not whole steps or `chunk` is zero.
    pub fn predict_chunked(&self, inputs: &[f32], chunk: usize, warmup: usize) -> Result<Vec<f32>, ModelError> {
        let (width, outputs) = (self.inputs(), self.outputs());
        if chunk == 0 || !inputs.len().is_multiple_of(width) {
            return Err(ModelError::Misfit(format!(
                "{} numbers are not whole steps of {width}, or the chunk of {chunk} steps is empty",
                inputs.len()
            )));
        }
        let steps = inputs.len() / width;
        let mut all = Vec::with_capacity(steps * outputs);
        let starts: Vec<usize> = (0..steps).step_by(chunk).collect();
        for starts in starts.chunks(SIDE_BY_SIDE) {
            let batch = starts.len();
            let early = |start: usize| start.saturating_sub(warmup);
            let length = starts.iter().map(|&s| (s + chunk).min(steps) - early(s)).max().unwrap_or(0);
            let mut side_by_side = vec![0.0; length * batch * width];
            for (lane, &start) in starts.iter().enumerate() {
                let own = &inputs[early(start) * width..(start + chunk).min(steps) * width];
                let rows = side_by_side.chunks_exact_mut(width).skip(lane).step_by(batch);
                for (row, own) in rows.zip(own.chunks_exact(width)) {
                    row.copy_from_slice(own);
                }
            }
            let made = self.predict(&side_by_side, &mut self.zero_state(batch))?;
            for (lane, &start) in starts.iter().enumerate() {
                let count = chunk.min(steps - start);
                let rows = made.chunks_exact(outputs).skip(lane).step_by(batch);
                for row in rows.skip(start - early(start)).take(count) {
                    all.extend_from_slice(row);
                }
            }
        }
        Ok(all)
    }
}

/// Takes a tensor out: rows, columns (of a vector: its length and one), values.
fn matrix(tensors: &mut HashMap<String, (Vec<usize>, Vec<f32>)>, name: &str) -> Result<(usize, usize, Vec<f32>), ModelError> {
    let (shape, values) = tensors.remove(name).ok_or_else(|| malformed(format!("tensor `{name}` is missing")))?;
    match shape[..] {
        [rows] if rows == values.len() => Ok((rows, 1, values)),
        [rows, columns] if rows.checked_mul(columns) == Some(values.len()) => Ok((rows, columns, values)),
        _ => Err(malformed(format!("tensor `{name}` has shape {shape:?} and {} values", values.len()))),
    }
}
