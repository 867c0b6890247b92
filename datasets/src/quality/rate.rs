//! Sampling rate and length.

use super::purpose::Purpose;
use crate::{Check, Finding, Log, Report, Severity};

/// Lowest sampling rate for training, Hz: below it reversals and starts fall between samples.
pub const SLOWEST_HZ: f64 = 50.0;
/// Rate below which the peaks at reversals are flattened, Hz.
const SLOW_HZ: f64 = 100.0;
/// Highest sampling rate for training, Hz, and that of the fastest position loops.
const FASTEST_HZ: f64 = 25_000.0;
const FASTEST_LOOP_HZ: f64 = 10_000.0;
/// Minimum number of samples for any check.
pub(crate) const FEWEST_SAMPLES: usize = 50;
/// Shortest useful run for training, s.
pub(crate) const SHORT_S: f64 = 1.0;

pub(super) fn check(log: &Log, purpose: Purpose, report: &mut Report) {
    let rate_hz = 1.0 / log.period_s();
    if rate_hz < SLOWEST_HZ * (1.0 - 1e-6) {
        report.push(Finding::new(
            purpose.grave(),
            Check::Rate,
            format!(
                "sampled at {rate_hz:.3} Hz (every {:.3} ms); training needs at least {SLOWEST_HZ} Hz: log at the servo rate. If the time \
                 column is not in s, say so in the column mapping, as `t=time:ms`",
                1e3 * log.period_s()
            ),
        ));
    } else if rate_hz < SLOW_HZ {
        report.push(Finding::new(
            Severity::Warn,
            Check::Rate,
            format!("sampled at {rate_hz:.1} Hz: peaks at reversals fall between samples; log at 250 Hz or more"),
        ));
    }
    if rate_hz > FASTEST_HZ {
        report.push(Finding::new(
            purpose.grave(),
            Check::Rate,
            format!(
                "sampled at {rate_hz:.0} Hz, faster than position loops run: state the unit of the time column in the column mapping, as `t=time:min`; \
                 without one, the period in ms (--period 1); or keep one row in {:.0}",
                (rate_hz / FASTEST_LOOP_HZ).ceil()
            ),
        ));
    }
    let duration_s = log.reference.duration_s();
    if log.len() < FEWEST_SAMPLES {
        report.push(Finding::new(
            Severity::Refuse,
            Check::Rate,
            format!("only {} samples; at least {FEWEST_SAMPLES} are needed", log.len()),
        ));
    } else if duration_s < SHORT_S && purpose == Purpose::Training {
        report.push(Finding::new(
            Severity::Warn,
            Check::Rate,
            format!("the run lasts {duration_s:.2} s; runs of several seconds teach more"),
        ));
    }
}
