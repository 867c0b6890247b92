//! Recurrent networks as predictors (Paper D, section III): features → scale → LSTM or GRU → unscale.

use serde::{Deserialize, Serialize};

use crate::ranges::{WEIGHT, singles_within};
use crate::recurrent::{Kind, Recurrent};
use crate::{Array, ArrayData, AxisPredictor, AxisSignal, FeatureSpec, ModelError, SavedPredictor, Scaler};

/// Kind name of an LSTM.
pub const LSTM: &str = "lstm";
/// Kind name of a GRU.
pub const GRU: &str = "gru";
/// Standstill before the first sample in which the state settles, s.
pub const SETTLING_S: f64 = 0.2;
/// Longest signal that is predicted in one piece, s.
const SEQUENTIAL_S: f64 = 30.0;
/// Length of the pieces of a longer signal, predicted in parallel, s.
const CHUNK_S: f64 = 5.0;
/// Warm-up of each piece, s.
const WARMUP_S: f64 = 1.5;

/// A recurrent network between scalers: rows of features in their units to errors in mm or rad.
///
/// Signals longer than half a minute are predicted in parallel pieces, each with a warm-up of 1.5
/// s. A longer memory of the network is lost at the cuts.
#[derive(Debug, Clone)]
pub struct ScaledNetwork {
    inputs: Scaler,
    targets: Scaler,
    network: Recurrent,
}

impl ScaledNetwork {
    /// A network of `width` features and one error, mm or rad.
    ///
    /// # Errors
    /// When the network does not have one input per feature and one output, a scaler does not
    /// match, or a weight is not finite.
    pub fn new(width: usize, inputs: Scaler, targets: Scaler, network: Recurrent) -> Result<Self, ModelError> {
        let malformed = |why: String| ModelError::Malformed { part: "network".into(), why };
        if network.inputs() != width || network.outputs() != 1 {
            return Err(malformed(format!(
                "{} inputs and {} outputs for {width} features and one error",
                network.inputs(),
                network.outputs(),
            )));
        }
        inputs.check(width).and_then(|()| targets.check(1)).map_err(malformed)?;
        network.to_tensors().iter().try_for_each(|(name, _, values)| singles_within(name, values, WEIGHT)).map_err(malformed)?;
        Ok(Self { inputs, targets, network })
    }

    /// Rebuilds a network from its scalers and [`ScaledNetwork::arrays`].
    ///
    /// # Errors
    /// When arrays are missing or do not match.
    pub fn from_arrays<'a>(
        kind: Kind,
        width: usize,
        inputs: Scaler,
        targets: Scaler,
        arrays: impl Iterator<Item = (&'a str, &'a Array)>,
    ) -> Result<Self, ModelError> {
        let tensors = arrays
            .map(|(name, Array { shape, data })| match data {
                ArrayData::F32(values) => Ok((name.to_owned(), shape.clone(), values.clone())),
                ArrayData::F64(_) => {
                    Err(ModelError::Malformed { part: "network".into(), why: format!("`{name}` is in double precision") })
                }
            })
            .collect::<Result<_, _>>()?;
        Self::new(width, inputs, targets, Recurrent::from_tensors(kind, tensors)?)
    }

    /// The weights by name.
    pub fn arrays(&self) -> impl Iterator<Item = (String, Array)> {
        self.network.to_tensors().into_iter().map(|(name, shape, values)| (name, Array { shape, data: ArrayData::F32(values) }))
    }

    /// Scalers of the features and of the error.
    #[must_use]
    pub fn scalers(&self) -> (&Scaler, &Scaler) {
        (&self.inputs, &self.targets)
    }

    /// The cell.
    #[must_use]
    pub fn kind(&self) -> Kind {
        self.network.layers().first().map_or(Kind::Lstm, |layer| layer.kind)
    }

    /// The network itself, on scaled features and errors.
    #[must_use]
    pub fn network(&self) -> &Recurrent {
        &self.network
    }

    /// Errors of the rows that `rows` computes from the signal, mm or rad, one per sample. The axis
    /// stands still before the first.
    pub fn predict(&self, signal: &AxisSignal<'_>, rows: impl FnOnce(&AxisSignal<'_>) -> Vec<f32>) -> Vec<f64> {
        let samples = |seconds: f64| samples(seconds, signal.period_s);
        let standstill = samples(SETTLING_S);
        let mut rows = with_standstill_before(signal, standstill, rows);
        self.inputs.scale(&mut rows);
        let outputs = if signal.reference.len() <= samples(SEQUENTIAL_S) {
            self.network.predict(&rows, &mut self.network.zero_state(1))
        } else {
            self.network.predict_chunked(&rows, samples(CHUNK_S), samples(WARMUP_S))
        };
        // `rows` are whole steps of the network's inputs and the state is its own: no error is
        // possible.
        let mut errors: Vec<f32> = outputs.unwrap_or_default().into_iter().skip(standstill).collect();
        self.targets.unscale(&mut errors);
        errors.into_iter().map(f64::from).collect()
    }
}

