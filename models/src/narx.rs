//! The non-linear autoregressive network with exogenous inputs (NARX), Paper D's baseline: features and past errors → `tanh` layers.

use serde::{Deserialize, Serialize};

use crate::network::{SETTLING_S, samples, with_standstill_before};
use crate::ranges::{DIVISOR, WEIGHT, singles_within, within};
use crate::{Array, ArrayData, AxisPredictor, AxisSignal, FeatureSpec, ModelError, SavedPredictor, Scaler};

/// Name of this kind of predictor.
pub const KIND: &str = "narx";
/// Past errors `e(k−1…k−6)` among the inputs: a cascaded drive's tracking error is of sixth order
/// (Paper D, eq. 8).
pub const PAST_ERRORS: usize = 6;

/// A dense layer: `y = Wᵀ·x + b`.
#[derive(Debug, Clone, PartialEq)]
pub struct Dense {
    /// `[inputs][outputs]`, row-major.
    pub weight: Vec<f32>,
    /// `[outputs]`.
    pub bias: Vec<f32>,
}

impl Dense {
    fn apply(&self, x: &[f32], y: &mut Vec<f32>) {
        y.clone_from(&self.bias);
        for (x, row) in x.iter().zip(self.weight.chunks_exact(self.bias.len())) {
            for (y, w) in y.iter_mut().zip(row) {
                *y += x * w;
            }
        }
    }
}

/// A NARX network that predicts the tracking error of one axis.
///
/// It has two modes: *series-parallel*, one step ahead from measured errors
/// ([`NarxPredictor::predict_one_step`]), as in training; and *parallel*, on its own past
/// predictions ([`AxisPredictor::predict`]), for a run without measurements.
#[derive(Debug, Clone)]
pub struct NarxPredictor {
    spec: FeatureSpec,
    inputs: Scaler,
    targets: Scaler,
    bound: f32,
    layers: Vec<Dense>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    features: FeatureSpec,
    inputs: Scaler,
    targets: Scaler,
    bound: f32,
    layers: usize,
}

impl NarxPredictor {
    /// A predictor from its parts: `layers` with `tanh` between them take scaled features and
    /// [`PAST_ERRORS`] scaled errors, newest first. Scaled predictions are limited to `±bound`, so
    /// that the parallel mode cannot diverge.
    ///
    /// # Errors
    /// When sizes do not match, or a number is not finite.
    pub fn new(spec: FeatureSpec, inputs: Scaler, targets: Scaler, bound: f32, layers: Vec<Dense>) -> Result<Self, ModelError> {
        let malformed = |why: String| ModelError::Malformed { part: KIND.into(), why };
        spec.check().and_then(|()| inputs.check(spec.width())).and_then(|()| targets.check(1)).map_err(malformed)?;
        let mut width = spec.width() + PAST_ERRORS;
        for (index, layer) in layers.iter().enumerate() {
            if layer.bias.is_empty() || layer.weight.len() != width * layer.bias.len() {
                return Err(malformed(format!(
                    "layer {index} has {} weights and {} biases on {width} inputs",
                    layer.weight.len(),
                    layer.bias.len()
                )));
            }
            width = layer.bias.len();
        }
        if layers.is_empty() || width != 1 {
            return Err(malformed(format!("{} layers end in {width} outputs", layers.len())));
        }
        within("bound", f64::from(bound), DIVISOR).map_err(malformed)?;
        for Dense { weight, bias } in &layers {
            singles_within("weight", weight, WEIGHT).and_then(|()| singles_within("bias", bias, WEIGHT)).map_err(malformed)?;
        }
        Ok(Self { spec, inputs, targets, bound, layers })
    }

    /// Rebuilds a predictor from [`AxisPredictor::save`].
    ///
    /// # Errors
    /// When settings or weights are missing or do not match.
    pub fn from_saved(saved: &SavedPredictor) -> Result<Self, ModelError> {
        let malformed = |why: String| ModelError::Malformed { part: KIND.into(), why };
        if saved.kind != KIND {
            return Err(malformed(format!("it is of kind `{}`", saved.kind)));
        }
        let settings = Settings::deserialize(&saved.settings).map_err(|error| malformed(format!("settings: {error}")))?;
        let values = |name: String| match &saved.array(&name)?.data {
            ArrayData::F32(values) => Ok(values.clone()),
            ArrayData::F64(_) => Err(malformed(format!("`{name}` is in double precision"))),
        };
        let layers = (0..settings.layers)
            .map(|i| Ok(Dense { weight: values(format!("layers.{i}.weight"))?, bias: values(format!("layers.{i}.bias"))? }))
            .collect::<Result<_, ModelError>>()?;
        Self::new(settings.features, settings.inputs, settings.targets, settings.bound, layers)
    }

