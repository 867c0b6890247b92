//! Models of one call, each trained once: several tables use the same.

use std::cell::RefCell;
use std::rc::Rc;

use anyhow::Result;
use models::{Bundle, FeatureSet};

/// Models by what they were trained with.
#[derive(Default)]
pub(super) struct Trained(RefCell<Vec<(Key, Rc<Bundle>)>>);

impl std::fmt::Debug for Trained {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_list().entries(self.0.borrow().iter().map(|(key, _)| key)).finish()
    }
}

/// What a model was trained with.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Key {
    pub axes: Axes,
    pub predictor: String,
    pub features: FeatureSet,
    pub seed: u64,
}

/// Axes that a model is trained on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Axes {
    /// The X axis alone.
    X,
    All,
}

impl Trained {
    /// The model of `key`, trained by `train` where there is none yet.
    pub(super) fn get(&self, key: Key, train: impl FnOnce() -> Result<Bundle>) -> Result<Rc<Bundle>> {
        let known = self.0.borrow().iter().find(|(known, _)| *known == key).map(|(_, bundle)| Rc::clone(bundle));
        if let Some(bundle) = known {
            return Ok(bundle);
        }
        let bundle = Rc::new(train()?);
        self.0.borrow_mut().push((key, Rc::clone(&bundle)));
        Ok(bundle)
    }
}
