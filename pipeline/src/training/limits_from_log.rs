//! Machine limits from a log, where no description is given.

use std::collections::BTreeMap;

use datasets::{Log, Recording};
use machine::{AxisSpec, KinematicsSpec, LinearAxis, MachineSpec, PathSpec, RotaryAxis, Sensor};
use motion::{Axis, AxisKind, PlanSettings};

use super::swings::Swings;
use crate::error::Result;

/// Time in which the acceleration may change from one limit to the other where positions are too coarse to show a jerk, s.
const RISE_S: f64 = 0.02;

/// Half-width of the central difference for accelerations, s. Between neighbouring samples the rounding steps of a
/// command would count as acceleration.
const SPAN_S: f64 = 0.01;
/// Length of the pieces of a file, s.
const PIECE_S: f64 = 60.0;

/// Largest acceleration of an axis over a run, mm/s² or rad/s².
fn acceleration(run: &[f64], period_s: f64) -> f64 {
    let span = span(period_s);
    let time_s = span as f64 * period_s;
    let change = |k: usize| (run[k] - 2.0 * run[k - span] + run[k - 2 * span]).abs();
    (2 * span..run.len()).map(change).fold(0.0, f64::max) / (time_s * time_s)
}

/// Largest speed of an axis over a run, over the same time, mm/s or rad/s.
pub(super) fn speed(run: &[f64], period_s: f64) -> f64 {
    let span = span(period_s);
    run.windows(span + 1).map(|over| (over[span] - over[0]).abs()).fold(0.0, f64::max) / (span as f64 * period_s)
}

fn span(period_s: f64) -> usize {
    (SPAN_S / period_s).round().max(1.0) as usize
}

/// Largest speed, acceleration and jerk that an axis reached, mm or rad, s.
#[derive(Debug)]
struct ReachedByAxis {
    axis: Axis,
    velocity: f64,
    acceleration: f64,
    swings: Swings,
}

impl ReachedByAxis {
    /// The planner's windows, s.
    fn windows_s(&self) -> [f64; 2] {
        self.swings.windows_s().unwrap_or([RISE_S, PlanSettings::default().smoothing_s])
    }

    /// Limit of the jerk.
    fn jerk(&self) -> f64 {
        2.0 * self.acceleration / self.windows_s()[0]
    }
}

/// What all axes reached.
#[derive(Debug, Default)]
pub(super) struct Reached {
    axes: Vec<ReachedByAxis>,
}

impl Reached {
    /// What the axes reached in `logs`.
    pub fn of<'a>(logs: impl IntoIterator<Item = &'a Log>) -> Self {
        let mut reached = Self::default();
        logs.into_iter().for_each(|log| reached.add(log));
        reached
    }

    /// The same of recordings, which are read in pieces.
    ///
    /// # Errors
    /// When a file cannot be read.
    pub fn of_recordings(recordings: &[Recording]) -> Result<Self> {
        let mut reached = Self::default();
        for recording in recordings {
            let period_s = recording.period_s();
            let (length, lead) = ((PIECE_S / period_s).ceil().max(1.0) as usize, (Swings::BEFORE_S / period_s).ceil() as usize);
            let rows = |from: usize| from..(from + length).min(recording.len());
            recording.read((0..recording.len()).step_by(length).map(rows), lead, |log, _| {
                reached.add(&log);
                Ok(())
            })?;
        }
        Ok(reached)
    }

    fn add(&mut self, log: &Log) {
        if self.axes.is_empty() {
            let none =
                |axis: &Axis| ReachedByAxis { axis: axis.clone(), velocity: 0.0, acceleration: 0.0, swings: Swings::default() };
            self.axes = log.axes().iter().map(none).collect();
        }
        for (reached, column) in self.axes.iter_mut().zip(log.reference.columns()) {
            let speed = column.windows(2).map(|pair| ((pair[1] - pair[0]) / log.period_s()).abs()).fold(0.0, f64::max);
            reached.velocity = reached.velocity.max(speed);
            reached.acceleration = reached.acceleration.max(acceleration(column, log.period_s()));
            reached.swings.add(column, log.period_s());
        }
    }

    /// Machine description with what the axes `moving` reached as limits.
    ///
    /// # Errors
    /// When an axis never moved.
    pub fn spec(&self, moving: &[usize], period_s: f64) -> Result<MachineSpec> {
        // Along the path what the linear axes reach together, and the largest acceleration and jerk: the limits of each axis hold besides.
        let mut path = [0.0_f64; 3];
        let axes = moving
            .iter()
            .filter_map(|&index| {
                let reached = self.axes.get(index)?;
                let (axis, jerk) = (reached.axis.clone(), reached.jerk());
                let (velocity, acceleration) = (reached.velocity, reached.acceleration);
                if axis.kind == AxisKind::Linear {
                    path = [path[0].hypot(velocity), path[1].max(acceleration), path[2].max(jerk)];
                }
                Some(match axis.kind {
                    AxisKind::Linear => AxisSpec::Linear(LinearAxis {
                        name: axis.name,
                        velocity_mm_s: velocity,
                        acceleration_mm_s2: acceleration,
                        jerk_mm_s3: jerk,
                        travel_mm: None,
                        filters_ms: None,
                        time_constant_ms: None,
                        drive: None,
                    }),
                    AxisKind::Rotary => AxisSpec::Rotary(RotaryAxis {
                        name: axis.name,
                        velocity_rad_s: velocity,
                        acceleration_rad_s2: acceleration,
                        jerk_rad_s3: jerk,
                        travel_deg: None,
                        filters_ms: None,
                        time_constant_ms: None,
                        drive: None,
                    }),
                })
            })
            .collect();
        if path[0] == 0.0 {
            // Rotary axes alone: a degree counts as a millimetre.
            for reached in moving.iter().filter_map(|&index| self.axes.get(index)) {
                let [velocity, acceleration, jerk] =
                    [reached.velocity, reached.acceleration, reached.jerk()].map(f64::to_degrees);
                path = [path[0].hypot(velocity), path[1].max(acceleration), path[2].max(jerk)];
            }
        }
        let [velocity_mm_s, acceleration_mm_s2, jerk_mm_s3] = path;
        let windows = moving.iter().filter_map(|&index| Some(self.axes.get(index)?.windows_s()[1]));
        let smoothing_s = windows.fold(PlanSettings::default().smoothing_s, f64::min);
        let spec = MachineSpec {
            name: "from the log".to_owned(),
            sampling_period_ms: period_s * 1e3,
            sensor: Sensor::default(),
            path: PathSpec {
                smoothing_ms: smoothing_s * 1e3,
                short_line_acceleration: PlanSettings::default().short_line_acceleration,
                arc_acceleration_mm_s2: None,
                velocity_mm_s,
                acceleration_mm_s2,
                jerk_mm_s3,
                centripetal_mm_s2: acceleration_mm_s2,
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
}
