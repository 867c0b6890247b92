//! Assignment of each actual position to its command: swapped columns or axes, wrong sign, actual
//! ahead of the command.

use super::digits::step_of;
use super::signals::{Signals, correlation, quantile, rms, steps};
use crate::{Check, Finding, Purpose, Report, Severity};

/// Window for the comparison of speeds, s; it averages encoder noise.
const STRIDE_S: f64 = 0.02;
/// Correlation of speeds above which a pair matches, and below which it does not.
const BELONGS: f64 = 0.9;
const STRANGE: f64 = 0.5;
/// An actual position that leads by more than this share of a period is suspect.
const LEAD_PERIODS: f64 = 0.5;
/// Lead, as a share of a period, and ratio of noise above which the command is in truth the actual
/// position.
const SWAPPED_LEAD_PERIODS: f64 = 0.02;
const NOISIER: f64 = 1.5;
/// The same where the actual position does not lead: a recorded command may carry some noise of its own.
const FAR_NOISIER: f64 = 5.0;
/// Least lead of one axis alone that is refused for training, s and periods, and the share of it that no other axis may lead by. A velocity
/// feed-forward of 110 % at a gain of 1 m/min/mm leads by 6 ms. More is rarer than columns of different instants, whose model makes parts worse: a
/// command five rows late made 10 µm 31.
const LEAST_LEAD_S: f64 = 6e-3;
const LEAST_LEAD_PERIODS: f64 = 2.0;
const OWN_LEAD: f64 = 0.5;
/// Lead that no machine has, s.
const MOST_LEAD_S: f64 = 0.02;
/// Samples without any change that are a rest.
const RESTING: usize = 5;
/// Ratio of errors below which the actual positions of two axes are swapped.
const EXCHANGED: f64 = 0.2;
/// The third quartile of a normal distribution's magnitude, in standard deviations.
const QUARTILE: f64 = 1.1503;
/// Ratio of third differences above which a column is rougher.
const ROUGHER: f64 = 1.05;

pub(super) fn check(moving: &[&Signals], purpose: Purpose, report: &mut Report) {
    for (index, axis) in moving.iter().enumerate() {
        if let Some(message) = of_other_axis(index, moving) {
            report.push(Finding::new(Severity::Refuse, Check::Pairing, message).in_column(axis.actual_name()));
            continue;
        }
        let own = correlation(&speeds(axis, axis.reference), &speeds(axis, axis.actual)).0;
        if own >= STRANGE {
            check_lead(axis, &others(index, moving).collect::<Vec<_>>(), purpose, report);
            continue;
        }
        let other = moving.iter().enumerate().find(|(other, candidate)| {
            *other != index && correlation(&speeds(axis, axis.reference), &speeds(candidate, candidate.actual)).0 > BELONGS
        });
        let message = match other {
            Some((_, other)) => format!(
                "the command of `{}` is followed by the actual position of `{}`: the axes' columns are swapped",
                axis.axis, other.axis
            ),
            None if own < -STRANGE => format!(
                "the actual position moves against the command (correlation of speeds {own:.2}): wrong sign; give a negative factor in the \
                 column mapping"
            ),
            None => format!(
                "the actual position does not follow the command (correlation of speeds {own:.2}): wrong column, or shifted in time"
            ),
        };
        report.push(Finding::new(Severity::Refuse, Check::Pairing, message).in_column(axis.actual_name()));
    }
}

/// What to say where another axis's column leaves a fraction of the error of axis `index`'s own.
fn of_other_axis(index: usize, moving: &[&Signals]) -> Option<String> {
    let axis = &moving[index].axis;
    let exchanged = exchanged_with(index, moving).map(|other| {
        format!(
            "the actual position of `{}` follows the command of `{axis}` far better than its own does: the axes' columns are exchanged",
            other.axis
        )
    });
    exchanged.or_else(|| {
        let other = &follows_command_of(index, moving)?.axis;
        Some(format!(
            "the actual position of `{axis}` follows the command of `{other}`, not its own: its column is that of the other axis"
        ))
    })
}

