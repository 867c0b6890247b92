//! Where and when a recorded run lies against the desired path.

use datasets::Log;
use motion::contour::{AlignSettings, align, at_places, follow};
use motion::{Axis, DesiredPath, MotionError, Trajectory, Vec3, cubic};

use crate::error::Result;

/// A command within this of the desired path, delay and offset taken off, keeps its time, mm.
const IN_TIME_MM: f64 = 0.2;
/// A smaller difference between command and path is a correction, not a work offset, mm.
const LEAST_OFFSET_MM: f64 = 0.05;
/// Resolution of work offsets, mm.
const OFFSET_STEP_MM: f64 = 1e-4;

/// A command within this of the path's start or end is there, mm.
const THERE_MM: f64 = 0.02;
/// Largest rounding of the corner at the path's start, mm.
const CORNER_MM: f64 = 0.5;
/// What is kept of a rest at the path's start, s.
const BEFORE_S: f64 = 0.02;

/// The part of a log from where its command first is at the path's start to where it last is at its end: a recording usually begins with
/// the way there from home. The log as it is where it begins on the path, has a work offset of its own, or holds no whole run; with what
/// was cut off at either end, s.
///
/// # Errors
/// When the log's axes are not those of the path.
pub fn without_approach(log: &Log, desired: &DesiredPath) -> Result<(Log, [f64; 2])> {
    let (commanded, path) = (desired.tips_of(&log.reference)?, desired.tips());
    let (Some(start), Some(end), Some(first), Some(last)) = (path.first(), path.last(), commanded.first(), commanded.last())
    else {
        return Ok((log.clone(), [0.0; 2]));
    };
    // A control may round off the corner at the path's start: what counts is how near it comes when it first comes by.
    let off = commanded.iter().map(|point| (point - start).norm());
    let nearest = off.skip_while(|off| *off >= CORNER_MM).take_while(|off| *off < CORNER_MM).reduce(f64::min);
    let there_mm = nearest.map_or(THERE_MM, |nearest| THERE_MM.max(1.01 * nearest));
    let near = |point: &Vec3, place: &Vec3| (point - place).norm() < there_mm;
    let from = if near(first, start) {
        0
    } else {
        // Not before the machine has settled there, if it waits.
        let arrival = commanded.iter().position(|point| near(point, start)).unwrap_or(0);
        let waits = commanded[arrival..].iter().take_while(|point| near(point, start)).count();
        arrival + waits.saturating_sub((BEFORE_S / log.period_s()) as usize)
    };
    let to = if near(last, end) { None } else { commanded.iter().rposition(|point| near(point, end)) };
    let rows = from..to.filter(|to| *to > from).map_or(log.len(), |to| to + 1);
    // On a closed path its start is its end: what is left must still be a run.
    let way = |points: &[Vec3]| points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum::<f64>();
    let rows = if way(&commanded[rows.clone()]) < 0.5 * way(&path) { 0..log.len() } else { rows };
    let part = |trajectory: &Trajectory| {
        let columns = trajectory.columns().iter().map(|column| column[rows.clone()].to_vec()).collect();
        Trajectory::new(trajectory.period_s(), trajectory.axes().to_vec(), columns)
    };
    let cut_s = [rows.start, log.len() - rows.end].map(|samples| samples as f64 * log.period_s());
    Ok((Log::new(log.name.clone(), part(&log.reference)?, part(&log.actual)?)?, cut_s))
}

/// A run laid over the path.
#[derive(Debug, Clone)]
pub struct Match {
    /// The run's delay, s; `None` where it does not keep the path's time.
    pub delay_s: Option<f64>,
    /// Machine minus path coordinates, mm.
    pub offset: Vec3,
    /// Place on the desired path for every sample of the run, in its samples.
    pub places: Vec<f64>,
    /// The desired path at these places: one point a sample of the run, mm.
    pub path: Vec<Vec3>,
}

impl Match {
    /// Machine minus path coordinates of every one of `axes`, mm or rad.
    #[must_use]
    pub fn offsets(&self, axes: &[Axis]) -> Vec<f64> {
        axes.iter().map(|axis| axis.slot().and_then(|slot| self.offset.get(slot)).copied().unwrap_or(0.0)).collect()
    }
}

/// Lays a run over the desired path by what was commanded, which has neither lag nor stiction: first by a delay and an offset; where the
/// command does not keep the path's time (a compensated or re-planned program), by following it.
///
/// # Errors
/// When the command leads elsewhere.
pub fn match_run(desired: &DesiredPath, commanded: &[Vec3], period_s: f64) -> Result<Match> {
    let path = desired.tips();
    let (delay_s, offset) = delay_and_offset(desired, &path, commanded, period_s)?;
    let delay = delay_s / period_s;
    let last = path.len().saturating_sub(1) as f64;
    let places: Vec<f64> = (0..commanded.len()).map(|k| (k as f64 - delay).clamp(0.0, last)).collect();
    let in_time = at_places(&path, &places);
    if in_time.iter().zip(commanded).all(|(wanted, commanded)| (wanted - (commanded - offset)).norm() < IN_TIME_MM) {
        return Ok(Match { delay_s: Some(delay_s), offset, places, path: in_time });
    }
    by_place(&path, commanded, offset)
}

