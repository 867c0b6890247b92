//! What the axes show at rest, over all runs: an offset between the columns, a drift, a scale that differs.
//!
//! Where the command of an axis rests, neither lag nor clocks matter: what is left is friction, and what the columns themselves are wrong by. On
//! logs of `random:2` to `random:60`, `ballscrew`, `maxwell` and `worn` (186 axes, 11 runs each) the figures below are at most 1.4, 3.3 and
//! 8.0 µm. On twenty others (`random:200` to `random:219`) none is above its bound; an offset of 20 µm, a drift of 20 µm and a scale of 0.2 % of one
//! axis are found on 20, 20 and 19.

use motion::AxisKind;

use super::digits::step_of;
use super::in_motion;
use super::signals::{Signals, quantile, range, with_common_axes};
use super::units::zero_apart;
use crate::{Check, Finding, Log, Report, Severity};

/// Least length of a rest, s, and the part of its end over which the error is averaged: axes settle for up to 0.2 s.
const RESTS_S: f64 = 0.3;
const AVERAGED_S: f64 = 0.1;
/// Travel of the actual position in that part from which on the axis does not rest, mm.
const AT_REST_MM: f64 = 0.1;
/// Median error at rest from which on the columns have different zeros, mm, and as a multiple of the spread of the errors.
const OFFSET_MM: f64 = 0.010;
const OF_SPREAD: f64 = 2.0;
/// Change of the error between two rests within `NEAR_MM` of each other from which on an axis drifts, mm, and in standard errors.
const DRIFT_MM: f64 = 0.008;
const NEAR_MM: f64 = 1.0;
/// Number of runs with such rests below which the change has to be larger, and how many times: one run of 15 s showed 8.0 µm of friction.
const FEW_CHANGES: usize = 3;
const FEW_OF: f64 = 1.5;
/// Change of few runs up to which it may be backlash and friction, whose side at the start of a run is not known, mm: a worn machine's.
const HYSTERESIS_MM: f64 = 0.05;
const STANDARD_ERRORS: f64 = 3.0;
/// The same as a multiple of what friction leaves between rests that are reached from either side: as much as that it can be without a drift.
const OF_FRICTION: f64 = 1.25;
/// Growth of the error over the positions of all rests from which on the scales differ: mm, as a multiple of what is left, per mm, and in
/// standard errors of the slope.
const GROWTH_MM: f64 = 0.012;
const OF_RESIDUAL: f64 = 4.0;
const LEAST_SLOPE: f64 = 150e-6;
const SURE: f64 = 6.0;
/// Least number of rests for a slope.
const FEWEST: usize = 6;
/// Steps of rounding that none of these may be.
const ROUNDED: f64 = 1.5;

/// A standstill of the command of one axis.
struct Rest {
    run: usize,
    position: f64,
    /// Actual position minus command, mm.
    error: f64,
    /// Direction from which the command came: −1, 0 or 1.
    from: f64,
}

/// Reports linear axes whose columns disagree at rest.
pub(super) fn check(logs: &[Log], report: &mut Report) {
    for axis in axes_of(logs) {
        let (rests, rounded) = at_rest(logs, axis);
        let offset = Offset::of(logs, axis, &rests, rounded);
        report.extend(zeros_of_runs(logs, axis, offset.as_ref().map_or(0.0, |offset| offset.mm)));
        let offset = offset.map(|offset| (Severity::Warn, offset.message));
        let found = offset.or_else(|| drift(&rests, rounded)).or_else(|| scale(&rests, rounded));
        if let Some((severity, message)) = found {
            let column = format!("{}_act", logs[0].axes()[axis]);
            report.push(Finding::new(severity, Check::Units, message).in_column(column));
        }
    }
}

/// The logs with the offsets of their actual positions taken off that [`assess_runs`](crate::assess_runs) warns of; `None` where there are none.
///
/// A constant offset is no error that a tool path can have: zero is set on the part.
#[must_use]
pub fn without_offsets(logs: &[Log]) -> Option<Vec<Log>> {
    let offset = |axis| {
        let (rests, rounded) = at_rest(logs, axis);
        Some((axis, Offset::of(logs, axis, &rests, rounded)?.mm))
    };
    let offsets: Vec<(usize, f64)> = axes_of(logs).into_iter().filter_map(offset).collect();
    let without = |log: &Log| {
        let mut columns = log.actual.columns().to_vec();
        for (axis, offset_mm) in &offsets {
            columns[*axis].iter_mut().for_each(|value| *value -= offset_mm);
        }
        let actual = log.actual.with_columns(columns).ok()?;
        Some(Log { actual, ..log.clone() })
    };
    if offsets.is_empty() { None } else { logs.iter().map(without).collect() }
}