/// The axis whose actual position leaves a fraction of the error of axis `index`'s own, without
/// offsets.
fn exchanged_with<'a>(index: usize, moving: &[&'a Signals<'a>]) -> Option<&'a Signals<'a>> {
    let axis = moving[index];
    // A fault of one axis makes its own error large, too; the other's position does not follow its command then.
    others(index, moving).find(|other| is_pair(axis, (axis.reference, other.actual)))
}

/// The axis whose command leaves a fraction of the error of axis `index`'s own, without offsets.
fn follows_command_of<'a>(index: usize, moving: &[&'a Signals<'a>]) -> Option<&'a Signals<'a>> {
    let axis = moving[index];
    others(index, moving).find(|other| is_pair(axis, (other.reference, axis.actual)))
}

fn others<'a>(index: usize, moving: &[&'a Signals<'a>]) -> impl Iterator<Item = &'a Signals<'a>> {
    moving.iter().enumerate().filter(move |(other, _)| *other != index).map(|(_, other)| *other)
}

/// Whether a command and an actual position belong together, and leave a fraction of the error of the axis's own columns, without offsets.
fn is_pair(axis: &Signals, (command, actual): (&[f64], &[f64])) -> bool {
    let left = |command: &[f64], actual: &[f64]| {
        let error: Vec<f64> = command.iter().zip(actual).map(|(r, x)| r - x).collect();
        let mean = error.iter().sum::<f64>() / error.len().max(1) as f64;
        rms(&error.iter().map(|e| e - mean).collect::<Vec<_>>())
    };
    left(command, actual) < EXCHANGED * left(axis.reference, axis.actual)
        && correlation(&speeds(axis, command), &speeds(axis, actual)).0 > BELONGS
}

fn speeds(axis: &Signals, positions: &[f64]) -> Vec<f64> {
    let stride = (STRIDE_S / axis.period_s).round().max(1.0) as usize;
    positions.iter().zip(positions.iter().skip(stride)).map(|(before, after)| after - before).collect()
}

fn check_lead(axis: &Signals, others: &[&Signals], purpose: Purpose, report: &mut Report) {
    let lead_s = -lag_s(axis);
    if lead_s <= SWAPPED_LEAD_PERIODS * axis.period_s {
        return report.findings.extend(noisy_command(axis, lead_s));
    }
    // A measured position is rougher than a planned one.
    let roughness = |of: &[f64]| rms(&steps(&steps(of)));
    let rougher =
        lead_s > LEAD_PERIODS * axis.period_s && roughness(&axis.reference_steps) > ROUGHER * roughness(&axis.actual_steps);
    let (of_command, of_actual) = (noise(axis.reference), noise(axis.actual));
    let noisier = of_command > NOISIER * of_actual && of_command > axis.of_kind(1e-6, 1e-8);
    // A command without jerk limit is as rough as a sensor, and a well-tuned axis leads or lags by microseconds.
    let noisier = noisier && (lead_s > LEAD_PERIODS * axis.period_s || !command_rests_first(axis));
    let (severity, remedy) = if rougher || noisier {
        (
            Severity::Refuse,
            "and the command has the noise of a sensor, the actual position less of it: the two columns are swapped",
        )
    } else if lead_s > MOST_LEAD_S.max(LEAST_LEAD_PERIODS * axis.period_s) {
        (
            purpose.grave(),
            "and no axis leads by so much: the columns are stamped at different instants, or the columns are swapped. Log both at the same instant",
        )
    } else if lead_s > LEAST_LEAD_S.max(LEAST_LEAD_PERIODS * axis.period_s)
        && !others.is_empty()
        && others.iter().all(|other| lag_s(other) > -OWN_LEAD * lead_s)
    {
        (
            purpose.grave(),
            "and the other axes are not: its columns are stamped at different instants. Log all columns at the same instant; where the axis has too \
             much feed-forward indeed, reduce that first",
        )
    } else if lead_s > LEAD_PERIODS * axis.period_s {
        (Severity::Warn, "columns swapped, or stamped at different instants, or too much feed-forward")
    } else {
        return;
    };
    report.push(
        Finding::new(
            severity,
            Check::Pairing,
            format!("the actual position is ahead of the command by {:.2} ms; {remedy}", 1e3 * lead_s),
        )
        .in_column(axis.actual_name()),
    );
}

