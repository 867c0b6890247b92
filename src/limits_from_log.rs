//! Limits of a machine that nobody described: what its log reached.

use anyhow::Result;
use datasets::Log;
use machine::{AxisSpec, KinematicsSpec, LinearAxis, MachineSpec, PathSpec, RotaryAxis};
use models::Coverage;
use motion::AxisKind;

/// Jerk lets the acceleration swing from one limit to the other in this time, s.
const RISE_S: f64 = 0.02;

/// A description with the speeds and accelerations that the axes `moving` of `logs` reached.
///
/// # Errors
/// When an axis never moved.
pub fn spec(logs: &[Log], moving: &[usize], period_s: f64) -> Result<MachineSpec> {
    let mut path = (f64::INFINITY, f64::INFINITY);
    let axes = moving
        .iter()
        .filter_map(|&index| {
            let axis = logs.first()?.axes().get(index)?.clone();
            let coverage = Coverage::of(logs.iter().map(|log| log.reference.columns()[index].as_slice()), period_s);
            let (velocity, acceleration) = (coverage.velocity, coverage.acceleration);
            path = (path.0.min(velocity), path.1.min(acceleration));
            let jerk = 2.0 * acceleration / RISE_S;
            Some(match axis.kind {
                AxisKind::Linear => AxisSpec::Linear(LinearAxis {
                    name: axis.name,
                    velocity_mm_s: velocity,
                    acceleration_mm_s2: acceleration,
                    jerk_mm_s3: jerk,
                    drive: None,
                }),
                AxisKind::Rotary => AxisSpec::Rotary(RotaryAxis {
                    name: axis.name,
                    velocity_rad_s: velocity,
                    acceleration_rad_s2: acceleration,
                    jerk_rad_s3: jerk,
                }),
            })
        })
        .collect();
    let spec = MachineSpec {
        name: "from the log".to_owned(),
        sampling_period_ms: period_s * 1e3,
        path: PathSpec {
            velocity_mm_s: path.0,
            acceleration_mm_s2: path.1,
            jerk_mm_s3: 2.0 * path.1 / RISE_S,
            centripetal_mm_s2: path.1,
        },
        kinematics: KinematicsSpec::default(),
        controller: None,
        axes,
    };
    spec.check()?;
    Ok(spec)
}