/// An offset of the actual positions of an axis from their commands, and what to say of it.
struct Offset {
    mm: f64,
    message: String,
}

impl Offset {
    /// Of what rests; of what moves where nothing rests.
    fn of(logs: &[Log], axis: usize, rests: &[Rest], rounded: f64) -> Option<Self> {
        if rests.is_empty() {
            let mm = in_motion::offset_mm(logs, axis)?;
            return Some(Self { mm, message: in_motion::message(mm) });
        }
        let mm = offset_mm(rests, rounded)?;
        Some(Self { mm, message: offset_message(mm, rests.len()) })
    }
}

/// Runs whose zeros differ though the offset of all runs is taken off.
fn zeros_of_runs(logs: &[Log], axis: usize, offset_mm: f64) -> Report {
    let mut report = Report::default();
    for log in logs {
        let signals = Signals::of(log);
        let Some(mean) = signals.get(axis).filter(|axis| axis.moves()).and_then(|axis| zero_apart(axis, offset_mm)) else {
            continue;
        };
        let message = format!(
            "command and actual position differ by {mean:.4} mm throughout this run, and otherwise in others: zeros were set between the runs; subtract \
             the offset from the column of this file, or leave the run out"
        );
        let mut finding = Finding::new(Severity::Refuse, Check::Units, message).in_column(signals[axis].actual_name());
        finding.place.run = Some(log.name.clone());
        report.push(finding);
    }
    report
}

/// The linear axes, where all runs have the same.
fn axes_of(logs: &[Log]) -> Vec<usize> {
    let Some(first) = with_common_axes(logs) else { return Vec::new() };
    (0..first.axes().len()).filter(|axis| first.axes()[*axis].kind == AxisKind::Linear).collect()
}

/// The rests of an axis in all runs, and what rounding alone may differ by, mm.
fn at_rest(logs: &[Log], axis: usize) -> (Vec<Rest>, f64) {
    let rests = logs.iter().enumerate().flat_map(|(run, log)| rests_of(run, log, axis)).collect();
    let steps = logs.iter().filter_map(|log| step_of(&log.actual.columns()[axis]));
    (rests, ROUNDED * steps.fold(0.0, f64::max))
}

fn rests_of(run: usize, log: &Log, axis: usize) -> Vec<Rest> {
    let (command, actual) = (&log.reference.columns()[axis], &log.actual.columns()[axis]);
    let rows = |seconds: f64| (seconds / log.period_s()).round().max(1.0) as usize;
    let (least, averaged) = (rows(RESTS_S), rows(AVERAGED_S));
    let (mut rests, mut start) = (Vec::new(), 0);
    for end in 1..=command.len() {
        if end < command.len() && command[end] == command[start] {
            continue;
        }
        if end - start >= least {
            let of = end - averaged.min(end - start)..end;
            if range(&actual[of.clone()]) > AT_REST_MM {
                start = end;
                continue;
            }
            let error = of.clone().map(|k| actual[k] - command[k]).sum::<f64>() / of.len() as f64;
            let from = if start > 0 { (command[start] - command[start - 1]).signum() } else { 0.0 };
            rests.push(Rest { run, position: command[start], error, from });
        }
        start = end;
    }
    rests
}

/// A median error that friction does not explain, mm.
fn offset_mm(rests: &[Rest], rounded: f64) -> Option<f64> {
    let mut errors: Vec<f64> = rests.iter().map(|rest| rest.error).collect();
    let median = motion::quantile(&mut errors, 0.5)?;
    let spread = quantile(&rests.iter().map(|rest| rest.error - median).collect::<Vec<_>>(), 0.9);
    (median.abs() > OFFSET_MM.max(OF_SPREAD * spread).max(rounded)).then_some(median)
}

fn offset_message(offset_mm: f64, rests: usize) -> String {
    format!(
        "at rest the actual position stands {offset_mm:.4} mm beside its command (median of {rests} rests): the columns have different zeros; \
         training takes this offset off"
    )
}

