//! Implausible units and scales.

use super::purpose::Purpose;
use super::signals::{Signals, correlation, largest, quantile, range, rms};
use crate::{Check, Finding, Report, Severity};

/// Longest plausible linear travel, mm, and rotation, rad.
const TRAVEL: (f64, f64) = (2e4, 20.0);
/// Smallest linear travel, mm, of a run with an error below 1 µm; less is probably in m.
const TRAVEL_OF_METRES: f64 = 2.0;
/// Travel, mm, and speed, mm/s, below which an excitation is probably in inches: a twenty-fifth of
/// those of small machines.
const TRAVEL_OF_INCHES: f64 = 10.0;
const SPEED_OF_INCHES: f64 = 8.0;
/// Largest plausible speed, mm/s and rad/s.
const SPEED: (f64, f64) = (5e3, 200.0);
/// Quantile of the steps above whose implausible speed a log is refused.
const SURE: f64 = 0.95;
/// Largest deviation of the ratio of actual to command travel from 1.
const SCALE_SHARE: f64 = 0.05;
/// A mean offset above this multiple of the tracking error's spread, and above 1 mm or 10 mrad, is
/// a difference of zero points.
const OFFSET_SPREADS: f64 = 5.0;

/// A finding, its column, and the fault.
type Fault = (Severity, String, String);

/// Reports implausible units. Returns whether command and actual position have one unit.
pub(super) fn check(axis: &Signals, purpose: Purpose, report: &mut Report) -> bool {
    let different = different_travel(axis);
    let is_one = different.is_none();
    let faults = match different {
        Some(fault) => vec![fault],
        None => implausible_size(axis, purpose).into_iter().chain(different_zeros(axis, purpose)).collect(),
    };
    for (severity, column, message) in faults {
        report.push(Finding::new(severity, Check::Units, message).in_column(column));
    }
    is_one
}

/// Actual and command positions in different units.
fn different_travel(axis: &Signals) -> Option<Fault> {
    let (correlation, scale) = correlation(axis.reference, axis.actual);
    (correlation > 0.9 && (scale - 1.0).abs() > SCALE_SHARE).then(|| {
        let message = format!(
            "the actual position travels {scale:.6} times as far as the command{}; state the units in the column mapping",
            known_factor(scale)
        );
        (Severity::Refuse, axis.actual_name(), message)
    })
}

/// Positions or speeds of a size that suggests another unit.
fn implausible_size(axis: &Signals, purpose: Purpose) -> Option<Fault> {
    let travel = range(axis.reference).max(largest(axis.reference));
    let speed = largest(&axis.reference_steps) / axis.period_s;
    let (named, in_degrees) =
        if axis.unit() == "mm" { ("um", String::new()) } else { ("deg", format!(" ({:.0}°)", travel.to_degrees())) };
    let message = if travel > axis.of_kind(TRAVEL.0, TRAVEL.1) {
        format!(
            "positions reach {travel:.1} {}{in_degrees}; if that is not so, state their unit in the column mapping, as `{}:{named}`",
            axis.unit(),
            axis.axis
        )
    } else if speed > axis.of_kind(SPEED.0, SPEED.1) {
        format!("the command reaches {speed:.0} {}/s; check the units of positions and time, or look for a jump", axis.unit())
    } else if axis.unit() == "mm"
        && travel < TRAVEL_OF_METRES
        && speed < TRAVEL_OF_METRES
        && rms(&axis.error) < 1e-3
        && rms(&axis.error) > 0.0
    {
        format!(
            "positions reach {travel:.4} mm and the tracking error {:.2e} mm RMS; if they are m, say so in the column mapping, as \
             `{}:m`",
            rms(&axis.error),
            axis.axis
        )
    } else if axis.unit() == "mm"
        && range(axis.reference) < TRAVEL_OF_INCHES
        && speed < SPEED_OF_INCHES
        && purpose == Purpose::Training
    {
        format!(
            "the command travels {:.3} mm at no more than {speed:.2} mm/s; if these are inches or metres, say so in the column mapping, \
             as `{}:in`; if not, record longer and faster motion",
            range(axis.reference),
            axis.axis
        )
    } else {
        return None;
    };
    // What a whole log says is no jump of a few rows.
    let most = axis.of_kind(SPEED.0, SPEED.1) * axis.period_s;
    let is_sure = axis.unit() == "mm" && (range(axis.reference) > TRAVEL.0 || quantile(&axis.reference_steps, SURE) > most);
    let severity = if is_sure { purpose.grave() } else { Severity::Warn };
    Some((severity, axis.reference_name(), message))
}

/// Positions with different zero points.
fn different_zeros(axis: &Signals, purpose: Purpose) -> Option<Fault> {
    // Training takes off what linear axes show over all runs, and the checks of these tell it.
    let is_taken_off = purpose == Purpose::Training && axis.unit() == "mm";
    let mean = zero_apart(axis, 0.0).filter(|_| !is_taken_off)?;
    let message = format!(
        "command and actual position differ by {mean:.4} {} throughout: they are counted from different zeros; subtract the offset from the column",
        axis.unit()
    );
    Some((purpose.grave(), axis.actual_name(), message))
}

/// Mean of command minus actual position, where that shows different zeros though `taken_off` is taken off the actual position.
pub(super) fn zero_apart(axis: &Signals, taken_off: f64) -> Option<f64> {
    let mean = axis.error.iter().sum::<f64>() / axis.error.len().max(1) as f64;
    let spread = rms(&axis.error.iter().map(|error| error - mean).collect::<Vec<_>>());
    let left = (mean + taken_off).abs();
    (left > OFFSET_SPREADS * spread && left > axis.of_kind(1.0, 0.01)).then_some(mean)
}

fn known_factor(scale: f64) -> &'static str {
    let factors = [
        (1e3, " (mm against µm, or m against mm)"),
        (1e-3, " (mm against µm, or m against mm)"),
        (1e6, " (m against µm)"),
        (1e-6, " (m against µm)"),
        (25.4, " (inch against mm)"),
        (1.0 / 25.4, " (inch against mm)"),
        (180.0 / std::f64::consts::PI, " (radians against degrees)"),
        (std::f64::consts::PI / 180.0, " (radians against degrees)"),
    ];
    factors.iter().find(|(factor, _)| (scale / factor - 1.0).abs() < SCALE_SHARE).map_or("", |(_, text)| text)
}
