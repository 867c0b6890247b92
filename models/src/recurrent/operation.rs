//! A layer over a sequence as one burn operation with its own backward pass.

#![cfg_attr(feature = "ndarray", allow(deprecated))] // Upstream deprecates that backend; who asks for the feature wants it.

use std::{
    mem::take,
    ops::Deref,
    sync::{Arc, Mutex},
};

use burn::backend::{
    Autodiff, Backend, Dispatch, Flex, TensorData, TensorMetadata,
    autodiff::{
        checkpoint::{base::Checkpointer, strategy::CheckpointStrategy},
        grads::Gradients as Grads,
        ops::{Backward, Ops, OpsKind},
    },
    backend_extension,
    tensor::FloatTensor,
    try_read_sync,
};
use burn::tensor::Tensor;

use super::{
    Kind,
    kernel::{self, AtInput, Ends, Level, PackedLayer, Pass, Shape, Tape, Weights, Work},
};
use crate::memory::keep_memory;

/// Backend requirements of the recurrent layers; call them by [`lstm`] and [`gru`].
#[backend_extension(Flex, NdArray: cfg(feature = "ndarray"), Autodiff)]
pub trait RecurrentOps: Backend {
    /// See [`lstm`].
    fn lstm_layer(
        x: FloatTensor<Self>,
        weight_ih: FloatTensor<Self>,
        weight_hh: FloatTensor<Self>,
        bias: FloatTensor<Self>,
        h0: FloatTensor<Self>,
        c0: FloatTensor<Self>,
    ) -> FloatTensor<Self> {
        run::<Self, 6>(Kind::Lstm, [x, weight_ih, weight_hh, bias, h0, c0]).1
    }

    /// See [`gru`].
    fn gru_layer(
        x: FloatTensor<Self>,
        weight_ih: FloatTensor<Self>,
        weight_hh: FloatTensor<Self>,
        bias: FloatTensor<Self>,
        h0: FloatTensor<Self>,
    ) -> FloatTensor<Self> {
        run::<Self, 5>(Kind::Gru, [x, weight_ih, weight_hh, bias, h0]).1
    }
}

/// An LSTM layer over a sequence: the outputs `h` of all steps, `[steps, batch, hidden]`.
///
/// `x` is `[steps, batch, input]`; `weight_ih` `[4·hidden, input]`, `weight_hh` `[4·hidden, hidden]` and `bias` `[4·hidden]`
/// (`b_ih + b_hh`) have their gates in the order `i f g o`; `h0` and `c0`, `[batch, hidden]`, are the state before the first step,
/// zero if not given. Gradients reach all of them. Values are computed in single precision.
///
/// # Panics
/// When the shapes do not match, as in burn's own operations.
#[must_use]
pub fn lstm(
    x: Tensor<3>,
    weight_ih: Tensor<2>,
    weight_hh: Tensor<2>,
    bias: Tensor<1>,
    h0: Option<Tensor<2>>,
    c0: Option<Tensor<2>>,
) -> Tensor<3> {
    let zeros = zero_state(&x, &weight_hh);
    Tensor::from_dispatch(<Dispatch as RecurrentOps>::lstm_layer(
        x.into_dispatch(),
        weight_ih.into_dispatch(),
        weight_hh.into_dispatch(),
        bias.into_dispatch(),
        h0.unwrap_or_else(|| zeros.clone()).into_dispatch(),
        c0.unwrap_or(zeros).into_dispatch(),
    ))
}

/// A GRU layer over a sequence: the outputs `h` of all steps, `[steps, batch, hidden]`.
///
/// As [`lstm`], with gates `r z n`: `weight_ih` `[3·hidden, input]`, `weight_hh` `[3·hidden, hidden]`, `bias` `[4·hidden]`: the sums
/// for `r` and `z`, then `b_in`, then `b_hn`.
///
/// # Panics
/// When the shapes do not match, as in burn's own operations.
#[must_use]
pub fn gru(x: Tensor<3>, weight_ih: Tensor<2>, weight_hh: Tensor<2>, bias: Tensor<1>, h0: Option<Tensor<2>>) -> Tensor<3> {
    let zeros = zero_state(&x, &weight_hh);
    Tensor::from_dispatch(<Dispatch as RecurrentOps>::gru_layer(
        x.into_dispatch(),
        weight_ih.into_dispatch(),
        weight_hh.into_dispatch(),
        bias.into_dispatch(),
        h0.unwrap_or(zeros).into_dispatch(),
    ))
}

