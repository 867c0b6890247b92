//! Thresholds of the verdicts.

use crate::finding::{Estimate, Verdict};

/// A single cause may use up a tenth of a tolerance. Good: a tenth of IT6, fair: a tenth of IT8, both for 30 to 50 mm (ISO 286-1:2010,
/// table 1: 16 µm and 39 µm). Neither ISO 230-2 nor ISO 230-4 states limits: they leave them to supplier and user.
pub const GOOD_UM: f64 = 1.6;
/// See [`GOOD_UM`].
pub const FAIR_UM: f64 = 3.9;

/// In words, for print and report.
pub const SOURCE: &str =
    "good below 1.6 µm, poor above 3.9 µm: a tenth of the tolerances IT6 and IT8 of a 30 to 50 mm feature (ISO 286-1)";

/// Verdict on a deviation. An interval that reaches the next better class does not make the verdict worse.
#[must_use]
pub fn of_deviation(effect_um: &Estimate) -> Verdict {
    // What is certain: the lower end, where the interval is wide against the value.
    let size = effect_um.value.abs();
    match size {
        _ if size <= GOOD_UM => Verdict::Good,
        _ if size <= FAIR_UM => Verdict::Fair,
        _ => Verdict::Poor,
    }
}