/// A recurrent network that predicts the tracking error of one axis from the papers' features.
#[derive(Debug, Clone)]
pub struct NetworkPredictor {
    spec: FeatureSpec,
    network: ScaledNetwork,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    features: FeatureSpec,
    inputs: Scaler,
    targets: Scaler,
}

impl NetworkPredictor {
    /// A predictor from its parts; `targets` scales the tracking error, mm or rad.
    ///
    /// # Errors
    /// When the network does not have one input per feature and one output, a scaler does not
    /// match, or a weight is not finite.
    pub fn new(spec: FeatureSpec, inputs: Scaler, targets: Scaler, network: Recurrent) -> Result<Self, ModelError> {
        spec.check().map_err(|why| ModelError::Malformed { part: "network".into(), why })?;
        Ok(Self { spec, network: ScaledNetwork::new(spec.width(), inputs, targets, network)? })
    }

    /// Rebuilds a predictor from [`AxisPredictor::save`].
    ///
    /// # Errors
    /// When settings or weights are missing or do not match.
    pub fn from_saved(saved: &SavedPredictor) -> Result<Self, ModelError> {
        let malformed = |why: String| ModelError::Malformed { part: saved.kind.clone(), why };
        let kind = match saved.kind.as_str() {
            LSTM => Kind::Lstm,
            GRU => Kind::Gru,
            other => return Err(malformed(format!("`{other}` is no recurrent network"))),
        };
        let settings = Settings::deserialize(&saved.settings).map_err(|error| malformed(format!("settings: {error}")))?;
        settings.features.check().map_err(malformed)?;
        let arrays = saved.arrays.iter().map(|(name, array)| (name.as_str(), array));
        let network = ScaledNetwork::from_arrays(kind, settings.features.width(), settings.inputs, settings.targets, arrays)?;
        Ok(Self { spec: settings.features, network })
    }

    /// Features of the network.
    #[must_use]
    pub fn spec(&self) -> &FeatureSpec {
        &self.spec
    }

    /// The network, on scaled features and errors.
    #[must_use]
    pub fn network(&self) -> &Recurrent {
        &self.network.network
    }
}

fn name(kind: Kind) -> &'static str {
    match kind {
        Kind::Lstm => LSTM,
        Kind::Gru => GRU,
    }
}

impl AxisPredictor for NetworkPredictor {
    fn kind(&self) -> &'static str {
        name(self.network.kind())
    }

    fn predict(&self, signal: &AxisSignal<'_>) -> Vec<f64> {
        self.network.predict(signal, |signal| self.spec.rows(signal))
    }

    fn holds_beyond_travel(&self) -> bool {
        !self.spec.set.depends_on_position()
    }

    fn save(&self) -> SavedPredictor {
        let (inputs, targets) = self.network.scalers();
        let settings = Settings { features: self.spec, inputs: inputs.clone(), targets: targets.clone() };
        SavedPredictor {
            kind: self.kind().into(),
            // Structs of numbers always serialise to JSON; otherwise loading refuses the empty
            // settings.
            settings: serde_json::to_value(settings).unwrap_or_default(),
            arrays: self.network.arrays().collect(),
        }
    }
}

/// Samples in a time, at least one.
pub(crate) fn samples(seconds: f64, period_s: f64) -> usize {
    (seconds / period_s).ceil().clamp(1.0, 1e5) as usize
}

/// Result of `with` on the signal with `standstill` samples at its first position before it.
pub(crate) fn with_standstill_before<T>(
    signal: &AxisSignal<'_>,
    standstill: usize,
    with: impl FnOnce(&AxisSignal<'_>) -> T,
) -> T {
    let longer = |positions: &[f64]| -> Vec<f64> {
        let first = positions.first().copied().unwrap_or_default();
        std::iter::repeat_n(first, standstill).chain(positions.iter().copied()).collect()
    };
    let (reference, desired) = (longer(signal.reference), signal.desired.map(longer));
    with(&AxisSignal { reference: &reference, desired: desired.as_deref(), ..*signal })
}