/// A state of zeros for a batch like `x`'s.
fn zero_state(x: &Tensor<3>, weight_hh: &Tensor<2>) -> Tensor<2> {
    let [_, batch, _] = x.dims();
    let [_, hidden] = weight_hh.dims();
    Tensor::zeros([batch, hidden], &x.device())
}

impl RecurrentOps for Flex {}

#[cfg(feature = "ndarray")]
impl RecurrentOps for burn::backend::NdArray {}

impl<B: Backend, C: CheckpointStrategy> RecurrentOps for Autodiff<B, C> {
    fn lstm_layer(
        x: FloatTensor<Self>,
        weight_ih: FloatTensor<Self>,
        weight_hh: FloatTensor<Self>,
        bias: FloatTensor<Self>,
        h0: FloatTensor<Self>,
        c0: FloatTensor<Self>,
    ) -> FloatTensor<Self> {
        record::<B, C, 6>(Kind::Lstm, [x, weight_ih, weight_hh, bias, h0, c0])
    }

    fn gru_layer(
        x: FloatTensor<Self>,
        weight_ih: FloatTensor<Self>,
        weight_hh: FloatTensor<Self>,
        bias: FloatTensor<Self>,
        h0: FloatTensor<Self>,
    ) -> FloatTensor<Self> {
        record::<B, C, 5>(Kind::Gru, [x, weight_ih, weight_hh, bias, h0])
    }
}

/// Tape of the backward pass.
#[derive(Debug, Clone)]
struct Saved<B: Backend> {
    shape: Shape,
    x: Values,
    weight_ih: Values,
    weight_hh: Values,
    bias: Values,
    memory: Memory,
    device: B::Device,
}

/// Large buffers of a layer's passes, from a shared pool, so that the system does not map and clear
/// them anew for each layer and step.
#[derive(Debug, Clone, Default)]
struct Memory {
    tape: Tape,
    work: Work,
}

/// Free buffers.
static STORE: Mutex<Vec<Memory>> = Mutex::new(Vec::new());
/// Maximum number of free buffers; more are released.
const STORED: usize = 8;

impl Memory {
    /// A free buffer, if any.
    fn take() -> Self {
        keep_memory();
        STORE.lock().ok().and_then(|mut store| store.pop()).unwrap_or_default()
    }
}

impl Drop for Memory {
    fn drop(&mut self) {
        if let Ok(mut store) = STORE.lock()
            && store.len() < STORED
        {
            let (tape, work) = (take(&mut self.tape), take(&mut self.work));
            store.push(Self { tape, work });
        }
    }
}

/// A layer's backward step, for inputs `x`, the three weights, and the state's one or two parts.
#[derive(Debug)]
struct Layer(Kind);

/// Runs a layer forward: what its backward pass needs, and the outputs.
fn run<B: Backend, const N: usize>(kind: Kind, inputs: [FloatTensor<B>; N]) -> (Saved<B>, FloatTensor<B>) {
    let device = inputs[0].device();
    let mut shapes = inputs.iter().map(|input| input.shape().to_vec());
    let (x, weight) = (shapes.next().unwrap_or_default(), shapes.nth(1).unwrap_or_default());
    let shape = Shape { steps: x[0], batch: x[1], input: x[2], hidden: weight[1] };
    let mut values = inputs.into_iter().map(values::<B>);
    let mut next = |what: &str, len: usize| {
        let found = values.next().unwrap_or_default();
        assert_eq!(found.len(), len, "recurrent layer: {what} does not fit {shape:?}");
        found
    };
    let rows = kind.gates() * shape.hidden;
    let x = next("x", shape.rows() * shape.input);
    let weight_ih = next("weight_ih", rows * shape.input);
    let weight_hh = next("weight_hh", rows * shape.hidden);
    let bias = next("bias", 4 * shape.hidden);
    let h0 = next("h0", shape.state());
    let c0 = next("c0", if N > 5 { shape.state() } else { 0 });
    let weights = Weights { kind, input: &weight_ih, hidden: &weight_hh, bias: &bias };
    let layer = PackedLayer::new(Level::detect(), &weights, shape.input, shape.hidden);
    let mut memory = Memory::take();
    let mut outputs = Vec::with_capacity(shape.steps * shape.state());
    kernel::forward(&layer, shape, &x, &h0, &c0, &mut memory.tape, |output| outputs.extend_from_slice(output));
    let output = TensorData::new(outputs, [shape.steps, shape.batch, shape.hidden]);
    let output = B::float_from_data(output, &device);
    let saved = Saved { shape, x, weight_ih, weight_hh, bias, memory, device };
    (saved, output)
}

