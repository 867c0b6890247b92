//! The trait of the predictors of one axis.

use std::collections::BTreeMap;

use crate::ModelError;

/// Inputs of a predictor.
#[derive(Debug, Clone, Copy)]
pub struct AxisSignal<'a> {
    /// Commanded position, mm or rad, one value per period.
    pub reference: &'a [f64],
    /// The path before any compensation, same length. Reversal and start flags are taken from it,
    /// so that shifts of a micrometre near a standstill do not toggle them. `None`: the reference
    /// is the desired path.
    pub desired: Option<&'a [f64]>,
    /// Sampling period, s.
    pub period_s: f64,
    /// Whether the positions are in machine coordinates. With an unknown work offset they are off
    /// by a constant: position-dependent terms are then left out.
    pub placed: bool,
}

impl<'a> AxisSignal<'a> {
    /// A signal with the desired path as its reference.
    #[must_use]
    pub fn uncompensated(reference: &'a [f64], period_s: f64) -> Self {
        Self { reference, desired: None, period_s, placed: true }
    }

    /// The positions from which reversal and start flags are taken.
    #[must_use]
    pub fn flag_source(&self) -> &'a [f64] {
        self.desired.unwrap_or(self.reference)
    }
}

/// Predicts the tracking error of one axis from its commanded positions.
pub trait AxisPredictor: std::fmt::Debug + Send + Sync {
    /// Short name of the kind, as in `precomp train --predictor`.
    fn kind(&self) -> &'static str;

    /// Tracking error `reference − actual`, mm or rad, one value per sample of the reference. The
    /// axis stands still before the first sample.
    fn predict(&self, signal: &AxisSignal<'_>) -> Vec<f64>;

    /// Whether the prediction holds beyond the trained positions, apart from terms that taper off
    /// by themselves. If not, the correction is tapered there.
    fn holds_beyond_travel(&self) -> bool {
        false
    }

    /// Whether the prediction holds for faster motion than it was trained on. If not, the correction is tapered there.
    fn holds_beyond_speed(&self) -> bool {
        false
    }

    /// Settings and arrays from which the predictor can be rebuilt.
    fn save(&self) -> SavedPredictor;
}

/// A saved predictor: settings as JSON, weights as named arrays.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SavedPredictor {
    /// The predictor's [`AxisPredictor::kind`].
    pub kind: String,
    /// Settings and scalars.
    pub settings: serde_json::Value,
    /// Weights, by name.
    pub arrays: BTreeMap<String, Array>,
}

impl SavedPredictor {
    /// The array called `name`.
    ///
    /// # Errors
    /// When there is none.
    pub fn array(&self, name: &str) -> Result<&Array, ModelError> {
        self.arrays
            .get(name)
            .ok_or_else(|| ModelError::Malformed { part: self.kind.clone(), why: format!("array `{name}` is missing") })
    }
}

/// A named array's shape and values, row-major.
#[derive(Debug, Clone, PartialEq)]
pub struct Array {
    /// Length of each dimension.
    pub shape: Vec<usize>,
    /// The values.
    pub data: ArrayData,
}

/// Values of an [`Array`]: `f64` for least-squares weights, `f32` for networks.
#[derive(Debug, Clone, PartialEq)]
pub enum ArrayData {
    /// Double precision.
    F64(Vec<f64>),
    /// Single precision.
    F32(Vec<f32>),
}
