//! Path ranges outside the operating range of a model.

use std::collections::BTreeMap;

use models::Outside;
use motion::Trajectory;

/// A range of samples in which an axis leaves the operating range of the model, for one reason.
#[derive(Debug, Clone, PartialEq)]
pub struct OutsideRange {
    /// Name of the axis.
    pub axis: String,
    /// Reason.
    pub reason: Outside,
    /// First sample.
    pub first: usize,
    /// Last sample.
    pub last: usize,
    /// Number of samples in the range that lie outside.
    pub samples: usize,
    /// Whether the correction fades there. Otherwise only position-dependent terms fade.
    pub fades: bool,
}

/// Share of a correction above which it does not count as faded, mean over the range.
const MOSTLY: f64 = 0.95;

/// Ranges of all axes, one for each axis and reason.
pub(super) fn ranges(path: &Trajectory, reasons: &[Vec<Option<Outside>>], weights: &[f64]) -> Vec<OutsideRange> {
    let mut found = Vec::new();
    for (axis, reasons) in path.axes().iter().zip(reasons) {
        let mut by_reason: BTreeMap<String, OutsideRange> = BTreeMap::new();
        let mut kept: BTreeMap<String, f64> = BTreeMap::new();
        for (k, reason) in reasons.iter().enumerate() {
            if let Some(reason) = reason {
                let entry = by_reason.entry(reason.to_string()).or_insert_with(|| OutsideRange {
                    axis: axis.name.clone(),
                    reason: *reason,
                    first: k,
                    last: k,
                    samples: 0,
                    fades: false,
                });
                entry.last = k;
                entry.samples += 1;
                kept.entry(reason.to_string()).and_modify(|sum| *sum += weights[k]).or_insert(weights[k]);
            }
        }
        for (reason, kept) in kept {
            if let Some(range) = by_reason.get_mut(&reason) {
                range.fades = kept < MOSTLY * range.samples as f64;
            }
        }
        found.extend(by_reason.into_values());
    }
    found
}