/// What to say where the command has the noise of a sensor and the axis does not lag: with full feed-forward the lag does not show which is which.
fn noisy_command(axis: &Signals, lead_s: f64) -> Option<Finding> {
    let (of_command, of_actual) = (noise(axis.reference), noise(axis.actual));
    let is_noisy = of_command > FAR_NOISIER * of_actual && of_command > axis.of_kind(1e-6, 1e-8);
    (is_noisy && lead_s > -LEAD_PERIODS * axis.period_s && !command_rests_first(axis)).then(|| {
        let message = "the command has the noise of a sensor, and the actual position less of it: are the two columns swapped? State them in the column \
                       mapping, as `x_ref=NAME,x_act=NAME`";
        Finding::new(Severity::Warn, Check::Pairing, message.replace("x_", &format!("{}_", axis.axis))).in_column(axis.actual_name())
    })
}

/// Whether the command comes to rest exactly while the actual position still moves, more often than the reverse: a planned motion ends
/// at once, a machine settles.
fn command_rests_first(axis: &Signals) -> bool {
    let while_other_rests = |moving: &[f64], resting: &[f64]| {
        let mut still = 0;
        let mut count = 0_usize;
        for (moving, resting) in moving.iter().zip(resting) {
            still = if *resting == 0.0 { still + 1 } else { 0 };
            count += usize::from(still >= RESTING && *moving != 0.0);
        }
        count
    };
    let settling = while_other_rests(&axis.actual_steps, &axis.reference_steps);
    settling >= RESTING && settling > while_other_rests(&axis.reference_steps, &axis.actual_steps)
}

/// Sample-to-sample noise of positions without that of their rounding, from the third quartile of
/// their fourth differences.
///
/// Fourth differences remove a planned motion except at changes of its jerk.
fn noise(positions: &[f64]) -> f64 {
    let fourth = steps(&steps(&steps(&steps(positions))));
    // White noise of variance s² has fourth differences of variance 70·s² (1 + 16 + 36 + 16 + 1); a
    // rounding step q has q²/12.
    let rounding = step_of(positions).map_or(0.0, |step| step * step / 12.0);
    ((quantile(&fourth, 0.75) / QUARTILE).powi(2) / 70.0 - rounding).max(0.0).sqrt()
}

/// Delay of the actual position, s, as the regression of the tracking error on the speed.
fn lag_s(axis: &Signals) -> f64 {
    let (ev, vv) = lag_sums(axis);
    if vv > 0.0 { ev / vv } else { 0.0 }
}

/// Numerator and denominator of that regression.
pub(super) fn lag_sums(axis: &Signals) -> (f64, f64) {
    let rows = 1..axis.error.len().saturating_sub(1);
    let speed = |k: usize| (axis.reference[k + 1] - axis.reference[k - 1]) / (2.0 * axis.period_s);
    let count = rows.len().max(1) as f64;
    let (mean, mean_speed) = rows.clone().fold((0.0, 0.0), |(e, v), k| (e + axis.error[k] / count, v + speed(k) / count));
    rows.fold((0.0, 0.0), |(ev, vv), k| {
        let (error, speed) = (axis.error[k] - mean, speed(k) - mean_speed);
        (ev + error * speed, vv + speed * speed)
    })
}