/// A change of the error between the first rest of a run and its last one at the same place, beyond what friction leaves on either side.
fn drift(rests: &[Rest], rounded: f64) -> Option<(Severity, String)> {
    let changes: Vec<f64> = rests
        .chunk_by(|a, b| a.run == b.run)
        .filter_map(|run| {
            let first = run.first()?;
            let last = run[1..].iter().rev().find(|rest| (rest.position - first.position).abs() <= NEAR_MM)?;
            Some(last.error - first.error)
        })
        .collect();
    let count = changes.len() as f64;
    let mean = changes.iter().sum::<f64>() / count;
    let variance = changes.iter().map(|change| (change - mean).powi(2)).sum::<f64>() / (count - 1.0).max(1.0);
    let message = format!(
        "between two rests at one place in a run the actual position drifts against its command, by {mean:.4} mm in the mean of {} runs: counts \
         are lost, or a scale warms up; mend the encoder, or log a warm machine",
        changes.len()
    );
    let of = |from: f64| {
        let errors: Vec<f64> = rests.iter().filter(|rest| rest.from == from).map(|rest| rest.error).collect();
        errors.iter().sum::<f64>() / errors.len() as f64
    };
    // NaN where all rests come from one side counts as none.
    let friction = OF_FRICTION * (of(1.0) - of(-1.0)).abs();
    // A few changes do not show how much they differ.
    let least = if changes.len() < FEW_CHANGES { FEW_OF * DRIFT_MM } else { DRIFT_MM };
    let least = least.max(STANDARD_ERRORS * (variance / count).sqrt()).max(rounded).max(friction);
    // NaN without such rests.
    let drifts = mean.abs() > least;
    let may_be_hysteresis = changes.len() < FEW_CHANGES && mean.abs() <= HYSTERESIS_MM && !friction.is_finite();
    drifts.then(|| {
        if may_be_hysteresis {
            let why = "; or backlash and friction hold it on either side of the place, which a run that comes there from both would show";
            (Severity::Warn, format!("{message}{why}"))
        } else {
            (Severity::Refuse, message)
        }
    })
}

/// An error that grows with the position.
fn scale(rests: &[Rest], rounded: f64) -> Option<(Severity, String)> {
    if rests.len() < FEWEST {
        return None;
    }
    let count = rests.len() as f64;
    let mean = |of: &dyn Fn(&Rest) -> f64| rests.iter().map(of).sum::<f64>() / count;
    let (position, from, error) = (mean(&|rest| rest.position), mean(&|rest| rest.from), mean(&|rest| rest.error));
    // Least squares for a slope over the position beside one over the direction, which friction has.
    let (mut pp, mut pd, mut dd, mut pe, mut de) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for rest in rests {
        let (p, d, e) = (rest.position - position, rest.from - from, rest.error - error);
        (pp, pd, dd, pe, de) = (pp + p * p, pd + p * d, dd + d * d, pe + p * e, de + d * e);
    }
    // Without a second direction there is no slope over it.
    let own = if dd > 0.0 { pp - pd * pd / dd } else { pp };
    let slope = if dd > 0.0 { (pe - pd * de / dd) / own } else { pe / own };
    let by_direction = if dd > 0.0 { (de - pd * slope) / dd } else { 0.0 };
    let left = |rest: &Rest| rest.error - error - slope * (rest.position - position) - by_direction * (rest.from - from);
    let residual = (rests.iter().map(|rest| left(rest).powi(2)).sum::<f64>() / (count - 3.0)).sqrt();
    let ends = rests.iter().map(|rest| rest.position);
    let span = ends.clone().fold(f64::NEG_INFINITY, f64::max) - ends.fold(f64::INFINITY, f64::min);
    let growth = slope.abs() * span;
    let is_sure = slope.abs() > LEAST_SLOPE && slope.abs() * own.sqrt() > SURE * residual;
    let message = format!(
        "at rest the error grows with the position, by {:.4} mm over {span:.1} mm ({:.2} %): the scale of the encoder or of the column is off, \
         unless the machine itself is; a model takes it for the machine's",
        slope * span,
        100.0 * slope
    );
    (is_sure && growth > GROWTH_MM.max(OF_RESIDUAL * residual).max(rounded)).then_some((Severity::Warn, message))
}
