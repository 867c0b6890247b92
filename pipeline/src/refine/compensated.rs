//! Which program a recorded command is of.

use datasets::Log;
use machine::Machine;
use models::Bundle;
use motion::contour::ContourError;

use super::aligned::Aligned;
use crate::error::Result;
use crate::input::Input;
use crate::measure::{match_by_position, without_approach, without_offset};
use crate::position_terms::machine_for;
use crate::statistics::{contour_errors, counts, figures_at};

/// Least share of a command's distance from the path that lies against the forecast error, and the ratio of the two within which it is a
/// correction. What a control does by itself, such as rounding, follows the error of the machine in neither way.
const LEAST_SHARE: f64 = 0.5;
const RATIO: std::ops::Range<f64> = 0.5..1.5;
/// Share of the samples that is compared, those of the smallest errors: the end of a rapid has the largest, which no correction takes away.
const COMPARED: f64 = 0.95;
/// Least such distance, RMS, mm.
const LEAST_MM: f64 = 1e-4;

/// RMS distance of the command of `log` from the path of `program` over its feed moves, mm, whatever time the control took.
///
/// # Errors
/// When the command leaves the path, or the axes are others.
pub fn command_apart_mm(program: &Input, log: &Log) -> Result<f64> {
    let desired = program.desired();
    let log = log.with_axes(desired.trajectory().axes())?.resampled(desired.trajectory().period_s())?.0;
    let (log, _) = without_approach(&log, desired)?;
    let matched = match_by_position(desired, &log.reference)?;
    let command = without_offset(log, &matched)?.reference;
    Ok(figures_at(desired, program.part(), &matched.path_positions, &command)?.tip.rms_mm)
}

/// Whether the command of `log` is shifted against the error that `model` forecasts for the uncompensated path.
///
/// # Errors
/// When the path does not fit the model, or the log is not of a run of it.
pub fn is_compensated(input: &Input, model: &Bundle, log: &Log) -> Result<bool> {
    let desired = input.desired();
    let command = &Aligned::of(input, log)?.command;
    let forecast = machine_for(model, input.part())?.run(input.command())?;
    let (shifts, errors) = (contour_errors(desired, command)?, contour_errors(desired, &forecast)?);
    let mut pairs: Vec<(&ContourError, &ContourError)> =
        shifts.iter().zip(&errors).enumerate().filter(|(k, _)| counts(input.part(), *k)).map(|(_, pair)| pair).collect();
    pairs.sort_by(|(_, one), (_, other)| one.magnitude_mm.total_cmp(&other.magnitude_mm));
    pairs.truncate((COMPARED * pairs.len() as f64) as usize);
    let mean = |of: &dyn Fn(&ContourError, &ContourError) -> f64| {
        pairs.iter().map(|(shift, error)| of(shift, error)).sum::<f64>() / pairs.len().max(1) as f64
    };
    let against = -mean(&|shift, error| shift.vector.dot(&error.vector));
    let (of_shifts, of_errors) = (mean(&|shift, _| shift.vector.norm_squared()), mean(&|_, error| error.vector.norm_squared()));
    let (ratio, share) = (against / of_errors, against.powi(2) / (of_errors * of_shifts));
    Ok(of_shifts.sqrt() > LEAST_MM && RATIO.contains(&ratio) && share > LEAST_SHARE)
}
