//! The model bundle: one file with a manifest, the weights and a checksum.
//!
//! A zip archive of `manifest.json` and `weights.safetensors`, stored without compression and without times, so that the same
//! model gives the same bytes. The archive's comment is the SHA-256 of everything before it.

use std::collections::BTreeMap;
use std::io::{Cursor, Read, Write};

use motion::{Axis, AxisKind};
use safetensors::tensor::{Dtype, SafeTensors, TensorView, serialize};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipArchive, ZipWriter};

use crate::hex::hex;
use crate::ranges::{DELAY_S, LENGTH, MOST_AXES, PERIOD_S, RATIO, at_most, within};
use crate::{
    Array, ArrayData, AxisPredictor, LearnedMachine, ModelError, OperatingRange, PredictionInterval, SavedPredictor,
    load_predictor,
};

/// Format of the bundles that this build writes and reads.
pub const FORMAT: u32 = 1;
/// Hexadecimal digits of the checksum.
const CHECKSUM: usize = 64;
/// Largest bundle that is read, bytes: ten times the paper's networks for a machine of six axes.
pub const LARGEST_BYTES: usize = 256 << 20;
/// Largest manifest that is read, bytes: sixteen times that of a three-axis machine with the default
/// recipe. In memory a number takes up to sixteen times its digits.
const LARGEST_MANIFEST: usize = 16 << 20;

/// Errors of an axis's prediction on runs that training never saw, mm or rad.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HeldOut {
    /// Root mean square of the error.
    pub rms: f64,
    /// Largest error.
    pub max: f64,
    /// Root mean square of a linear model's error on the same runs.
    pub linear_rms: f64,
    /// Root mean square of the tracking error itself.
    pub raw_rms: f64,
    /// Coverage probability of the 95 % interval, on runs that it was not fitted to.
    pub band_held: f64,
    /// Number of folds of the cross-validation behind these figures. Each fold is predicted by a
    /// model fitted and chosen without it. Zero if unknown.
    #[serde(default)]
    pub folds: usize,
    /// Largest RMS error over two seconds of these runs, as a ratio to [`Self::rms`]: the
    /// unevenness of the errors. Zero if unknown.
    #[serde(default)]
    pub worst_window: f64,
}

/// Description of one axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxisManifest {
    /// Name of the axis.
    pub name: String,
    /// Whether the axis is rotary: positions in rad instead of mm.
    pub rotary: bool,
    /// Kind of its predictor.
    pub predictor: String,
    /// The predictor's settings.
    pub settings: serde_json::Value,
    /// Errors on held-out runs.
    pub held_out: HeldOut,
    /// Operating range of the training data.
    pub coverage: OperatingRange,
    /// Prediction interval.
    pub band: PredictionInterval,
}

/// How far the machine description foretells what the control commands, on programs that it was not fitted to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ControlFidelity {
    /// What the control does, in words.
    pub structure: String,
    /// Number of programs behind the figures; 0 where there was but the program of the fit.
    pub held_out: usize,
    /// Distance between planned and recorded command at the same place of the path, RMS, mm.
    pub path_rms_mm: f64,
    /// Its largest value, mm.
    pub path_max_mm: f64,
    /// Difference of the time in motion, without sign, as a share of it.
    pub cycle_share: f64,
}

/// Description of the bundle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// Format of the bundle.
    pub format: u32,
    /// Version of the program that wrote it.
    pub version: String,
    /// Day of training in UTC as `YYYY-MM-DD`, where the caller states it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub date: Option<String>,
    /// Sampling period, s.
    pub period_s: f64,
    /// Seed of all random draws in training.
    pub seed: u64,
    /// SHA-256 of the training data, hexadecimal.
    pub data_sha256: String,
    /// Delay that all axes share, s.
    pub common_delay_s: f64,
    /// Description of the machine as TOML, as given to the training, with its drives where it had them; else limits and kinematics from the log.
    pub machine_toml: String,
    /// Whether its limits were estimated from the log.
    pub limits_from_log: bool,
    /// Agreement of the control in `machine_toml` with recorded commands, where it was identified from programs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub control: Option<ControlFidelity>,
    /// The axes, in order.
    pub axes: Vec<AxisManifest>,
}

/// A model: manifest and predictors.
#[derive(Debug)]
pub struct Bundle {
    /// Description of the model.
    pub manifest: Manifest,
    predictors: Vec<SavedPredictor>,
}

impl HeldOut {
    fn check(&self) -> Result<(), String> {
        for (key, value) in [("rms", self.rms), ("max", self.max), ("linear_rms", self.linear_rms), ("raw_rms", self.raw_rms)] {
            within(key, value, LENGTH)?;
        }
        within("band_held", self.band_held, RATIO)?;
        within("worst_window", self.worst_window, RATIO)
    }
}

impl ControlFidelity {
    fn check(&self) -> Result<(), String> {
        within("path_rms_mm", self.path_rms_mm, LENGTH)?;
        within("path_max_mm", self.path_max_mm, LENGTH)?;
        within("cycle_share", self.cycle_share, RATIO)
    }
}

