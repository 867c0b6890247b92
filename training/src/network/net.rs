//! The networks as burn modules.

use burn::module::{Module, Param};
use burn::nn::{Linear, LinearConfig};
use burn::tensor::{Device, Tensor, TensorData};
use models::narx::{Dense, PAST_ERRORS};
use models::recurrent::{FusedRecurrent, Recurrent, RecurrentConfig};
use models::{AxisPredictor, ModelError, NarxPredictor, NetworkPredictor, StackedPredictor};
use rand::{RngExt, distr::Uniform};
use rand_chacha::ChaCha8Rng;

use super::{
    NetworkRecipe,
    dataset::{Scaling, Task},
};

/// Initial bias of an LSTM's forget gates: a cell keeps its state until training changes that.
const FORGET_BIAS: f32 = 1.0;
/// Limit of a free-running NARX output, as a multiple of the largest error in the training data.
const NARX_BOUND: f32 = 3.0;

/// A network in training.
#[derive(Module, Debug)]
pub enum Net {
    /// LSTM or GRU with a linear head.
    Recurrent(RecurrentNet),
    /// Dense layers.
    Narx(NarxNet),
}

/// Recurrent layers and a linear head.
#[derive(Module, Debug)]
pub struct RecurrentNet {
    stack: FusedRecurrent,
    head: Linear,
}

/// Dense layers with `tanh` and dropout between them.
#[derive(Module, Debug)]
pub struct NarxNet {
    layers: Vec<Linear>,
    dropout: f64,
}

impl Net {
    /// A network with random weights for `features` inputs.
    pub fn draw(recipe: &NetworkRecipe, features: usize, rng: &mut ChaCha8Rng, device: &Device) -> Result<Self, ModelError> {
        let &NetworkRecipe { hidden, layers, dropout, .. } = recipe;
        if let Some(kind) = recipe.kind.cell() {
            let config = RecurrentConfig { kind, input: features, hidden, layers, dropout, forget_bias: Some(FORGET_BIAS) };
            let stack = config.init(rng, device)?;
            return Ok(Self::Recurrent(RecurrentNet { stack, head: linear(hidden, 1, rng, device) }));
        }
        let mut input = features + PAST_ERRORS;
        let mut all = Vec::with_capacity(layers + 1);
        for output in std::iter::repeat_n(hidden, layers).chain([1]) {
            all.push(linear(input, output, rng, device));
            input = output;
        }
        Ok(Self::Narx(NarxNet { layers: all, dropout }))
    }

    /// Scaled errors `[batch, steps, 1]` of scaled features `[batch, steps, features]`, with dropout drawn from `rng`.
    pub fn forward(&self, x: Tensor<3>, rng: &mut ChaCha8Rng) -> Tensor<3> {
        match self {
            Self::Recurrent(net) => net.stack.forward_training(&net.head, x, rng),
            Self::Narx(net) => net.layers.iter().enumerate().fold(x, |x, (index, layer)| {
                let x = if index > 0 { drop(x.tanh(), net.dropout, rng) } else { x };
                layer.forward(x)
            }),
        }
    }

    /// The network as a predictor.
    pub fn predictor(&self, scaling: &Scaling) -> Result<Box<dyn AxisPredictor>, ModelError> {
        let (inputs, targets) = (scaling.inputs.clone(), scaling.targets.clone());
        Ok(match (self, &scaling.task) {
            (Self::Recurrent(net), Task::Papers(spec)) => {
                let network = Recurrent::from_module(&net.stack, &net.head)?;
                Box::new(NetworkPredictor::new(*spec, inputs, targets, network)?)
            }
            (Self::Recurrent(net), Task::Residual(base)) => {
                let network = Recurrent::from_module(&net.stack, &net.head)?;
                Box::new(StackedPredictor::new(base.clone(), inputs, targets, network)?)
            }
            (Self::Narx(net), Task::Papers(spec)) => {
                let layers = net.layers.iter().map(dense).collect::<Result<_, _>>()?;
                Box::new(NarxPredictor::new(*spec, inputs, targets, NARX_BOUND * scaling.largest, layers)?)
            }
            (Self::Narx(_), Task::Residual(_)) => {
                let why = "a NARX network feeds back the whole error, not what a staged predictor leaves".into();
                return Err(ModelError::Malformed { part: "narx".into(), why });
            }
        })
    }
}

/// Weights and biases drawn from `±1/√inputs`, as in PyTorch.
fn linear(inputs: usize, outputs: usize, rng: &mut ChaCha8Rng, device: &Device) -> Linear {
    let bound = 1.0 / (inputs.max(1) as f32).sqrt();
    // The bounds are finite and ordered, so that the distribution exists. Zeros are the fallback.
    let range = Uniform::new_inclusive(-bound, bound).ok();
    let mut draw = |count: usize| -> Vec<f32> { (0..count).map(|_| range.map_or(0.0, |range| rng.sample(range))).collect() };
    let mut linear = LinearConfig::new(inputs, outputs).init(device);
    linear.weight = Param::from_data(TensorData::new(draw(inputs * outputs), [inputs, outputs]), device);
    linear.bias = Some(Param::from_data(TensorData::new(draw(outputs), [outputs]), device));
    linear
}

fn drop(x: Tensor<3>, share: f64, rng: &mut ChaCha8Rng) -> Tensor<3> {
    if share == 0.0 {
        return x;
    }
    let shape = x.shape();
    let kept = (1.0 / (1.0 - share)) as f32;
    let mask: Vec<f32> = (0..shape.num_elements()).map(|_| if rng.random_bool(share) { 0.0 } else { kept }).collect();
    let mask = Tensor::from_data(TensorData::new(mask, shape), &x.device());
    x * mask
}

fn dense(layer: &Linear) -> Result<Dense, ModelError> {
    let read = |data: TensorData| {
        data.convert::<f32>()
            .try_into_vec::<f32>()
            .map_err(|error| ModelError::Malformed { part: "narx".into(), why: format!("weights cannot be read: {error:?}") })
    };
    let bias = match &layer.bias {
        Some(bias) => read(bias.val().into_data())?,
        None => vec![0.0; layer.weight.val().dims()[1]],
    };
    Ok(Dense { weight: read(layer.weight.val().into_data())?, bias })
}
