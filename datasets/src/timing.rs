//! From time stamps to a uniform rate.

use std::path::Path;

use crate::{Check, DatasetError, Finding, Severity};

/// Deviation from the uniform grid, as a share of a period, above which a log is unevenly sampled.
pub(crate) const UNIFORM_SHARE: f64 = 0.05;
/// Deviation of an interval, as a share of the period, above which the report counts it.
const OFF_SHARE: f64 = 0.25;
/// Longest gap, in periods, that is interpolated; a longer one is a loss of rows.
const BRIDGED_PERIODS: f64 = 10.5;
/// Maximum number of gaps reported one by one.
const LISTED: usize = 5;

/// Timing of the samples of a log.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Timing {
    /// Period of the uniform grid, s.
    pub period_s: f64,
    /// Whether the columns must be interpolated onto the grid.
    pub resample: bool,
    pub findings: Vec<Finding>,
}

/// Determines the period of time stamps (s, one per row) and their faults.
pub(crate) fn settle(path: &Path, times: &[f64], lines: &[usize]) -> Result<Timing, DatasetError> {
    let count = times.len();
    let (Some(first), Some(last)) = (times.first(), times.last()) else {
        return Err(too_short(path, count));
    };
    if count < 4 {
        return Err(too_short(path, count));
    }
    let mean_s = (last - first) / (count - 1) as f64;
    if !mean_s.is_finite() {
        return Err(DatasetError::format(path, "the time stamps are too large to be seconds; mend them"));
    }
    let intervals: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let off_grid = times.iter().enumerate().map(|(k, time)| (time - first - k as f64 * mean_s).abs()).fold(0.0, f64::max);
    let backward = intervals.iter().position(|interval| *interval < 0.0);
    if mean_s > 0.0 && off_grid <= UNIFORM_SHARE * mean_s {
        return Ok(Timing { period_s: uniform_period_s(mean_s), resample: false, findings: Vec::new() });
    }
    let stalled = intervals.iter().position(|interval| *interval == 0.0);
    let resolution_s = intervals.iter().copied().filter(|interval| *interval > 0.0).fold(f64::INFINITY, f64::min);
    if backward.is_none() && stalled.is_some() && off_grid <= 1.01 * resolution_s && mean_s > 0.0 {
        return Ok(Timing {
            period_s: uniform_period_s(mean_s),
            resample: false,
            findings: vec![Finding::new(
                Severity::Warn,
                Check::Timing,
                format!(
                    "the time stamps have a step of {:.3} ms, coarser than the sampling; the rows were taken as evenly spaced by {:.6} ms",
                    1e3 * resolution_s,
                    1e3 * mean_s
                ),
            )],
        });
    }
    if let Some(k) = backward.or(stalled) {
        return Err(DatasetError::TimeOrder {
            path: path.to_owned(),
            line: lines.get(k + 1).copied().unwrap_or(k + 2),
            time_s: times[k + 1],
            before_s: times[k],
        });
    }
    let period_s = grid_period_s(&intervals);
    check_span(path, &intervals, period_s, lines)?;
    Ok(Timing { period_s, resample: true, findings: report(times, &intervals, period_s, lines) })
}

/// The period of even time stamps that are `mean_s` apart, s.
pub(crate) fn uniform_period_s(mean_s: f64) -> f64 {
    snap(mean_s, 1e-6, 1e-4)
}

fn too_short(path: &Path, rows: usize) -> DatasetError {
    DatasetError::TooShort { path: path.to_owned(), rows, needed: 4 }
}

/// Refuses stamps whose grid would have far more rows than the log: a clock change or a damaged
/// number.
fn check_span(path: &Path, intervals: &[f64], period_s: f64, lines: &[usize]) -> Result<(), DatasetError> {
    let span_s: f64 = intervals.iter().sum();
    if span_s / period_s <= BRIDGED_PERIODS * intervals.len() as f64 {
        return Ok(());
    }
    let longest = intervals.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(k, _)| k);
    let line = lines.get(longest).copied().unwrap_or(longest + 1);
    let jump_s = intervals[longest];
    let message =
        format!("the time stamp jumps by {jump_s} s after line {line}; cut the file there into two runs, or mend the stamp");
    Err(DatasetError::format(path, message))
}

/// A step of the time stamps over which rows are lost that cannot be interpolated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Gap {
    /// Index of the row before it.
    pub row: usize,
    /// Its length, s.
    pub step_s: f64,
    /// Number of the lost rows.
    pub lost: f64,
}

/// The gaps of time stamps; none where they go back, or do not advance at all.
pub(crate) fn gaps(times: &[f64]) -> Vec<Gap> {
    let steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    // Stamps coarser than the sampling stand still between their steps.
    let forward: Vec<f64> = steps.iter().copied().filter(|step| *step != 0.0).collect();
    if forward.is_empty() || forward.iter().any(|step| !step.is_finite() || *step < 0.0) {
        return Vec::new();
    }
    let (shortest, longest) =
        forward.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), step| (low.min(*step), high.max(*step)));
    if longest < 0.5 * BRIDGED_PERIODS * shortest {
        return Vec::new();
    }
    let period_s = grid_period_s(&forward);
    let long = steps.iter().enumerate().filter(|(_, step)| **step > BRIDGED_PERIODS * period_s);
    long.map(|(row, step)| Gap { row, step_s: *step, lost: step / period_s - 1.0 }).collect()
}

