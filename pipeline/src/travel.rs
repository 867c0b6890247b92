//! Check of a path against the travel of the axes.

use motion::AxisKind;

use crate::error::{Error, Result};
use crate::input::Input;
use crate::setup::Setup;
use crate::units::in_programs;

/// Rounding of positions, mm or rad.
const ROUNDING: f64 = 1e-9;

/// Refuses a path that exceeds the travel of an axis. Where the work offset of a program is unknown, on a machine
/// without rotary axes, only the extent of the path is compared: see [`is_unchecked`].
///
/// # Errors
/// Names line or time, axis, position and limits.
pub fn check(input: &Input, setup: &Setup) -> Result<()> {
    check_from(input, setup, 0)
}

/// The same from this sample on.
///
/// # Errors
/// As [`check`].
pub fn check_from(input: &Input, setup: &Setup, from: usize) -> Result<()> {
    let path = input.trajectory();
    if path.axes() != setup.kinematics.axes() {
        return Ok(());
    }
    for (index, (axis, travel)) in path.axes().iter().zip(&setup.travel).enumerate() {
        let Some([low, high]) = *travel else { continue };
        let column = &path.columns()[index][from..];
        let (scale, unit) = in_programs(axis.kind);
        let shown = |value: f64| format!("{:.3}", value * scale);
        if is_unplaced(input, axis.kind) {
            let (lowest, highest) = column.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
            if highest - lowest > high - low + ROUNDING {
                let sample = column.iter().position(|x| *x == highest).unwrap_or(0);
                let why = format!(
                    "axis {axis} would cover {} {unit}, more than its travel of {} {unit} wherever the part lies; it ends up at {} {unit} here",
                    shown(highest - lowest),
                    shown(high - low),
                    shown(highest)
                );
                return Err(refused(input, from + sample, why));
            }
        } else if let Some(sample) = column.iter().position(|x| *x < low - ROUNDING || *x > high + ROUNDING) {
            let remedy = if input.part().is_some() { "say where the part lies with --work-offset" } else { "move the path" };
            let why = format!(
                "axis {axis} would be at {} {unit}, beyond its travel of {} to {} {unit}; {remedy}, or correct the machine's travel",
                shown(column[sample]),
                shown(low),
                shown(high)
            );
            return Err(refused(input, from + sample, why));
        }
    }
    Ok(())
}

/// Whether [`check`] compares only the extent of the path: an axis has limits, and the work offset is unknown.
#[must_use]
pub fn is_unchecked(input: &Input, setup: &Setup) -> bool {
    let limited = |(axis, travel): (&motion::Axis, &Option<[f64; 2]>)| travel.is_some() && is_unplaced(input, axis.kind);
    setup.kinematics.axes().iter().zip(&setup.travel).any(limited)
}

/// Whether positions of axes of this kind are program coordinates, not machine coordinates.
fn is_unplaced(input: &Input, kind: AxisKind) -> bool {
    let unplaced = input.part().is_some_and(|part| !part.placement.known());
    // On a machine with rotary axes the path was planned with the part at 0,0,0.
    unplaced && kind == AxisKind::Linear && !input.desired().kinematics().has_rotary_axes()
}

fn refused(input: &Input, sample: usize, why: String) -> Error {
    match input.part() {
        Some(part) => part.refused_at(sample, why),
        None => {
            let time_s = sample as f64 * input.trajectory().period_s();
            Error::OffTravel { name: input.name().to_owned(), time_s, what: why }
        }
    }
}
