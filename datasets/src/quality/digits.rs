//! Digits: rounding of the positions, detected as a grid that contains all values.

use super::purpose::Purpose;
use super::signals::{Signals, rms};
use crate::{Check, Finding, Report, Severity};

/// Rounding that degrades a model: 10 µm cost 8 µm of accuracy, 0.1 mrad the same at 100 mm.
const COARSE: (f64, f64) = (0.01, 1e-4);
/// Rounding that prevents learning: 100 µm cost 30 µm.
const TOO_COARSE: (f64, f64) = (0.1, 1e-3);
/// Ratio of the rounding to the tracking error above which a model would mostly learn rounding.
const SHARE_OF_ERROR: f64 = 0.5;
/// Differences below this share of the values are floating-point rounding.
const LAST_BITS: f64 = 1e-12;

pub(super) fn check(axis: &Signals, purpose: Purpose, report: &mut Report) {
    for (values, name) in [(axis.reference, axis.reference_name()), (axis.actual, axis.actual_name())] {
        let Some(step) = step_of(values) else {
            continue;
        };
        let coarse = axis.of_kind(COARSE.0, COARSE.1);
        let too_coarse = axis.of_kind(TOO_COARSE.0, TOO_COARSE.1);
        // By subtraction a step of 0.01 is a few bits smaller.
        let at_least = |limit: f64| step >= limit * (1.0 - 1e-6);
        let of_error = step > SHARE_OF_ERROR * rms(&axis.error) && at_least(0.1 * coarse);
        let severity = if at_least(too_coarse) {
            purpose.grave()
        } else if at_least(coarse) || of_error {
            Severity::Warn
        } else {
            continue;
        };
        report.push(
            Finding::new(
                severity,
                Check::Digits,
                format!(
                    "positions are rounded to steps of {} {} ({} significant digits) against a tracking error of {:.4} {} RMS; log with at \
                     least 1e-4 mm or 1e-6 rad",
                    short(step),
                    axis.unit(),
                    significant_digits(values, step),
                    rms(&axis.error),
                    axis.unit()
                ),
            )
            .in_column(name),
        );
    }
}

fn short(step: f64) -> String {
    let text = format!("{step:.9}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// The step of the grid that contains all values; `None` if there is none.
///
/// The candidate is the smallest distance of two different values. Rounded values are integer
/// multiples of it, others are not.
pub(crate) fn step_of(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let size = sorted.first()?.abs().max(sorted.last()?.abs());
    let step =
        sorted.windows(2).map(|pair| pair[1] - pair[0]).filter(|gap| *gap > LAST_BITS * size).fold(f64::INFINITY, f64::min);
    if !step.is_finite() || step <= 0.0 {
        return None;
    }
    let on_grid = sorted
        .iter()
        .filter(|value| {
            let multiple = (*value - sorted[0]) / step;
            (multiple - multiple.round()).abs() < 0.01
        })
        .count();
    (on_grid as f64 > 0.99 * sorted.len() as f64).then_some(step)
}

/// Decimal digits of the largest value at this step.
pub(crate) fn significant_digits(values: &[f64], step: f64) -> usize {
    let largest = super::signals::largest(values);
    if largest < step {
        return 1;
    }
    (largest / step + 1e-6).log10().floor() as usize + 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_step_of_rounded_values_is_found_and_of_others_is_not() {
        let smooth: Vec<f64> = (0..5000).map(|k| 40.0 * (f64::from(k) * 0.00123).sin()).collect();
        for step in [0.1, 0.01, 0.001] {
            let rounded: Vec<f64> = smooth.iter().map(|v| (v / step).round() * step).collect();
            let found = step_of(&rounded).unwrap();
            assert!((found - step).abs() < 1e-9, "{found}");
        }
        assert_eq!(step_of(&smooth), None);
        assert_eq!(step_of(&[1.0, 1.0]), None);
        assert_eq!(significant_digits(&[162.0], 1.0), 3);
        assert_eq!(significant_digits(&[100.0], 0.1), 4);
    }
}