/// Mean distance of intervals from multiples of a period, as a share of it, from which on they scatter about their mean instead: 0.25 for
/// stamps that are late at random.
const SCATTERED: f64 = 0.12;
/// The same from which on the period is a round number where one is near: runs of one recorder then have the same.
const UNSTEADY: f64 = 0.03;
/// Round numbers between 1 and 10, and the distance up to which a period is one of them. A timer of 10 ms that is late by 1 ms in the mean gives 9.9 to 10.0.
const ROUND: [f64; 9] = [1.0, 1.25, 1.6, 2.0, 2.5, 4.0, 5.0, 8.0, 10.0];
const NEAR_ROUND: f64 = 0.02;
/// Intervals beyond this multiple of the median are gaps.
const GAP: f64 = 2.5;
/// Longest interval between stamps of successive rows, as a multiple of the period: the first is on time, the second late by nearly all of it.
const LATEST: f64 = 1.95;

/// Period of the grid for these intervals, s.
fn grid_period_s(intervals: &[f64]) -> f64 {
    let base_s = base_period_s(intervals);
    let scatter = scatter(intervals, base_s);
    let mut period_s = base_s;
    if scatter > SCATTERED {
        let mut sorted = intervals.to_vec();
        sorted.sort_by(f64::total_cmp);
        let shorter = &sorted[..sorted.partition_point(|interval| *interval <= GAP * sorted[sorted.len() / 2])];
        let mean_s = shorter.iter().sum::<f64>() / shorter.len().max(1) as f64;
        // Rows that were lost count, where no stamp can be that late.
        let rows = |interval: &f64| if *interval > LATEST * mean_s { (interval / mean_s).round() } else { 1.0 };
        period_s = intervals.iter().sum::<f64>() / intervals.iter().map(rows).sum::<f64>();
    }
    let decade = 10.0_f64.powf(period_s.log10().floor());
    let round = ROUND.map(|number| number * decade).into_iter().find(|round| (round - period_s).abs() <= NEAR_ROUND * period_s);
    match round.filter(|_| scatter > UNSTEADY) {
        Some(round) => snap(round, 1e-6, 1e-4),
        None => snap(period_s, 1e-4, 1e-2),
    }
}

/// Mean distance of intervals from multiples of a period, as a share of it.
fn scatter(intervals: &[f64], period_s: f64) -> f64 {
    let off = |interval: &f64| (interval / period_s - (interval / period_s).round().max(1.0)).abs();
    intervals.iter().map(off).sum::<f64>() / intervals.len().max(1) as f64
}

/// The period whose multiples the intervals are: the median of the short intervals first, then the
/// mean over all multiples.
pub(crate) fn base_period_s(intervals: &[f64]) -> f64 {
    let mut sorted = intervals.to_vec();
    sorted.sort_by(f64::total_cmp);
    let short = 1.5 * sorted[sorted.len() / 10];
    let shorter = sorted.partition_point(|interval| *interval <= short).max(1);
    let median_s = sorted[(shorter - 1) / 2];
    let multiples: f64 = intervals.iter().map(|interval| (interval / median_s).round().max(1.0)).sum();
    intervals.iter().sum::<f64>() / multiples
}

/// The nearest multiple of `step` within a relative `tolerance`.
pub(crate) fn snap(period_s: f64, step: f64, tolerance: f64) -> f64 {
    // Division by an integer gives the nearest double: 8 ms is exactly 0.008.
    let per_second = (1.0 / step).round();
    let snapped = (period_s * per_second).round() / per_second;
    if snapped > 0.0 && (snapped - period_s).abs() <= tolerance * period_s { snapped } else { period_s }
}

