//! Machine files: TOML input and output, with drive values common to all axes.

use toml::de::DeTable;
use toml::{Table, Value};

use super::check::in_range;
use super::faults::{FileFaults, Gathered, of_syntax};
use super::places::{Places, Step};
use super::{AxisSpec, ControllerSpec, KinematicsSpec, MachineSpec, structure};
use crate::MachineError;

impl MachineSpec {
    /// Reads a machine file. A top-level `[drive]` holds values common to all linear axes,
    /// `[rotary_drive]` those common to all rotary axes. The `drive` of an axis overrides them key
    /// by key.
    ///
    /// # Errors
    /// If the text is not TOML, keys are unknown or missing, or values are out of range: all of them with their places.
    pub fn from_toml(text: &str) -> Result<Self, MachineError> {
        read(
            text,
            |mut file, faults| {
                for (key, kind) in [("drive", "linear"), ("rotary_drive", "rotary")] {
                    match file.remove(key) {
                        None => {}
                        Some(Value::Table(common)) => share_out(&common, kind, &mut file),
                        Some(_) => faults.add(&[Step::key(key)], |label| {
                            format!("`{label}` is not a table; write `[{label}]` and its keys below")
                        }),
                    }
                }
                check_ranges(&Value::Table(file.clone()), &mut Vec::new(), faults);
                let axes = axes(&mut file, faults);
                let kinematics = kinematics(&mut file, faults);
                let rest = structure::read::<Self>(file, &[], faults)?;
                Some(Self { axes, kinematics: kinematics.unwrap_or(rest.kinematics), ..rest })
            },
            Self::check,
        )
    }

    /// The machine file, with the complete drive of every axis.
    ///
    /// # Errors
    /// If a value has no form in TOML.
    pub fn to_toml(&self) -> Result<String, MachineError> {
        toml::to_string(self).map_err(|error| MachineError::BadDescription(error.to_string()))
    }
}

impl ControllerSpec {
    /// Reads a controller profile: the keys of a machine file's `[controller]`, at top level.
    ///
    /// # Errors
    /// If the text is not TOML, keys are unknown or missing, or values are out of range: all of them with their places.
    pub fn from_toml(text: &str) -> Result<Self, MachineError> {
        read(text, |file, faults| structure::read(file, &[], faults), Self::check)
    }
}

/// Reads a file with `spec_of`, which notes faults, and checks what it states.
fn read<T>(
    text: &str,
    spec_of: impl FnOnce(Table, &mut Gathered<'_>) -> Option<T>,
    check: impl FnOnce(&T) -> Result<(), MachineError>,
) -> Result<T, MachineError> {
    let (root, errors) = DeTable::parse_recoverable(text);
    let places = Places::new(text, root.into_inner());
    if !errors.is_empty() {
        return Err(of_syntax(&errors, &places).into());
    }
    let file: Table = text.parse().map_err(|error| of_syntax(&[error], &places))?;
    let mut faults = Gathered::new(&places);
    let spec = spec_of(file, &mut faults);
    match (spec, faults.into_faults()) {
        (Some(spec), None) => match check(&spec) {
            Err(MachineError::BadDescription(message)) => Err(placed(message, &places).into()),
            checked => checked.map(|()| spec),
        },
        (_, Some(faults)) => Err(faults.into()),
        (None, None) => Err(MachineError::BadDescription("it cannot be read".into())),
    }
}

/// A fault that `check` found, at the place of the first key that its message quotes.
fn placed(message: String, places: &Places<'_>) -> FileFaults {
    let key = message.split('`').nth(1).unwrap_or_default().to_owned();
    // In a profile the keys of `[controller]` stand at top level.
    let key = key.strip_prefix("controller.").filter(|key| places.states(key)).unwrap_or(&key);
    FileFaults::one(places.of(&places.steps(key)), message)
}

/// The axes of a file, without which it is read on.
fn axes(file: &mut Table, faults: &mut Gathered<'_>) -> Vec<AxisSpec> {
    let Some(Value::Array(entries)) = file.get_mut("axes").map(|axes| std::mem::replace(axes, Value::Array(Vec::new()))) else {
        return Vec::new();
    };
    let axis = |(index, entry)| {
        let at = [Step::key("axes"), Step::Index(index)];
        let Value::Table(mut axis) = entry else {
            faults.add(&at, |label| format!("`{label}` is not a table; write `[[axes]]` and its keys below"));
            return None;
        };
        match axis.remove("kind").as_ref().map(|kind| kind.as_str()) {
            Some(Some("linear")) => structure::read(axis, &at, faults).map(AxisSpec::Linear),
            Some(Some("rotary")) => structure::read(axis, &at, faults).map(AxisSpec::Rotary),
            stated => {
                let [axes, index] = at;
                let wanted = "give `kind = \"linear\"` or `kind = \"rotary\"`";
                let fault = if stated.is_some() { "is none of these" } else { "is missing" };
                faults.add(&[axes, index, Step::key("kind")], |label| format!("`{label}` {fault}; {wanted}"));
                None
            }
        }
    };
    entries.into_iter().enumerate().filter_map(axis).collect()
}

/// Five-axis kinematics, taken out of the file.
fn kinematics(file: &mut Table, faults: &mut Gathered<'_>) -> Option<KinematicsSpec> {
    let stated = file.get("kinematics")?.as_table()?;
    if stated.get("kind").and_then(Value::as_str) != Some("five-axis") {
        return None;
    }
    let mut table = stated.clone();
    table.remove("kind");
    file.remove("kinematics");
    structure::read(table, &[Step::key("kinematics")], faults).map(KinematicsSpec::FiveAxis)
}

/// Notes every number of a file that is out of the range of its key.
fn check_ranges(value: &Value, path: &mut Vec<Step>, faults: &mut Gathered<'_>) {
    let number = match value {
        Value::Float(number) => *number,
        Value::Integer(number) => *number as f64,
        Value::Table(table) => {
            for (key, value) in table {
                path.push(Step::key(key));
                check_ranges(value, path, faults);
                path.pop();
            }
            return;
        }
        Value::Array(entries) => {
            for (index, value) in entries.iter().enumerate() {
                path.push(Step::Index(index));
                check_ranges(value, path, faults);
                path.pop();
            }
            return;
        }
        _ => return,
    };
    let label = faults.places.of(path).label;
    if let Err(MachineError::BadDescription(message)) = in_range(&label, number) {
        faults.add(path, |_| message);
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
