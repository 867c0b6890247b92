//! Checkpoints: an interrupted training resumes with the same result.

use std::fs;
use std::path::{Path, PathBuf};

use burn::module::Module;
use burn::optim::ModuleOptimizer;
use burn::store::{ModuleRecord, RecordError};
use models::hex;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::{NetworkRecipe, net::Net};
use crate::{TrainingError, staged::AxisRun};

const FINISHED: &str = "checkpoint";
const UNFINISHED: &str = "checkpoint.new";
const PREVIOUS: &str = "checkpoint.old";

/// Progress of a training. Random draws need no state: each epoch has its own random stream.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Progress {
    /// Recipe, seed and data that it belongs to.
    pub of: String,
    /// Epochs done.
    pub epochs: usize,
    /// Epochs done when the held-out error was least.
    pub best_epoch: usize,
    /// Least held-out error, mm or rad; `None` before the first validation.
    pub best_rms: Option<f64>,
    /// Validations since then.
    pub failures: usize,
}

/// A training's state.
#[derive(Clone)]
pub struct State {
    /// The network.
    pub net: Net,
    /// The network with the least held-out error.
    pub best: Net,
    /// Adam's moments.
    pub optimizer: ModuleOptimizer,
    /// Progress.
    pub progress: Progress,
}

/// A hash of everything that a training's result depends on.
pub fn identity(runs: &[AxisRun], held_out: &[AxisRun], recipe: &NetworkRecipe, seed: u64) -> Result<String, TrainingError> {
    let mut hash = Sha256::new();
    hash.update(seed.to_le_bytes());
    hash.update(serde_json::to_vec(recipe).map_err(|error| TrainingError::Checkpoint(error.to_string()))?);
    for runs in [runs, held_out] {
        hash.update(runs.len().to_le_bytes());
        for run in runs {
            hash.update(run.period_s.to_le_bytes());
            hash.update(run.reference.len().to_le_bytes());
            run.rows.iter().flat_map(|rows| [rows.start, rows.end]).for_each(|row| hash.update(row.to_le_bytes()));
            run.reference.iter().chain(&run.actual).for_each(|position| hash.update(position.to_le_bytes()));
        }
    }
    Ok(hex(&hash.finalize()))
}

impl State {
    /// Writes the state to `folder`. The previous state stays until the new one is complete.
    pub fn save(&self, folder: &Path) -> Result<(), TrainingError> {
        let [finished, unfinished, previous] = [FINISHED, UNFINISHED, PREVIOUS].map(|name| folder.join(name));
        remove(&unfinished)?;
        fs::create_dir_all(&unfinished)?;
        let [net, best, optimizer, progress] = files(&unfinished);
        self.net.clone().into_record().save(net).map_err(refused)?;
        self.best.clone().into_record().save(best).map_err(refused)?;
        self.optimizer.save(optimizer).map_err(refused)?;
        let text = serde_json::to_vec_pretty(&self.progress).map_err(|error| TrainingError::Checkpoint(error.to_string()))?;
        fs::write(progress, text)?;
        remove(&previous)?;
        if finished.exists() {
            fs::rename(&finished, &previous)?;
        }
        fs::rename(&unfinished, &finished)?;
        remove(&previous)
    }

    /// The state in `folder` if there is one, else this one.
    ///
    /// # Errors
    /// When there is one of another training, or it cannot be read.
    pub fn resumed(self, folder: &Path) -> Result<Self, TrainingError> {
        // A process that ends between the two renames leaves only the previous state.
        let Some(found) = [FINISHED, PREVIOUS].map(|name| folder.join(name)).into_iter().find(|path| path.exists()) else {
            return Ok(self);
        };
        let [net, best, optimizer, progress] = files(&found);
        let progress: Progress =
            serde_json::from_slice(&fs::read(progress)?).map_err(|error| TrainingError::Checkpoint(error.to_string()))?;
        if progress.of != self.progress.of {
            return Err(TrainingError::Checkpoint(
                "it belongs to another training (recipe, seed or runs differ); remove it or name another folder".into(),
            ));
        }
        let load = |path: PathBuf| -> Result<Net, TrainingError> {
            self.net.clone().try_load_record(ModuleRecord::load(path).map_err(refused)?).map_err(refused)
        };
        let (net, best) = (load(net)?, load(best)?);
        Ok(Self { net, best, optimizer: self.optimizer.load(optimizer).map_err(refused)?, progress })
    }
}

fn files(folder: &Path) -> [PathBuf; 4] {
    ["network.bpk", "best.bpk", "optimizer.bpk", "progress.json"].map(|name| folder.join(name))
}

fn remove(folder: &Path) -> Result<(), TrainingError> {
    if folder.exists() { Ok(fs::remove_dir_all(folder)?) } else { Ok(()) }
}

fn refused(error: RecordError) -> TrainingError {
    TrainingError::Checkpoint(error.to_string())
}
