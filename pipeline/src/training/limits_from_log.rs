//! Machine limits from a log, where no description is given.

use std::collections::BTreeMap;

use datasets::Log;
use machine::{AxisSpec, KinematicsSpec, LinearAxis, MachineSpec, PathSpec, RotaryAxis, Sensor};
use models::OperatingRange;
use motion::{AxisKind, PlanSettings};

use crate::error::Result;

/// Time in which the acceleration may change from one limit to the other, s; it sets the jerk.
const RISE_S: f64 = 0.02;

/// Half-width of the central difference for accelerations, s. Between neighbouring samples the rounding steps of a
/// command would count as acceleration.
const SPAN_S: f64 = 0.01;

/// Largest acceleration of an axis over its runs, mm/s² or rad/s².
fn acceleration<'a>(runs: impl Iterator<Item = &'a [f64]>, period_s: f64) -> f64 {
    let span = (SPAN_S / period_s).round().max(1.0) as usize;
    let time_s = span as f64 * period_s;
    runs.flat_map(|run| (2 * span..run.len()).map(move |k| (run[k] - 2.0 * run[k - span] + run[k - 2 * span]).abs()))
        .fold(0.0, f64::max)
        / (time_s * time_s)
}

/// Machine description with the largest speeds and accelerations of the axes `moving` in `logs`.
///
/// # Errors
/// When an axis never moved.
pub fn spec(logs: &[&Log], moving: &[usize], period_s: f64) -> Result<MachineSpec> {
    let mut path = (f64::INFINITY, f64::INFINITY);
    let axes = moving
        .iter()
        .filter_map(|&index| {
            let axis = logs.first()?.axes().get(index)?.clone();
            let coverage = OperatingRange::of(logs.iter().map(|log| log.reference.columns()[index].as_slice()), period_s);
            let columns = logs.iter().map(|log| log.reference.columns()[index].as_slice());
            let (velocity, acceleration) = (coverage.velocity, acceleration(columns, period_s));
            path = (path.0.min(velocity), path.1.min(acceleration));
            let jerk = 2.0 * acceleration / RISE_S;
            Some(match axis.kind {
                AxisKind::Linear => AxisSpec::Linear(LinearAxis {
                    name: axis.name,
                    velocity_mm_s: velocity,
                    acceleration_mm_s2: acceleration,
                    jerk_mm_s3: jerk,
                    travel_mm: None,
                    drive: None,
                }),
                AxisKind::Rotary => AxisSpec::Rotary(RotaryAxis {
                    name: axis.name,
                    velocity_rad_s: velocity,
                    acceleration_rad_s2: acceleration,
                    jerk_rad_s3: jerk,
                    travel_deg: None,
                    drive: None,
                }),
            })
        })
        .collect();
    let spec = MachineSpec {
        name: "from the log".to_owned(),
        sampling_period_ms: period_s * 1e3,
        sensor: Sensor::default(),
        path: PathSpec {
            smoothing_ms: PlanSettings::default().smoothing_s * 1e3,
            short_line_acceleration: PlanSettings::default().short_line_acceleration,
            velocity_mm_s: path.0,
            acceleration_mm_s2: path.1,
            jerk_mm_s3: 2.0 * path.1 / RISE_S,
            centripetal_mm_s2: path.1,
        },
        kinematics: KinematicsSpec::default(),
        control: None,
        controller: None,
        work_offsets: BTreeMap::new(),
        axes,
    };
    spec.check()?;
    Ok(spec)
}
