//! Shared by several test files.
#![allow(dead_code)]

use std::path::PathBuf;

use datasets::{Check, Log, Report, Severity};
use motion::{Axis, Trajectory};

/// A recorded log outside the project, or `None` (with a message) if it is missing.
pub fn shared(name: &str) -> Option<PathBuf> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data/logs");
    let path = PathBuf::from(folder).join(name);
    if path.exists() {
        return Some(path);
    }
    assert_ne!(std::env::var("CI").as_deref(), Ok("true"), "{name} is missing");
    println!("skipped: ../shared is not there");
    None
}

/// Ten seconds of two axes at 500 Hz, lagging by 6 ms, with a friction step and 0.1 µm of encoder ripple.
pub fn healthy() -> Log {
    let period_s = 0.002;
    let position = |axis: usize, t: f64| {
        let w = [1.3, 1.9][axis];
        [40.0, 25.0][axis] * (w * t).sin() + 6.0 * (2.7 * w * t + 1.0).sin()
    };
    let (mut reference, mut actual) = (Vec::new(), Vec::new());
    for axis in 0..2 {
        let times = (0..5000).map(|k| f64::from(k) * period_s);
        reference.push(times.clone().map(|t| position(axis, t)).collect());
        actual.push(
            times
                .map(|t| {
                    let delayed = t - 0.006;
                    let speed = (position(axis, t) - position(axis, delayed)) / 0.006;
                    position(axis, delayed) - 0.002 * (speed / 2.0).tanh() + 1e-4 * (t * 911.0).sin()
                })
                .collect(),
        );
    }
    log(period_s, reference, actual)
}

pub fn log(period_s: f64, reference: Vec<Vec<f64>>, actual: Vec<Vec<f64>>) -> Log {
    let axes: Vec<Axis> = ["x", "y", "z"][..reference.len()].iter().map(|name| Axis::named(name)).collect();
    Log::new(
        "made",
        Trajectory::new(period_s, axes.clone(), reference).unwrap(),
        Trajectory::new(period_s, axes, actual).unwrap(),
    )
    .unwrap()
}

/// The healthy log with its columns changed.
pub fn hurt(change: impl FnOnce(&mut Vec<Vec<f64>>, &mut Vec<Vec<f64>>)) -> Log {
    let healthy = healthy();
    let mut reference = healthy.reference.into_columns();
    let mut actual = healthy.actual.into_columns();
    change(&mut reference, &mut actual);
    log(0.002, reference, actual)
}

/// Asserts that a report has a finding of this check and severity whose line contains `words`.
pub fn assert_found(report: &Report, severity: Severity, check: Check, words: &str) {
    assert!(
        report
            .findings
            .iter()
            .any(|finding| finding.severity == severity && finding.check == check && finding.to_string().contains(words)),
        "no {severity:?} of {check:?} with `{words}` in:\n{report}"
    );
}
