//! The staged predictor: passes of least-squares models, each on the expected position of the
//! previous one.

use serde::{Deserialize, Serialize};

use super::features::FeatureSet;
use super::servo_base::ServoBase;
use super::signals::Signals;
use crate::ranges::{MOST_PASSES, PERIOD_S, WEIGHT, all_within, at_most, within};
use crate::{Array, ArrayData, AxisPredictor, AxisSignal, ModelError, SavedPredictor};

/// Kind name of this predictor.
pub const KIND: &str = "staged";

/// One pass: a linear model whose operators run on the expected position of the previous pass.
#[derive(Debug, Clone, PartialEq)]
pub struct Pass {
    /// The columns.
    pub features: FeatureSet,
    /// One weight a column, in the axis's unit per unit of the column.
    pub weights: Vec<f64>,
}

impl Pass {
    /// Predicted tracking error of a run whose expected position is `expected`.
    #[must_use]
    pub fn predict(&self, signal: &AxisSignal<'_>, expected: &[f64]) -> Vec<f64> {
        self.features.predict(&self.signals(signal, expected), &self.weights)
    }

    /// Expected motor position of a run with these signals, where `error` is this pass's
    /// prediction: the reference less the error, without the backlash, which the drive does not
    /// see.
    #[must_use]
    pub fn position(&self, reference: &[f64], signals: &Signals, error: &[f64]) -> Vec<f64> {
        let mut position: Vec<f64> = reference.iter().zip(error).map(|(r, e)| r - e).collect();
        if let Some(backlash) = self.features.backlash(signals, &self.weights) {
            position.iter_mut().zip(backlash).for_each(|(x, offset)| *x += offset);
        }
        position
    }

    /// Signals of a run for this pass.
    #[must_use]
    pub fn signals(&self, signal: &AxisSignal<'_>, expected: &[f64]) -> Signals {
        self.features.signals(signal.reference, signal.flag_source(), expected, signal.period_s, 0.0).placed(signal.placed)
    }
}

/// Predicts one axis's tracking error in passes: a linear law, then hysteresis on the resulting
/// position, then position harmonics. A simple axis has one pass only, down to a pure delay.
///
/// With a servo model the passes predict `e − (r − x_s)`, where `x_s` is the position that the model
/// takes, and the first runs on `x_s` instead of the reference.
#[derive(Debug, Clone, PartialEq)]
pub struct StagedPredictor {
    period_s: f64,
    servo: Option<Box<ServoBase>>,
    passes: Vec<Pass>,
}

#[derive(Serialize, Deserialize)]
struct Settings {
    period_s: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    servo: Option<ServoBase>,
    passes: Vec<FeatureSet>,
}

impl StagedPredictor {
    /// A predictor of the given passes, sampled every `period_s` seconds.
    ///
    /// # Errors
    /// When there is no pass, a pass lacks weights or refers to an operator or harmonic that it
    /// does not have, or a number is not finite.
    pub fn new(period_s: f64, passes: Vec<Pass>) -> Result<Self, ModelError> {
        let malformed = |why: String| ModelError::Malformed { part: KIND.into(), why };
        within("period_s", period_s, PERIOD_S).map_err(malformed)?;
        at_most("number of passes", passes.len(), MOST_PASSES).map_err(malformed)?;
        if passes.is_empty() {
            return Err(malformed("no pass".into()));
        }
        for (index, pass) in passes.iter().enumerate() {
            pass.features.check().map_err(|why| malformed(format!("pass {index}: {why}")))?;
            if pass.weights.len() != pass.features.columns() {
                return Err(malformed(format!(
                    "pass {index} has {} weights for {} columns",
                    pass.weights.len(),
                    pass.features.columns()
                )));
            }
            all_within("weights", &pass.weights, WEIGHT).map_err(|why| malformed(format!("pass {index}: {why}")))?;
        }
        Ok(Self { period_s, servo: None, passes })
    }

    /// The same passes on a servo model.
    ///
    /// # Errors
    /// When a number of the model is out of range.
    pub fn on_servo(self, servo: Option<ServoBase>) -> Result<Self, ModelError> {
        let malformed = |why: String| ModelError::Malformed { part: KIND.into(), why };
        servo.as_ref().map_or(Ok(()), ServoBase::check).map_err(malformed)?;
        Ok(Self { servo: servo.map(Box::new), ..self })
    }

    /// The servo model, if there is one.
    #[must_use]
    pub fn servo(&self) -> Option<&ServoBase> {
        self.servo.as_deref()
    }