    /// Series-parallel mode: the error of each sample from the measured errors of the six before it, mm or rad.
    ///
    /// # Errors
    /// When the number of measured errors is not the number of samples.
    pub fn predict_one_step(&self, signal: &AxisSignal<'_>, measured_errors: &[f64]) -> Result<Vec<f64>, ModelError> {
        if measured_errors.len() != signal.reference.len() {
            return Err(ModelError::Misfit(format!(
                "{} measured errors for {} samples",
                measured_errors.len(),
                signal.reference.len()
            )));
        }
        let mut measured: Vec<f32> = measured_errors.iter().map(|error| *error as f32).collect();
        self.targets.scale(&mut measured);
        Ok(self.run(signal, Some(&measured)))
    }

    /// Predictions from the measured (scaled) errors if given, else from its own.
    fn run(&self, signal: &AxisSignal<'_>, measured: Option<&[f32]>) -> Vec<f64> {
        let standstill = samples(SETTLING_S, signal.period_s);
        let mut rows = with_standstill_before(signal, standstill, |signal| self.spec.rows(signal));
        self.inputs.scale(&mut rows);
        let mut nothing = [0.0];
        self.targets.scale(&mut nothing);
        let mut past = [nothing[0]; PAST_ERRORS];
        let mut errors = Vec::with_capacity(signal.reference.len());
        let (mut x, mut y) = (Vec::new(), Vec::new());
        for (k, row) in rows.chunks_exact(self.spec.width()).enumerate() {
            x.clear();
            x.extend(row.iter().chain(&past));
            let predicted = self.forward(&mut x, &mut y);
            past.rotate_right(1);
            past[0] = match measured {
                // The error before the run is zero: the axis is at a standstill.
                Some(_) if k < standstill => nothing[0],
                Some(measured) => self.within(measured[k - standstill]),
                None => predicted,
            };
            if k >= standstill {
                errors.push(predicted);
            }
        }
        self.targets.unscale(&mut errors);
        errors.into_iter().map(f64::from).collect()
    }

    fn forward(&self, x: &mut Vec<f32>, y: &mut Vec<f32>) -> f32 {
        for (index, layer) in self.layers.iter().enumerate() {
            if index > 0 {
                x.iter_mut().for_each(|x| *x = x.tanh());
            }
            layer.apply(x, y);
            std::mem::swap(x, y);
        }
        self.within(x[0])
    }

    fn within(&self, error: f32) -> f32 {
        if error.is_nan() { 0.0 } else { error.clamp(-self.bound, self.bound) }
    }
}

impl AxisPredictor for NarxPredictor {
    fn kind(&self) -> &'static str {
        KIND
    }

    fn predict(&self, signal: &AxisSignal<'_>) -> Vec<f64> {
        self.run(signal, None)
    }

    fn save(&self) -> SavedPredictor {
        let settings = Settings {
            features: self.spec,
            inputs: self.inputs.clone(),
            targets: self.targets.clone(),
            bound: self.bound,
            layers: self.layers.len(),
        };
        let arrays = self.layers.iter().enumerate().flat_map(|(i, Dense { weight, bias })| {
            let outputs = bias.len();
            let array = |shape: Vec<usize>, values: &[f32]| Array { shape, data: ArrayData::F32(values.to_vec()) };
            [
                (format!("layers.{i}.weight"), array(vec![weight.len() / outputs, outputs], weight)),
                (format!("layers.{i}.bias"), array(vec![outputs], bias)),
            ]
        });
        SavedPredictor {
            kind: KIND.into(),
            // Structs of numbers always serialise to JSON; otherwise loading refuses the empty
            // settings.
            settings: serde_json::to_value(settings).unwrap_or_default(),
            arrays: arrays.collect(),
        }
    }
}
