//! The trait behind which every predictor of one axis stands.

use std::collections::BTreeMap;

use crate::ModelError;

/// What a predictor sees of one axis.
#[derive(Debug, Clone, Copy)]
pub struct AxisSignal<'a> {
    /// Commanded position, mm or rad, one a period.
    pub reference: &'a [f64],
    /// The path before any compensation, same length. Reversal and start flags are taken from it where it is given, so that
    /// shifts of a micrometre near rest do not toggle them; `None` means that the reference is the desired path.
    pub desired: Option<&'a [f64]>,
    /// Sampling period, s.
    pub period_s: f64,
    /// Whether the positions are the machine's. Those of a part whose work offset is not known are off by a constant: what depends on position
    /// is then left out.
    pub placed: bool,
}

impl<'a> AxisSignal<'a> {
    /// A signal whose reference is its desired path.
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

    /// Tracking error `reference − actual`, mm or rad, one a sample of the reference. The axis rests before the first sample.
    fn predict(&self, signal: &AxisSignal<'_>) -> Vec<f64>;

    /// Whether the prediction is as good beyond the trained positions as within them, but for what it lets fade by itself. A correction
    /// fades there where it is not.
    fn holds_beyond_travel(&self) -> bool {
        false
    }

    /// Everything needed to rebuild the predictor.
    fn save(&self) -> SavedPredictor;
}

/// A predictor taken apart: settings as JSON, weights as named arrays.
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