    /// The linear part: the first pass, on the servo model without friction and backlash.
    #[must_use]
    pub fn linear_part(&self) -> Self {
        let servo = self.servo().map(|servo| Box::new(servo.linear()));
        Self { period_s: self.period_s, servo, passes: self.passes.iter().take(1).cloned().collect() }
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
        let passes = settings
            .passes
            .into_iter()
            .enumerate()
            .map(|(index, features)| match &saved.array(&weights_name(index))?.data {
                ArrayData::F64(weights) => Ok(Pass { features, weights: weights.clone() }),
                ArrayData::F32(_) => Err(malformed("weights are in single precision".into())),
            })
            .collect::<Result<_, _>>()?;
        Self::new(settings.period_s, passes)?.on_servo(settings.servo)
    }

    /// Sampling period of the runs of the fit, s; the predictor holds for no other.
    #[must_use]
    pub fn period_s(&self) -> f64 {
        self.period_s
    }

    /// The passes in order; the prediction is that of the last one.
    #[must_use]
    pub fn passes(&self) -> &[Pass] {
        &self.passes
    }

    /// Prediction, and the expected position of the last pass.
    #[must_use]
    pub fn predict_with_position(&self, signal: &AxisSignal<'_>) -> (Vec<f64>, Vec<f64>) {
        let mut expected = match &self.servo {
            Some(servo) => servo.follow(signal),
            None => signal.reference.to_vec(),
        };
        let base: Vec<f64> = signal.reference.iter().zip(&expected).map(|(r, x)| r - x).collect();
        let mut error = base.clone();
        // The motion is the same in all passes; the padding may be longer than one needs.
        let pad = self.passes.iter().map(|pass| pass.features.pad()).max().unwrap_or(0);
        let mut signals = Signals::of_motion(signal.reference, signal.flag_source(), signal.period_s, pad).placed(signal.placed);
        let mut before: Option<&Pass> = None;
        for pass in &self.passes {
            if let Some(before) = before {
                expected = before.position(signal.reference, &signals, &error);
            }
            signals.expect(&expected, &pass.features.scales);
            error = pass.features.predict(&signals, &pass.weights);
            error.iter_mut().zip(&base).for_each(|(error, base)| *error += base);
            before = Some(pass);
        }
        (error, expected)
    }

    /// Inputs for a further stage on the residual, row-major, [`Self::nonlinear_width`] values per
    /// sample.
    ///
    /// Velocity of the reference, its increment, direction, the outputs of the stop operators, and
    /// cosine and sine of the position harmonics at the expected position of the last pass.
    #[must_use]
    pub fn nonlinear_rows(&self, signal: &AxisSignal<'_>) -> Vec<f32> {
        let (_, expected) = self.predict_with_position(signal);
        self.passes.last().map(|pass| pass.features.plain_rows(&pass.signals(signal, &expected))).unwrap_or_default()
    }

    /// Values per sample of [`Self::nonlinear_rows`].
    #[must_use]
    pub fn nonlinear_width(&self) -> usize {
        self.passes.last().map_or(0, |pass| pass.features.plain_width())
    }
}

fn weights_name(pass: usize) -> String {
    format!("pass-{pass}.weights")
}

impl AxisPredictor for StagedPredictor {
    fn kind(&self) -> &'static str {
        KIND
    }

    fn predict(&self, signal: &AxisSignal<'_>) -> Vec<f64> {
        self.predict_with_position(signal).0
    }

    /// Linear law and operators do not depend on the position, and friction by place is that elsewhere beyond its places. The harmonics taper off, and are
    /// zero without machine coordinates.
    fn holds_beyond_travel(&self) -> bool {
        true
    }

    /// Lag, friction and the servo model are laws of motion: see [`OperatingRange::weights`](crate::OperatingRange::weights).
    fn holds_beyond_speed(&self) -> bool {
        true
    }

    fn save(&self) -> SavedPredictor {
        let settings = Settings {
            period_s: self.period_s,
            servo: self.servo().copied(),
            passes: self.passes.iter().map(|pass| pass.features.clone()).collect(),
        };
        let arrays = self.passes.iter().enumerate().map(|(index, pass)| {
            let array = Array { shape: vec![pass.weights.len()], data: ArrayData::F64(pass.weights.clone()) };
            (weights_name(index), array)
        });
        SavedPredictor {
            kind: KIND.into(),
            // Structs of numbers and lists always serialise to JSON; otherwise loading refuses the
            // empty settings.
            settings: serde_json::to_value(settings).unwrap_or_default(),
            arrays: arrays.collect(),
        }
    }
}
