//! Range checks. Errors name the key and the remedy.

use super::ranges::range_of;
use crate::MachineError;

/// Key names of a drive in the file, as pairs of a linear drive's key and its replacement. Equal
/// keys are omitted.
#[derive(Debug, Clone, Copy)]
pub(super) struct Names(pub(super) &'static [(&'static str, &'static str)]);

impl Names {
    /// The keys of a linear drive.
    pub(super) const LINEAR: Self = Self(&[]);

    /// Key in the file for `key`.
    pub(super) fn of(self, key: &str) -> &str {
        self.0.iter().find(|(linear, _)| *linear == key).map_or(key, |(_, own)| own)
    }
}

/// Refuses `value` unless it is positive, and within the range of `key`.
pub(super) fn positive(key: &str, value: f64) -> Result<(), MachineError> {
    ranged(key, value, value > 0.0, "positive and finite")
}

/// Refuses `value` unless it is zero or more, and within the range of `key`.
pub(super) fn not_negative(key: &str, value: f64) -> Result<(), MachineError> {
    ranged(key, value, value >= 0.0, "zero or more, and finite")
}

/// Refuses `value` unless it is within the range of `key`.
pub(super) fn finite(key: &str, value: f64) -> Result<(), MachineError> {
    ranged(key, value, true, "finite")
}

fn ranged(key: &str, value: f64, holds: bool, remedy: &str) -> Result<(), MachineError> {
    match range_of(key) {
        Some((low, high)) => {
            let fits = holds && (low..=high).contains(&value);
            within(key, value, fits, &format!("{remedy}, from {} to {}", shown(low), shown(high)))
        }
        None => within(key, value, holds, remedy),
    }
}

/// A bound in readable form.
fn shown(bound: f64) -> String {
    if bound == 0.0 || (1e-3..1e5).contains(&bound.abs()) { bound.to_string() } else { format!("{bound:e}") }
}

/// Refuses `value` unless it is within the range of `key`, where that has one.
pub(super) fn in_range(key: &str, value: f64) -> Result<(), MachineError> {
    match range_of(key) {
        None => Ok(()),
        Some((low, _)) if low > 0.0 => positive(key, value),
        Some((0.0, _)) => not_negative(key, value),
        Some(_) => finite(key, value),
    }
}

/// Refuses `value` unless it is finite and in 0..=1.
pub(super) fn share(key: &str, value: f64) -> Result<(), MachineError> {
    within(key, value, (0.0..=1.0).contains(&value), "a share between 0 and 1")
}

/// Refuses `value` unless it is finite and `holds`.
pub(super) fn within(key: &str, value: f64, holds: bool, remedy: &str) -> Result<(), MachineError> {
    if value.is_finite() && holds {
        Ok(())
    } else {
        Err(MachineError::BadDescription(format!("`{key}` is {}; it must be {remedy}", shown(value))))
    }
}

/// Number of times that `part` goes into `whole`. Refused unless a whole number, at least 1.
pub(super) fn multiple(whole_key: &str, whole: f64, part_key: &str, part: f64) -> Result<usize, MachineError> {
    let ratio = whole / part;
    let count = ratio.round();
    if ratio.is_finite() && (1.0..=1e6).contains(&count) && (ratio - count).abs() < 1e-6 * count {
        Ok(count as usize)
    } else {
        Err(MachineError::BadDescription(format!(
            "`{whole_key}` is {ratio} times `{part_key}`; it must be a whole multiple of it"
        )))
    }
}