/// As [`match_run`], for a command that is on the path itself: always by following it, which finds differences in time that a delay of the
/// whole run hides.
///
/// # Errors
/// When the command leads elsewhere.
pub fn match_places(desired: &DesiredPath, commanded: &[Vec3], period_s: f64) -> Result<Match> {
    let path = desired.tips();
    let (_, offset) = delay_and_offset(desired, &path, commanded, period_s)?;
    by_place(&path, commanded, offset)
}

/// How late the run is, s, and machine minus path coordinates, mm.
fn delay_and_offset(desired: &DesiredPath, path: &[Vec3], commanded: &[Vec3], period_s: f64) -> Result<(f64, Vec3)> {
    let found = align(path, commanded, period_s, &AlignSettings::default())?;
    // Where the workpiece turns, an offset of the axes is none of the tip's.
    let none = found.offset.norm() < LEAST_OFFSET_MM || desired.kinematics().has_rotary_axes();
    let rounded = found.offset.map(|value| (value / OFFSET_STEP_MM).round() * OFFSET_STEP_MM);
    Ok((found.delay_s, if none { Vec3::zeros() } else { rounded }))
}

fn by_place(path: &[Vec3], commanded: &[Vec3], offset: Vec3) -> Result<Match> {
    let commanded: Vec<Vec3> = commanded.iter().map(|point| point - offset).collect();
    let places = follow(&commanded, path)?;
    let path = at_places(path, &places);
    Ok(Match { delay_s: None, offset, places, path })
}

/// Commanded and actual positions of a log at the instants of the desired path's samples, in its coordinates.
///
/// A rest of the path lasts as long as in the log, so that axes that lag behind their command arrive; what the path rests longer is met at
/// the instant at which the log leaves.
///
/// # Errors
/// When the two do not match.
pub fn in_path_time(desired: &DesiredPath, log: &Log, matched: &Match) -> Result<(Trajectory, Trajectory)> {
    let path = desired.trajectory();
    let offsets = matched.offsets(path.axes());
    let resampled = |from: &Trajectory| -> Result<Trajectory> {
        let run = in_time_of(path, from, &matched.places)?;
        let columns = run.columns().iter().zip(&offsets);
        Ok(run.with_columns(columns.map(|(column, offset)| column.iter().map(|value| value - offset).collect()).collect())?)
    };
    Ok((resampled(&log.reference)?, resampled(&log.actual)?))
}

/// A run whose samples lie at `places` of the path, at the instants at which it passes the path's samples; rests as with [`in_path_time`].
///
/// # Errors
/// When the run does not have the path's axes.
pub fn in_time_of(path: &Trajectory, run: &Trajectory, places: &[f64]) -> Result<Trajectory, MotionError> {
    let instants = instants(path, places);
    path.with_columns(run.columns().iter().map(|column| instants.iter().map(|at| cubic(column, *at).0).collect()).collect())
}

/// When a run whose samples lie at `places` passes every sample of the path, in its samples.
fn instants(path: &Trajectory, places: &[f64]) -> Vec<f64> {
    let mut k = 0;
    let mut passes = |sample: usize| {
        let wanted = sample as f64;
        while k + 1 < places.len() && places[k + 1] < wanted {
            k += 1;
        }
        let (before, after) = (places[k], places.get(k + 1).copied().unwrap_or(places[k]));
        k as f64 + if after > before { ((wanted - before) / (after - before)).clamp(0.0, 1.0) } else { 0.0 }
    };
    let samples: Vec<usize> = (0..path.len()).collect();
    let mut instants = Vec::with_capacity(samples.len());
    for rest in samples.chunk_by(|a, b| path.at(*a).eq(path.at(*b))) {
        let (arrives, last) = (passes(rest[0]), rest[rest.len() - 1] as f64);
        let leaves = places.partition_point(|place| *place <= last).saturating_sub(1) as f64;
        instants.extend((0..rest.len()).map(|waited| (arrives + waited as f64).min(leaves.max(arrives))));
    }
    instants
}

#[cfg(test)]
mod tests {
    use motion::Axis;

    use super::*;

    #[test]
    fn a_rest_lasts_as_long_as_in_the_run() {
        let path = |positions: &[f64]| Trajectory::new(0.002, vec![Axis::named("x")], vec![positions.to_vec()]).unwrap();
        let desired = path(&[0.0, 1.0, 2.0, 2.0, 2.0, 3.0, 4.0, 4.0, 4.0]);
        // Half as fast, a shorter rest in between, and a longer one at the end.
        let places = [0.0, 0.5, 1.0, 1.5, 2.0, 2.0, 4.5, 5.0, 5.5, 6.0, 6.0, 6.0, 6.0];
        assert_eq!(instants(&desired, &places), [0.0, 2.0, 4.0, 5.0, 5.0, 7.0, 9.0, 10.0, 11.0]);
        assert_eq!(
            instants(&desired, &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]),
            [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]
        );
    }
}
