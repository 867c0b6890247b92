//! Stability test of a drawn axis.

use motion::Trajectory;

use crate::MachineError;
use crate::options::{Sensor, SimulationOptions};
use crate::simulated::SimulatedMachine;
use crate::spec::{AxisSpec, LinearAxis, MachineSpec};

/// Factor on the position gain with which an axis must be stable too: a gain margin of at least 2.5
/// dB.
const MARGIN: f64 = 4.0 / 3.0;
/// Standstill after each motion, s, in addition to this many integral times of the position loop,
/// and its last part, without motion.
const REST_S: f64 = 1.5;
const REST_INTEGRALS: f64 = 5.0;
const STILL_S: f64 = 0.5;
/// Largest movement at standstill, µm, in addition to two counts of the encoder.
const STILL_UM: f64 = 0.5;
/// Largest tracking error of a motion, as a multiple of the error by the lag of a P loop, the
/// smoothing and the delay.
const ERRORS: f64 = 2.0;

/// Whether the axis follows a there-and-back motion at its limits, without noise, with an error in
/// proportion to its lag, and stands still after it, with its own position gain and with a third
/// more.
pub(super) fn is_stable(machine: &MachineSpec, axis: &LinearAxis) -> Result<bool, MachineError> {
    for factor in [1.0, MARGIN] {
        let mut axis = axis.clone();
        if let Some(drive) = &mut axis.drive {
            drive.loops.position_gain_1_s *= factor;
        }
        if !follows(machine, axis)? {
            return Ok(false);
        }
    }
    Ok(true)
}

fn follows(machine: &MachineSpec, axis: LinearAxis) -> Result<bool, MachineError> {
    let Some(drive) = &axis.drive else { return Ok(true) };
    let loops = &drive.loops;
    let late_s =
        (loops.command_average_ms + loops.command_lag_ms + f64::from(loops.delay_periods) * loops.position_period_ms) * 1e-3;
    let lag_mm = axis.velocity_mm_s * (1.0 / loops.position_gain_1_s + late_s);
    let most_mm = ERRORS * lag_mm + 0.05;
    let still_mm = (STILL_UM * 1e-3).max(2.0 * drive.table.scale_resolution_um * 1e-3);
    let period_s = machine.sampling_period_s();
    let rest_s = REST_S + REST_INTEGRALS * loops.position_integral_ms.unwrap_or(0.0) * 1e-3;
    let (moves, column) = there_and_back(&axis, period_s, rest_s);
    let spec = MachineSpec { axes: vec![AxisSpec::Linear(axis)], ..machine.clone() };
    let simulated = SimulatedMachine::new(&spec, 0)?.with_options(SimulationOptions::noise_free())?;
    let reference = Trajectory::new(period_s, spec.motion_axes(), vec![column])?;
    let run = match simulated.run_with_seed(&reference, 0) {
        Ok(run) => run,
        Err(MachineError::Unstable { .. }) => return Ok(false),
        Err(error) => return Err(error),
    };
    let seen = if simulated.sensor() == Sensor::Table { &run.table } else { &run.motor };
    let commanded = &reference.columns()[0];
    let bounded = commanded.iter().zip(&seen.columns()[0]).all(|(r, x)| (r - x).abs() <= most_mm);
    let still = (STILL_S / period_s) as usize;
    let stands = |end: usize| {
        let views = [&run.motor.columns()[0], &run.table.columns()[0]];
        views.iter().all(|view| {
            let part = &view[end.saturating_sub(still)..end];
            let (low, high) = part.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(*x), high.max(*x)));
            high - low <= still_mm
        })
    };
    Ok(bounded && moves.into_iter().all(stands))
}

/// A there-and-back motion at the limits of the axis with a standstill after each half, and the
/// samples at which the standstills end.
fn there_and_back(axis: &LinearAxis, period_s: f64, rest_s: f64) -> ([usize; 2], Vec<f64>) {
    // Half-cosine speed with this peak acceleration and speed.
    let accelerating_s = std::f64::consts::FRAC_PI_2 * axis.velocity_mm_s / axis.acceleration_mm_s2;
    let duration_s = 2.0 * accelerating_s.max(0.05);
    let travel_mm = 0.5 * axis.velocity_mm_s * duration_s;
    let (moving, resting) = ((duration_s / period_s).ceil() as usize, (rest_s / period_s).ceil() as usize);
    let at = |k: usize| {
        let share = k.min(moving) as f64 / moving as f64;
        travel_mm * (share - (std::f64::consts::TAU * share).sin() / std::f64::consts::TAU)
    };
    let there = (0..moving + resting).map(at);
    let back = (0..moving + resting).map(|k| travel_mm - at(k));
    ([moving + resting, 2 * (moving + resting)], there.chain(back).collect())
}
