//! Rebuilds a saved predictor of any kind.

use crate::narx::{self, NarxPredictor};
use crate::network::{self, NetworkPredictor};
use crate::stacked::{self, StackedPredictor};
use crate::staged::{self, StagedPredictor};
use crate::{AxisPredictor, ModelError, SavedPredictor};

/// Rebuilds the predictor that was saved as `saved`.
///
/// # Errors
/// When its kind is unknown, or its settings or arrays are invalid.
pub fn load_predictor(saved: &SavedPredictor) -> Result<Box<dyn AxisPredictor>, ModelError> {
    match saved.kind.as_str() {
        network::LSTM | network::GRU => Ok(Box::new(NetworkPredictor::from_saved(saved)?)),
        narx::KIND => Ok(Box::new(NarxPredictor::from_saved(saved)?)),
        stacked::KIND => Ok(Box::new(StackedPredictor::from_saved(saved)?)),
        staged::KIND => Ok(Box::new(StagedPredictor::from_saved(saved)?)),
        other => Err(ModelError::Malformed { part: "predictor".into(), why: format!("this build knows no kind `{other}`") }),
    }
}
