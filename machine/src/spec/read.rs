//! Machine files: TOML input and output, with drive values common to all axes.

use toml::{Table, Value};

use super::MachineSpec;
use crate::MachineError;

impl MachineSpec {
    /// Reads a machine file. A top-level `[drive]` holds values common to all linear axes,
    /// `[rotary_drive]` those common to all rotary axes. The `drive` of an axis overrides them key
    /// by key.
    ///
    /// # Errors
    /// If the text is not TOML, a key is unknown or missing, or a value is out of range.
    pub fn from_toml(text: &str) -> Result<Self, MachineError> {
        let bad = |error: toml::de::Error| MachineError::BadDescription(error.to_string());
        let mut file: Table = text.parse().map_err(bad)?;
        for (key, kind) in [("drive", "linear"), ("rotary_drive", "rotary")] {
            match file.remove(key) {
                None => {}
                Some(Value::Table(common)) => share_out(&common, kind, &mut file),
                Some(_) => {
                    return Err(MachineError::BadDescription(format!(
                        "`{key}` is not a table; write `[{key}]` and its keys below"
                    )));
                }
            }
        }
        let spec: Self = file.try_into().map_err(bad)?;
        spec.check()?;
        Ok(spec)
    }

    /// The machine file, with the complete drive of every axis.
    ///
    /// # Errors
    /// If a value has no form in TOML.
    pub fn to_toml(&self) -> Result<String, MachineError> {
        toml::to_string(self).map_err(|error| MachineError::BadDescription(error.to_string()))
    }
}

/// Merges the common drive into every axis of `kind`. The values of the axis have priority.
fn share_out(common: &Table, kind: &str, file: &mut Table) {
    let axes = file.get_mut("axes").and_then(Value::as_array_mut);
    for axis in axes.into_iter().flatten().filter_map(Value::as_table_mut) {
        if axis.get("kind").and_then(Value::as_str) != Some(kind) {
            continue;
        }
        match axis.get_mut("drive") {
            Some(Value::Table(own)) => fill(own, common),
            Some(_) => {}
            None => {
                axis.insert("drive".into(), Value::Table(common.clone()));
            }
        }
    }
}

/// Adds the keys of `common` that `own` lacks, table by table.
fn fill(own: &mut Table, common: &Table) {
    for (key, value) in common {
        match (own.get_mut(key), value) {
            (Some(Value::Table(own)), Value::Table(common)) => fill(own, common),
            (Some(_), _) => {}
            (None, value) => {
                own.insert(key.clone(), value.clone());
            }
        }
    }
}
