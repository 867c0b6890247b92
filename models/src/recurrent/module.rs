//! A stack of recurrent layers to train.

use burn::module::{Module, Param};
use burn::nn::Linear;
use burn::tensor::{Device, Tensor, TensorData};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::layer::{check_stack, malformed};
use super::{Kind, LayerWeights, gru, init, lstm};
use crate::ModelError;

/// Sizes of a [`FusedRecurrent`].
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecurrentConfig {
    /// LSTM or GRU.
    pub kind: Kind,
    /// Features of an input.
    pub input: usize,
    /// Units of each layer.
    pub hidden: usize,
    /// Layers, each fed by the one before.
    pub layers: usize,
    /// Share of the features between layers that a training step drops, in `[0, 1)`.
    pub dropout: f64,
    /// Bias of an LSTM's forget gates at the start; `None` draws it like the others.
    pub forget_bias: Option<f32>,
}

impl RecurrentConfig {
    /// A stack with random weights, `±1/√hidden`.
    ///
    /// # Errors
    /// When a size is zero or the dropout is outside `[0, 1)`.
    pub fn init(&self, rng: &mut ChaCha8Rng, device: &Device) -> Result<FusedRecurrent, ModelError> {
        let sizes = std::iter::once(self.input).chain(std::iter::repeat(self.hidden));
        let layers: Vec<LayerWeights> =
            sizes.take(self.layers).map(|input| init::draw(self.kind, input, self.hidden, self.forget_bias, rng)).collect();
        FusedRecurrent::from_layers(&layers, self.dropout, device)
    }
}

/// Recurrent layers one after the other; a linear head, if there is one, is the caller's.
#[derive(Module, Debug)]
pub struct FusedRecurrent {
    /// The layers.
    pub layers: Vec<FusedLayer>,
    dropout: f64,
}

/// One layer's weights as burn parameters, shapes as in [`lstm`] and [`gru`].
#[derive(Module, Debug)]
pub struct FusedLayer {
    /// Input weights, `[gates·hidden, input]`.
    pub weight_ih: Param<Tensor<2>>,
    /// Hidden weights, `[gates·hidden, hidden]`.
    pub weight_hh: Param<Tensor<2>>,
    /// Biases, `[4·hidden]`.
    pub bias: Param<Tensor<1>>,
}

impl FusedLayer {
    /// LSTM or GRU: their weights have different heights.
    #[must_use]
    pub fn kind(&self) -> Kind {
        let [rows, hidden] = self.weight_hh.val().dims();
        if rows == 3 * hidden { Kind::Gru } else { Kind::Lstm }
    }

    /// The layer's outputs over `x`, time-major: `[steps, batch, input]` to `[steps, batch, hidden]`, from a state of zeros.
    #[must_use]
    pub fn forward(&self, x: Tensor<3>) -> Tensor<3> {
        let (ih, hh, bias) = (self.weight_ih.val(), self.weight_hh.val(), self.bias.val());
        match self.kind() {
            Kind::Lstm => lstm(x, ih, hh, bias, None, None),
            Kind::Gru => gru(x, ih, hh, bias, None),
        }
    }

    /// The weights as plain numbers.
    ///
    /// # Errors
    /// When the device does not give them.
    pub fn weights(&self) -> Result<LayerWeights, ModelError> {
        let [_, hidden] = self.weight_hh.val().dims();
        let [_, input] = self.weight_ih.val().dims();
        let layer = LayerWeights {
            kind: self.kind(),
            input,
            hidden,
            weight_ih: read(self.weight_ih.val().into_data())?,
            weight_hh: read(self.weight_hh.val().into_data())?,
            bias: read(self.bias.val().into_data())?,
        };
        layer.check()?;
        Ok(layer)
    }
}

/// A tensor's values.
pub(super) fn read(data: TensorData) -> Result<Vec<f32>, ModelError> {
    data.convert::<f32>().try_into_vec::<f32>().map_err(|error| malformed(format!("weights cannot be read: {error:?}")))
}

impl FusedRecurrent {
    /// A stack with given weights.
    ///
    /// # Errors
    /// When a layer is malformed, does not fit the one before, there is none, or the dropout is outside `[0, 1)`.
    pub fn from_layers(layers: &[LayerWeights], dropout: f64, device: &Device) -> Result<Self, ModelError> {
        check_stack(layers)?;
        if !(0.0..1.0).contains(&dropout) {
            return Err(malformed(format!("a dropout of {dropout} is not in [0, 1)")));
        }
        let tensor = |values: &[f32], rows: usize| TensorData::new(values.to_vec(), [rows, values.len() / rows.max(1)]);
        let layers = layers.iter().map(|layer| {
            let rows = layer.kind.gates() * layer.hidden;
            let bias = TensorData::new(layer.bias.clone(), [layer.bias.len()]);
            FusedLayer {
                weight_ih: Param::from_data(tensor(&layer.weight_ih, rows), device),
                weight_hh: Param::from_data(tensor(&layer.weight_hh, rows), device),
                bias: Param::from_data(bias, device),
            }
        });
        Ok(Self { layers: layers.collect(), dropout })
    }

    /// The last layer's outputs over `x`, batch first: `[batch, steps, input]` to `[batch, steps, hidden]`, from a state of zeros.
    #[must_use]
    pub fn forward(&self, x: Tensor<3>) -> Tensor<3> {
        self.time_major(x, |x| x).swap_dims(0, 1)
    }

    /// What `head` makes of the last layer's outputs, batch first: `[batch, steps, input]` to `[batch, steps, outputs]`. The head takes
    /// the outputs as the layers leave them, so that only its own few are turned to batch first.
    #[must_use]
    pub fn forward_to(&self, head: &Linear, x: Tensor<3>) -> Tensor<3> {
        head.forward(self.time_major(x, |x| x)).swap_dims(0, 1)
    }

    /// As [`Self::forward_to`], with dropout between the layers, drawn from `rng`: for training steps.
    #[must_use]
    pub fn forward_training(&self, head: &Linear, x: Tensor<3>, rng: &mut ChaCha8Rng) -> Tensor<3> {
        if self.dropout == 0.0 {
            return self.forward_to(head, x);
        }
        let keep = 1.0 - self.dropout;
        let outputs = self.time_major(x, |x| {
            let shape = x.shape();
            let mask = (0..shape.num_elements()).map(|_| if rng.random_bool(keep) { (1.0 / keep) as f32 } else { 0.0 });
            let mask = TensorData::new(mask.collect::<Vec<f32>>(), shape);
            let mask = Tensor::from_data(mask, &x.device());
            x * mask
        });
        head.forward(outputs).swap_dims(0, 1)
    }

    /// All layers in turn, `between` applied between them: `[batch, steps, input]` to `[steps, batch, hidden]`.
    fn time_major(&self, x: Tensor<3>, mut between: impl FnMut(Tensor<3>) -> Tensor<3>) -> Tensor<3> {
        let mut x = x.swap_dims(0, 1);
        for (index, layer) in self.layers.iter().enumerate() {
            if index > 0 {
                x = between(x);
            }
            x = layer.forward(x);
        }
        x
    }

    /// The layers' weights as plain numbers.
    ///
    /// # Errors
    /// When the device does not give them.
    pub fn weights(&self) -> Result<Vec<LayerWeights>, ModelError> {
        self.layers.iter().map(FusedLayer::weights).collect()
    }
}