impl Manifest {
    /// Refuses numbers out of range.
    fn check(&self) -> Result<(), ModelError> {
        let out_of_range = |why: String| malformed("manifest", &why);
        if let Some(date) = self.date.as_deref().filter(|date| !is_date(date)) {
            return Err(out_of_range(format!(
                "date: expected YYYY-MM-DD, found `{}`",
                date.escape_debug().take(40).collect::<String>()
            )));
        }
        within("period_s", self.period_s, PERIOD_S).map_err(out_of_range)?;
        within("common_delay_s", self.common_delay_s, DELAY_S).map_err(out_of_range)?;
        self.control.as_ref().map_or(Ok(()), ControlFidelity::check).map_err(|why| malformed("control", &why))?;
        at_most("number of axes", self.axes.len(), MOST_AXES).map_err(out_of_range)?;
        for (index, axis) in self.axes.iter().enumerate() {
            if self.axes[..index].iter().any(|other| other.name == axis.name) {
                return Err(out_of_range(format!("axis `{}` is listed twice", axis.name)));
            }
            for (part, checked) in
                [("held_out", axis.held_out.check()), ("coverage", axis.coverage.check()), ("band", axis.band.check())]
            {
                checked.map_err(|why| malformed(&format!("{part} of axis {}", axis.name), &why))?;
            }
        }
        Ok(())
    }
}

/// Whether a text has the form `YYYY-MM-DD`. It is written into programs, where nothing else may stand.
fn is_date(text: &str) -> bool {
    let fits = |(index, byte): (usize, u8)| if matches!(index, 4 | 7) { byte == b'-' } else { byte.is_ascii_digit() };
    text.len() == 10 && text.bytes().enumerate().all(fits)
}

impl Bundle {
    /// A bundle of one predictor per axis of the manifest. Sets the predictor fields of the
    /// manifest.
    ///
    /// # Errors
    /// When the number of predictors is not the number of axes.
    pub fn new(mut manifest: Manifest, predictors: &[Box<dyn AxisPredictor>]) -> Result<Self, ModelError> {
        if manifest.axes.len() != predictors.len() {
            return Err(ModelError::Misfit(format!("{} predictors for {} axes", predictors.len(), manifest.axes.len())));
        }
        let predictors: Vec<SavedPredictor> = predictors.iter().map(|predictor| predictor.save()).collect();
        for (axis, saved) in manifest.axes.iter_mut().zip(&predictors) {
            axis.predictor.clone_from(&saved.kind);
            axis.settings = saved.settings.clone();
        }
        Ok(Self { manifest, predictors })
    }

    /// The axes.
    #[must_use]
    pub fn axes(&self) -> Vec<Axis> {
        self.manifest
            .axes
            .iter()
            .map(|axis| Axis { name: axis.name.clone(), kind: if axis.rotary { AxisKind::Rotary } else { AxisKind::Linear } })
            .collect()
    }

    /// Operating range of every axis.
    #[must_use]
    pub fn coverage(&self) -> Vec<OperatingRange> {
        self.manifest.axes.iter().map(|axis| axis.coverage).collect()
    }

    /// Rebuilds the predictors.
    ///
    /// # Errors
    /// When a predictor's settings or arrays are not usable.
    pub fn predictors(&self) -> Result<Vec<Box<dyn AxisPredictor>>, ModelError> {
        self.predictors.iter().map(load_predictor).collect()
    }

    /// The machine with these predictors.
    ///
    /// # Errors
    /// When a predictor's settings or arrays are not usable.
    pub fn machine(&self) -> Result<LearnedMachine, ModelError> {
        LearnedMachine::new(self.manifest.period_s, self.axes(), self.predictors()?)
    }

    /// The bundle as bytes; the same model gives the same bytes.
    ///
    /// # Errors
    /// When the parts cannot be serialised.
    pub fn to_bytes(&self) -> Result<Vec<u8>, ModelError> {
        let manifest = serde_json::to_vec_pretty(&self.manifest).map_err(|error| malformed("manifest", &error))?;
        let weights = self.weights()?;
        let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
        let options =
            SimpleFileOptions::default().compression_method(CompressionMethod::Stored).last_modified_time(DateTime::default());
        for (name, bytes) in [(MANIFEST, &manifest), (WEIGHTS, &weights)] {
            archive.start_file(name, options).map_err(|error| malformed("archive", &error))?;
            archive.write_all(bytes)?;
        }
        archive.set_comment("0".repeat(CHECKSUM)).map_err(|error| malformed("archive", &error))?;
        let mut bytes = archive.finish().map_err(|error| malformed("archive", &error))?.into_inner();
        let body = bytes.len() - CHECKSUM;
        let checksum = hex(&Sha256::digest(&bytes[..body]));
        bytes[body..].copy_from_slice(checksum.as_bytes());
        Ok(bytes)
    }

