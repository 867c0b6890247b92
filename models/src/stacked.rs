//! A recurrent network on the residual of the staged predictor.

use serde::{Deserialize, Serialize};

use crate::network::ScaledNetwork;
use crate::recurrent::{Kind, Recurrent};
use crate::staged::StagedPredictor;
use crate::{AxisPredictor, AxisSignal, ModelError, SavedPredictor, Scaler};

/// Name of this kind of predictor.
pub const KIND: &str = "staged-network";
/// Prefix of the network's arrays among those of the staged predictor.
const NETWORK: &str = "network.";

/// The staged predictor's tracking error plus that of a network. The network's inputs are the
/// staged predictor's non-linear signals.
#[derive(Debug, Clone)]
pub struct StackedPredictor {
    base: StagedPredictor,
    network: ScaledNetwork,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    base: serde_json::Value,
    cell: Kind,
    inputs: Scaler,
    targets: Scaler,
}

impl StackedPredictor {
    /// `network` on [`StagedPredictor::nonlinear_rows`] of `base`; `targets` scales the residual of
    /// the base, mm or rad.
    ///
    /// # Errors
    /// When the parts do not match, or a weight is not finite.
    pub fn new(base: StagedPredictor, inputs: Scaler, targets: Scaler, network: Recurrent) -> Result<Self, ModelError> {
        let network = ScaledNetwork::new(base.nonlinear_width(), inputs, targets, network)?;
        Ok(Self { base, network })
    }

    /// Rebuilds a predictor from [`AxisPredictor::save`].
    ///
    /// # Errors
    /// When settings or weights are missing or do not match.
    pub fn from_saved(saved: &SavedPredictor) -> Result<Self, ModelError> {
        let settings = Settings::deserialize(&saved.settings)
            .map_err(|error| ModelError::Malformed { part: KIND.into(), why: format!("settings: {error}") })?;
        let (network, base) = saved.arrays.iter().partition::<Vec<_>, _>(|(name, _)| name.starts_with(NETWORK));
        let base = StagedPredictor::from_saved(&SavedPredictor {
            kind: crate::staged::KIND.into(),
            settings: settings.base,
            arrays: base.into_iter().map(|(name, array)| (name.clone(), array.clone())).collect(),
        })?;
        let arrays = network.into_iter().map(|(name, array)| (&name[NETWORK.len()..], array));
        let width = base.nonlinear_width();
        let network = ScaledNetwork::from_arrays(settings.cell, width, settings.inputs, settings.targets, arrays)?;
        Ok(Self { base, network })
    }

    /// The staged predictor.
    #[must_use]
    pub fn base(&self) -> &StagedPredictor {
        &self.base
    }

    /// The same network on another staged predictor of the same signals.
    ///
    /// # Errors
    /// When the signals differ.
    pub fn with_base(self, base: StagedPredictor) -> Result<Self, ModelError> {
        if base.nonlinear_width() != self.network.network().inputs() {
            return Err(ModelError::Misfit("the network was trained on another staged predictor's signals".into()));
        }
        Ok(Self { base, network: self.network })
    }
}

impl AxisPredictor for StackedPredictor {
    fn kind(&self) -> &'static str {
        KIND
    }

    fn predict(&self, signal: &AxisSignal<'_>) -> Vec<f64> {
        let mut errors = self.base.predict(signal);
        let left = self.network.predict(signal, |signal| self.base.nonlinear_rows(signal));
        for (error, left) in errors.iter_mut().zip(left) {
            *error += left;
        }
        errors
    }

    fn holds_beyond_travel(&self) -> bool {
        self.base.holds_beyond_travel()
    }

    fn save(&self) -> SavedPredictor {
        let SavedPredictor { settings, mut arrays, .. } = self.base.save();
        arrays.extend(self.network.arrays().map(|(name, array)| (format!("{NETWORK}{name}"), array)));
        let (inputs, targets) = self.network.scalers();
        let settings = Settings { base: settings, cell: self.network.kind(), inputs: inputs.clone(), targets: targets.clone() };
        SavedPredictor {
            kind: KIND.into(),
            // Structs of numbers always serialise to JSON; otherwise loading refuses the empty
            // settings.
            settings: serde_json::to_value(settings).unwrap_or_default(),
            arrays,
        }
    }
}
