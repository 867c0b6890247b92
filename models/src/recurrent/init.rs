//! Initial weights.

use rand::{RngExt, distr::Uniform};
use rand_chacha::ChaCha8Rng;

use super::{Kind, LayerWeights};

/// Weights and biases drawn from `±1/√hidden`, as PyTorch does; with `forget_bias` an LSTM's forget gate gets that bias instead
/// (1 lets a cell remember from the start). Biases that are a sum of two in PyTorch are drawn as a sum of two here.
pub(super) fn draw(kind: Kind, input: usize, hidden: usize, forget_bias: Option<f32>, rng: &mut ChaCha8Rng) -> LayerWeights {
    let bound = 1.0 / (hidden.max(1) as f32).sqrt();
    // The bounds are finite and ordered, so that the distribution exists. Zeros are the fallback.
    let range = Uniform::new_inclusive(-bound, bound).ok();
    let mut draw = |count: usize| -> Vec<f32> { (0..count).map(|_| range.map_or(0.0, |range| rng.sample(range))).collect() };
    let rows = kind.gates() * hidden;
    let weights = (draw(rows * input), draw(rows * hidden));
    let mut bias = draw(4 * hidden);
    let summed = match kind {
        Kind::Lstm => 4 * hidden,
        Kind::Gru => 2 * hidden,
    };
    for (bias, second) in bias.iter_mut().zip(draw(summed)) {
        *bias += second;
    }
    if let (Kind::Lstm, Some(value)) = (kind, forget_bias) {
        bias[hidden..2 * hidden].fill(value);
    }
    LayerWeights { kind, input, hidden, weight_ih: weights.0, weight_hh: weights.1, bias }
}
