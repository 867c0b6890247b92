//! Units and scales that look wrong.

use super::Purpose;
use super::signals::{Signals, correlation, largest, range, rms};
use crate::{Check, Finding, Report, Severity};

/// Longest linear travel, mm, and largest turn, rad, that look like what they say.
const TRAVEL: (f64, f64) = (2e4, 20.0);
/// Smallest linear travel of a run in which the error is yet below 1 µm: positions in m look like that, mm.
const TRAVEL_OF_METRES: f64 = 2.0;
/// Travel, mm, and speed, mm/s, below which a log of excitation is rather one in inches: a twenty-fifth of what small machines do.
const TRAVEL_OF_INCHES: f64 = 10.0;
const SPEED_OF_INCHES: f64 = 8.0;
/// Largest plausible speed, mm/s and rad/s.
const SPEED: (f64, f64) = (5e3, 200.0);
/// Actual over command travel may differ from 1 by this share.
const SCALE_SHARE: f64 = 0.05;
/// A mean offset larger than this many times the spread of the tracking error, and than 1 mm or 10 mrad, is one of zero points.
const OFFSET_SPREADS: f64 = 5.0;

pub(super) fn check(axis: &Signals, purpose: Purpose, report: &mut Report) {
    let mut push = |severity, column: String, message: String| {
        report.push(Finding::new(severity, Check::Units, message).in_column(column));
    };
    let (correlation, scale) = correlation(axis.reference, axis.actual);
    if correlation > 0.9 && (scale - 1.0).abs() > SCALE_SHARE {
        push(
            Severity::Refuse,
            axis.actual_name(),
            format!(
                "the actual position travels {scale:.6} times as far as the command{}; state the units in the column mapping",
                known_factor(scale)
            ),
        );
        return;
    }
    let travel = range(axis.reference).max(largest(axis.reference));
    let speed = largest(&axis.reference_steps) / axis.period_s;
    let (guess, named) = if axis.unit() == "mm" { ("µm", "um") } else { ("degrees", "deg") };
    if travel > axis.of_kind(TRAVEL.0, TRAVEL.1) {
        push(
            Severity::Warn,
            axis.reference_name(),
            format!(
                "positions reach {travel:.1} {}; if they are {guess}, say so in the column mapping, as `{}_ref=column:{named}`",
                axis.unit(),
                axis.axis
            ),
        );
    } else if speed > axis.of_kind(SPEED.0, SPEED.1) {
        push(
            Severity::Warn,
            axis.reference_name(),
            format!(
                "the command reaches {speed:.0} {}/s; check the units of positions and time, or look for a jump",
                axis.unit()
            ),
        );
    } else if axis.unit() == "mm"
        && travel < TRAVEL_OF_METRES
        && speed < TRAVEL_OF_METRES
        && rms(&axis.error) < 1e-3
        && rms(&axis.error) > 0.0
    {
        push(
            Severity::Warn,
            axis.reference_name(),
            format!(
                "positions reach {travel:.4} mm and the tracking error {:.2e} mm RMS; if they are m, say so in the column mapping, as \
                 `{}_ref=column:m`",
                rms(&axis.error),
                axis.axis
            ),
        );
    } else if axis.unit() == "mm"
        && range(axis.reference) < TRAVEL_OF_INCHES
        && speed < SPEED_OF_INCHES
        && purpose == Purpose::Training
    {
        push(
            Severity::Warn,
            axis.reference_name(),
            format!(
                "the command travels {:.3} mm at no more than {speed:.2} mm/s; if these are inches or metres, say so in the column mapping, \
                 as `{}_ref=column:in`; if not, record longer and faster motion",
                range(axis.reference),
                axis.axis
            ),
        );
    }
    let mean = axis.error.iter().sum::<f64>() / axis.error.len().max(1) as f64;
    let spread = rms(&axis.error.iter().map(|error| error - mean).collect::<Vec<_>>());
    if mean.abs() > OFFSET_SPREADS * spread && mean.abs() > axis.of_kind(1.0, 0.01) {
        push(
            purpose.grave(),
            axis.actual_name(),
            format!(
                "command and actual position differ by {mean:.4} {} throughout: they are counted from different zeros; subtract the offset \
                 from the column",
                axis.unit()
            ),
        );
    }
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