fn report(times: &[f64], intervals: &[f64], period_s: f64, lines: &[usize]) -> Vec<Finding> {
    let off = intervals.iter().filter(|interval| (**interval - period_s).abs() > OFF_SHARE * period_s).count();
    let shortest = intervals.iter().copied().fold(f64::INFINITY, f64::min);
    let longest = intervals.iter().copied().fold(0.0, f64::max);
    let counted = match off {
        0 => "uneven intervals: ".to_owned(),
        _ => format!(
            "{off} of {} intervals are off {:.3} ms by more than {:.0} %: ",
            intervals.len(),
            1e3 * period_s,
            100.0 * OFF_SHARE
        ),
    };
    let mut findings = vec![Finding::new(
        Severity::Warn,
        Check::Timing,
        format!(
            "{counted}shortest {:.3} ms, longest {:.3} ms; the log was resampled onto a uniform grid of {:.3} ms by cubic interpolation: fast detail \
             between distant samples is lost; log at a fixed rate",
            1e3 * shortest,
            1e3 * longest,
            1e3 * period_s
        ),
    )];
    let gaps = intervals.iter().enumerate().filter(|(_, interval)| **interval > BRIDGED_PERIODS * period_s);
    for (k, interval) in gaps.take(LISTED) {
        let mut gap = Finding::new(
            Severity::Refuse,
            Check::Timing,
            format!(
                "{:.0} rows are missing after line {}; cut the file there into two runs",
                interval / period_s - 1.0,
                lines.get(k).copied().unwrap_or(k + 1)
            ),
        );
        gap.place.time_s = Some(times[k] - times[0]);
        findings.push(gap);
    }
    findings
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settled(times: &[f64]) -> Result<Timing, DatasetError> {
        let lines: Vec<usize> = (2..times.len() + 2).collect();
        settle(Path::new("log.csv"), times, &lines)
    }

    #[test]
    fn an_even_log_stays_as_it_is() {
        let times: Vec<f64> = (0..1000).map(|k| 3.0 + 0.002 * f64::from(k)).collect();
        let timing = settled(&times).unwrap();
        assert_eq!((timing.period_s, timing.resample), (0.002, false));
    }

    #[test]
    fn gaps_count_as_multiples_of_the_period() {
        let mut time = 0.0;
        let times: Vec<f64> = (0..999)
            .map(|k| {
                time += if k % 2 == 0 { 0.008 } else { 0.024 };
                time
            })
            .collect();
        let timing = settled(&times).unwrap();
        assert_eq!(timing.period_s, 0.008);
        assert!(timing.resample);
        assert!(timing.findings[0].message.starts_with("499 of 998 intervals"));
    }

    #[test]
    fn stamps_that_are_late_at_random_have_the_period_of_their_timer() {
        let mut state = 1_u64;
        let mut unit = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        for run in 0..4 {
            // Late by up to 0.9 of a period; and a timer that counts anew after every row.
            let late: Vec<f64> = (0..4000).map(|k| 0.001 * (f64::from(k) + 0.9 * unit())).collect();
            assert_eq!(settled(&late).unwrap().period_s, 0.001, "{run}");
            let mut time = 0.0;
            let timer = std::iter::repeat_with(|| {
                time += 0.009 - 0.001 * unit().max(1e-9).ln();
                time
            });
            assert_eq!(settled(&timer.take(3000).collect::<Vec<_>>()).unwrap().period_s, 0.01, "{run}");
        }
    }

    #[test]
    fn gaps_are_steps_over_lost_rows() {
        let mut times: Vec<f64> = (0..100).map(|k| 0.002 * f64::from(k)).collect();
        assert_eq!(gaps(&times), []);
        // Ten lost rows are interpolated, more are a gap.
        times[30..].iter_mut().for_each(|time| *time += 0.018);
        assert_eq!(gaps(&times), []);
        times[60..].iter_mut().for_each(|time| *time += 0.1);
        let found = gaps(&times);
        assert_eq!((found.len(), found[0].row), (1, 59));
        assert!((found[0].step_s - 0.102).abs() < 1e-9 && (found[0].lost - 50.0).abs() < 1e-6, "{found:?}");
        let coarse: Vec<f64> = (0..100).map(|k| f64::from(k / 2) * 0.001 + if k < 50 { 0.0 } else { 1.0 }).collect();
        assert_eq!(gaps(&coarse).len(), 1);
        times[90] = 0.0;
        assert_eq!(gaps(&times), []);
        assert_eq!(gaps(&[1.0; 9]), []);
    }

    #[test]
    fn stamps_going_back_are_refused_with_their_line() {
        let error = settled(&[0.0, 0.1, 0.2, 0.15, 0.3]).unwrap_err();
        assert!(matches!(error, DatasetError::TimeOrder { line: 5, .. }), "{error}");
    }

    #[test]
    fn a_stamp_that_jumps_is_refused_before_a_grid_is_laid() {
        let mut times: Vec<f64> = (0..100).map(|k| 0.001 * f64::from(k)).collect();
        times[60..].iter_mut().for_each(|time| *time += 1.0e9);
        let error = settled(&times).unwrap_err().to_string();
        assert!(error.contains("after line 61;"), "{error}");
        times[60..].iter_mut().for_each(|time| *time *= 1e298);
        assert!(settled(&times).is_err());
        times[0] = -f64::MAX;
        assert!(settled(&times).is_err());
    }

    #[test]
    fn coarse_stamps_are_taken_as_even() {
        let times: Vec<f64> = (0..100).map(|k| f64::from(k / 2) * 0.001).collect();
        let timing = settled(&times).unwrap();
        assert!(!timing.resample);
        assert!((timing.period_s - 0.0005).abs() < 1e-5);
        assert_eq!(timing.findings[0].severity, Severity::Warn);
    }
}