/// Runs a layer forward and records it for autodiff if any input is tracked.
fn record<B: Backend, C: CheckpointStrategy, const N: usize>(
    kind: Kind,
    inputs: [FloatTensor<Autodiff<B, C>>; N],
) -> FloatTensor<Autodiff<B, C>> {
    let nodes = inputs.each_ref().map(|input| input.node());
    let prepared = Layer(kind).prepare::<C>(nodes).compute_bound().stateful();
    let (saved, output) = run::<B, N>(kind, inputs.map(|input| input.into_primitive()));
    match prepared {
        OpsKind::Tracked(prepared) => prepared.finish(Arc::new(saved), output),
        OpsKind::UnTracked(prepared) => prepared.finish(output),
    }
}

impl<B: Backend, const N: usize> Backward<B, N> for Layer {
    type State = Arc<Saved<B>>;

    fn backward(self, ops: Ops<Self::State, N>, grads: &mut Grads, _: &mut Checkpointer) {
        let mut d_output = values::<B>(grads.consume::<B>(&ops.node));
        let Saved { shape, x, weight_ih, weight_hh, bias, mut memory, device } = Arc::unwrap_or_clone(ops.state);
        let weights = Weights { kind: self.0, input: &weight_ih, hidden: &weight_hh, bias: &bias };
        let pass = Pass { weights, shape, x: &x, tape: &memory.tape };
        // An input as wide as an output gets its gradient in the memory of the output's gradient.
        let size = [shape.steps, shape.batch, shape.input];
        let wanted = ops.parents[0].is_some();
        let over = wanted && shape.input == shape.hidden;
        let mut d_x = (wanted && !over).then(|| vec![0.0; x.len()]);
        let input = match &mut d_x {
            Some(d_x) => AtInput::Into(d_x),
            None if over => AtInput::OverOutputs,
            None => AtInput::Nowhere,
        };
        let ends = Ends { outputs: d_output.as_mut(), input };
        let made = kernel::backward(Level::detect(), &pass, ends, &mut memory.work);
        let d_x = if over { d_output.0 } else { d_x.map(|d_x| TensorData::new(d_x, size)) };
        let rows = self.0.gates() * shape.hidden;
        let parts: [Option<TensorData>; 6] = [
            d_x,
            Some(TensorData::new(made.input, [rows, shape.input])),
            Some(TensorData::new(made.hidden, [rows, shape.hidden])),
            Some(TensorData::new(made.bias, [4 * shape.hidden])),
            Some(TensorData::new(made.h0, [shape.batch, shape.hidden])),
            (self.0 == Kind::Lstm).then(|| TensorData::new(made.c0, [shape.batch, shape.hidden])),
        ];
        for (parent, data) in ops.parents.into_iter().zip(parts) {
            if let (Some(parent), Some(data)) = (parent, data) {
                grads.register::<B>(parent.id, B::float_from_data(data, &device));
            }
        }
    }
}

/// A tensor's values in row-major order; none if the backend fails to give them.
fn values<B: Backend>(tensor: FloatTensor<B>) -> Values {
    Values(try_read_sync(B::float_into_data(tensor)).and_then(Result::ok).map(|data| data.convert::<f32>()))
}

/// Values in the memory of the backend: a vector of their own would often need a copy.
#[derive(Debug, Clone, Default)]
struct Values(Option<TensorData>);

impl Values {
    /// The values, to change.
    fn as_mut(&mut self) -> &mut [f32] {
        self.0.as_mut().and_then(|data| data.as_mut_slice().ok()).unwrap_or_default()
    }
}

impl Deref for Values {
    type Target = [f32];
    fn deref(&self) -> &[f32] {
        self.0.as_ref().and_then(|data| data.as_slice().ok()).unwrap_or_default()
    }
}
