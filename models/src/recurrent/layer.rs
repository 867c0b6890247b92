//! A layer's weights as plain numbers, and as named tensors.

use super::{Kind, kernel::Weights};
use crate::ModelError;

/// A tensor's name, shape and values (row-major).
pub type NamedTensor = (String, Vec<usize>, Vec<f32>);

/// One layer's weights, in PyTorch's shapes and order of gates.
#[derive(Debug, Clone, PartialEq)]
pub struct LayerWeights {
    /// LSTM or GRU.
    pub kind: Kind,
    /// Features of an input.
    pub input: usize,
    /// Units.
    pub hidden: usize,
    /// Input weights, `[gates·hidden][input]`.
    pub weight_ih: Vec<f32>,
    /// Hidden weights, `[gates·hidden][hidden]`.
    pub weight_hh: Vec<f32>,
    /// Biases, `4·hidden`: `i f g o`, or `r z n` and `b_hn`.
    pub bias: Vec<f32>,
}

impl LayerWeights {
    /// A layer from PyTorch's four tensors `weight_ih`, `weight_hh`, `bias_ih`, `bias_hh`.
    ///
    /// # Errors
    /// When the lengths do not fit `input` and `hidden`.
    pub fn from_pytorch(
        kind: Kind,
        input: usize,
        hidden: usize,
        [weight_ih, weight_hh, bias_ih, bias_hh]: [Vec<f32>; 4],
    ) -> Result<Self, ModelError> {
        let rows = kind.gates() * hidden;
        if bias_ih.len() != rows || bias_hh.len() != rows {
            return Err(malformed(format!("biases are not {rows} long")));
        }
        let mut bias: Vec<f32> = bias_ih.iter().zip(&bias_hh).map(|(a, b)| a + b).collect();
        if kind == Kind::Gru {
            bias[2 * hidden..].copy_from_slice(&bias_ih[2 * hidden..]);
            bias.extend_from_slice(&bias_hh[2 * hidden..]);
        }
        let layer = Self { kind, input, hidden, weight_ih, weight_hh, bias };
        layer.check()?;
        Ok(layer)
    }

    /// Whether the lengths agree with the sizes.
    ///
    /// # Errors
    /// When they do not, or a size is zero.
    pub fn check(&self) -> Result<(), ModelError> {
        // Sizes from a file may be of any magnitude: saturated, they fit no weights.
        let rows = self.kind.gates().saturating_mul(self.hidden);
        let found = [self.weight_ih.len(), self.weight_hh.len(), self.bias.len()];
        let wanted = [rows.saturating_mul(self.input), rows.saturating_mul(self.hidden), self.hidden.saturating_mul(4)];
        if self.input == 0 || self.hidden == 0 || found != wanted {
            return Err(malformed(format!(
                "a {:?} layer of {} inputs and {} units wants {wanted:?} weights and biases, not {found:?}",
                self.kind, self.input, self.hidden
            )));
        }
        Ok(())
    }

    /// The weights as the kernels take them.
    pub(super) fn weights(&self) -> Weights<'_> {
        Weights { kind: self.kind, input: &self.weight_ih, hidden: &self.weight_hh, bias: &self.bias }
    }

    /// Names, shapes and values: `layers.{index}.weight_ih`, `.weight_hh`, `.bias`.
    pub(super) fn named(&self, index: usize) -> [NamedTensor; 3] {
        let rows = self.kind.gates() * self.hidden;
        let name = |what: &str| format!("layers.{index}.{what}");
        [
            (name("weight_ih"), vec![rows, self.input], self.weight_ih.clone()),
            (name("weight_hh"), vec![rows, self.hidden], self.weight_hh.clone()),
            (name("bias"), vec![4 * self.hidden], self.bias.clone()),
        ]
    }
}

/// Whether the layers are well-formed, of one kind, and fit each other.
pub(super) fn check_stack(layers: &[LayerWeights]) -> Result<(), ModelError> {
    if layers.is_empty() {
        return Err(malformed("it has no layers".to_owned()));
    }
    for layer in layers {
        layer.check()?;
    }
    for (index, pair) in layers.windows(2).enumerate() {
        if pair[0].hidden != pair[1].input || pair[0].kind != pair[1].kind {
            return Err(malformed(format!("layer {} does not fit layer {index}", index + 1)));
        }
    }
    Ok(())
}

/// The linear layer behind the last recurrent one: `y = W·h + b`.
#[derive(Debug, Clone, PartialEq)]
pub struct Head {
    /// Outputs.
    pub outputs: usize,
    /// `[outputs][hidden]`.
    pub weight: Vec<f32>,
    /// `[outputs]`.
    pub bias: Vec<f32>,
}

impl Head {
    /// Appends the outputs for each row of `hidden` features.
    pub(super) fn apply(&self, rows: &[f32], hidden: usize, out: &mut Vec<f32>) {
        for row in rows.chunks_exact(hidden) {
            let lines = self.weight.chunks_exact(hidden).zip(&self.bias);
            out.extend(lines.map(|(line, bias)| bias + dot(line, row)));
        }
    }
}

/// `a·b`, summed in 16 parts so that it can be vectorised.
fn dot(a: &[f32], b: &[f32]) -> f32 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<16>(), b.as_chunks::<16>());
    let mut sums = [0.0_f32; 16];
    for (a, b) in a.iter().zip(b) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += a * b;
        }
    }
    let rest: f32 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f32>() + rest
}

/// An error about a recurrent model.
pub(super) fn malformed(why: String) -> ModelError {
    ModelError::Malformed { part: "recurrent network".to_owned(), why }
}