    /// Reads a bundle from `bytes`.
    ///
    /// # Errors
    /// When a byte was changed, the format is another one, or a part is missing or invalid; the
    /// message names it.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, ModelError> {
        let damaged = |why: &str| ModelError::Damaged(why.into());
        if bytes.len() > LARGEST_BYTES {
            return Err(damaged(&format!("it is longer than the {LARGEST_BYTES} bytes that a model may have")));
        }
        let (body, checksum) = bytes
            .len()
            .checked_sub(CHECKSUM)
            .map(|body| bytes.split_at(body))
            .filter(|(body, _)| body.starts_with(b"PK"))
            .ok_or_else(|| damaged("it is not a model bundle"))?;
        if hex(&Sha256::digest(body)).as_bytes() != checksum {
            return Err(damaged("its checksum does not match its content"));
        }
        let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|error| ModelError::Damaged(error.to_string()))?;
        let mut entry = |name: &str| -> Result<Vec<u8>, ModelError> {
            let entry = archive.by_name(name).map_err(|_| damaged(&format!("`{name}` is missing")))?;
            // A part is stored as it is, so that no declared size exceeds the file's own.
            if entry.compression() != CompressionMethod::Stored || entry.size() > bytes.len() as u64 {
                return Err(damaged(&format!("`{name}` is compressed, or larger than the file")));
            }
            let mut content = Vec::new();
            entry.take(bytes.len() as u64).read_to_end(&mut content)?;
            Ok(content)
        };
        let (manifest, weights) = (entry(MANIFEST)?, entry(WEIGHTS)?);
        if manifest.len() > LARGEST_MANIFEST {
            return Err(damaged(&format!("`{MANIFEST}` has {} bytes, at most {LARGEST_MANIFEST} are read", manifest.len())));
        }
        #[derive(Deserialize)]
        struct Versioned {
            format: u32,
        }
        let Versioned { format } = serde_json::from_slice(&manifest).map_err(|error| malformed("manifest", &error))?;
        if format != FORMAT {
            return Err(ModelError::Format { found: format, expected: FORMAT });
        }
        let manifest: Manifest = serde_json::from_slice(&manifest).map_err(|error| malformed("manifest", &error))?;
        manifest.check()?;
        let predictors = arrays(&weights, &manifest)?;
        let bundle = Self { manifest, predictors };
        bundle.predictors()?;
        Ok(bundle)
    }

    fn weights(&self) -> Result<Vec<u8>, ModelError> {
        let mut named: BTreeMap<String, (Dtype, &[usize], Vec<u8>)> = BTreeMap::new();
        for (axis, predictor) in self.manifest.axes.iter().zip(&self.predictors) {
            for (name, Array { shape, data }) in &predictor.arrays {
                let (dtype, bytes) = match data {
                    ArrayData::F64(values) => (Dtype::F64, values.iter().flat_map(|v| v.to_le_bytes()).collect()),
                    ArrayData::F32(values) => (Dtype::F32, values.iter().flat_map(|v| v.to_le_bytes()).collect()),
                };
                named.insert(format!("{}/{name}", axis.name), (dtype, shape, bytes));
            }
        }
        let views = named
            .iter()
            .map(|(name, (dtype, shape, bytes))| Ok((name.clone(), TensorView::new(*dtype, shape.to_vec(), bytes)?)))
            .collect::<Result<Vec<_>, safetensors::SafeTensorError>>()
            .map_err(|error| malformed("weights", &error))?;
        serialize(views, None).map_err(|error| malformed("weights", &error))
    }
}

const MANIFEST: &str = "manifest.json";
const WEIGHTS: &str = "weights.safetensors";

fn arrays(weights: &[u8], manifest: &Manifest) -> Result<Vec<SavedPredictor>, ModelError> {
    let tensors = SafeTensors::deserialize(weights).map_err(|error| malformed("weights", &error))?;
    let mut predictors: Vec<SavedPredictor> = manifest
        .axes
        .iter()
        .map(|axis| SavedPredictor { kind: axis.predictor.clone(), settings: axis.settings.clone(), arrays: BTreeMap::new() })
        .collect();
    for (name, view) in tensors.tensors() {
        let place = name
            .split_once('/')
            .and_then(|(axis, array)| Some((manifest.axes.iter().position(|known| known.name == axis)?, array)));
        let Some((axis, array)) = place else {
            return Err(ModelError::Malformed { part: "weights".into(), why: format!("`{name}` belongs to no axis") });
        };
        let data = match view.dtype() {
            Dtype::F64 => ArrayData::F64(view.data().as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect()),
            Dtype::F32 => ArrayData::F32(view.data().as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect()),
            other => {
                return Err(ModelError::Malformed { part: "weights".into(), why: format!("`{name}` holds {other:?}") });
            }
        };
        predictors[axis].arrays.insert(array.to_owned(), Array { shape: view.shape().to_vec(), data });
    }
    Ok(predictors)
}

fn malformed(part: &str, error: &dyn std::fmt::Display) -> ModelError {
    ModelError::Malformed { part: part.into(), why: error.to_string() }
}
