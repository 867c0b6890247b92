//! What is kept of a machine beside its model: servo models, and what healthy days show.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use servo::Servo;

use crate::error::{FleetError, Result};
use crate::estimate::{Quantity, Reading};

/// Format of the file that this build writes and reads.
const FORMAT: u32 = 1;

/// The state of a machine in which its model was trained.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Baseline {
    /// Format of the file.
    pub format: u32,
    /// Name of the machine.
    pub machine: String,
    /// Days on which the model was trained.
    pub trained_on: Vec<String>,
    /// Days after them that are taken to be healthy.
    pub calibrated_on: Vec<String>,
    /// The axes.
    pub axes: Vec<AxisBaseline>,
}

/// The state of an axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxisBaseline {
    /// Name of the axis.
    pub axis: String,
    /// Its servo model; lengths of a rotary axis are those on a lever arm of 100 mm.
    pub servo: Servo,
    /// Readings of the healthy days, by quantity.
    pub healthy: BTreeMap<Quantity, Vec<Reading>>,
}

/// The model of a machine in the folder of the models.
#[must_use]
pub fn model_path(models: &Path, machine: &str) -> PathBuf {
    models.join(format!("{machine}.model"))
}

/// The baseline beside it.
#[must_use]
pub fn baseline_path(models: &Path, machine: &str) -> PathBuf {
    models.join(format!("{machine}.baseline.json"))
}

impl Baseline {
    pub(crate) fn new(machine: &str, trained_on: Vec<String>, calibrated_on: Vec<String>, axes: Vec<AxisBaseline>) -> Self {
        Self { format: FORMAT, machine: machine.to_owned(), trained_on, calibrated_on, axes }
    }

    /// The baseline as the bytes of its file.
    ///
    /// # Errors
    /// When a number cannot be written.
    pub fn to_bytes(&self, path: &Path) -> Result<Vec<u8>> {
        let text = serde_json::to_string_pretty(self);
        let text = text.map_err(|error| FleetError::Baseline { path: path.to_owned(), reason: error.to_string() })?;
        Ok((text + "\n").into_bytes())
    }

    /// Reads the baseline of a machine.
    ///
    /// # Errors
    /// When the file cannot be read, is damaged, of another format or of another machine.
    pub fn read(models: &Path, machine: &str) -> Result<Self> {
        let path = baseline_path(models, machine);
        let bytes = std::fs::read(&path).map_err(FleetError::io(&path))?;
        let refused = |reason: String| FleetError::Baseline { path: path.clone(), reason };
        let read: Self = serde_json::from_slice(&bytes).map_err(|error| refused(error.to_string()))?;
        if read.format != FORMAT {
            return Err(refused(format!("it has format {}, this build reads {FORMAT}", read.format)));
        }
        if read.machine != machine {
            return Err(refused(format!("it is of the machine {}", read.machine)));
        }
        for axis in &read.axes {
            axis.servo.check().map_err(|reason| refused(format!("axis {}: {reason}", axis.axis)))?;
        }
        Ok(read)
    }

    /// The servo model of every axis by name.
    pub(crate) fn servos(&self) -> Vec<(String, Servo)> {
        self.axes.iter().map(|axis| (axis.axis.clone(), axis.servo)).collect()
    }
}
