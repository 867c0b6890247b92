//! Alignment of a recorded run with the desired path in space and time.

use std::ops::Range;

use datasets::Log;
use motion::contour::{AlignSettings, align, at_places, at_places_and_corners, follow, follow_axes};
use motion::{Axis, DesiredPath, Trajectory, Vec3};

use crate::error::Result;

/// Largest distance of a command from the desired path, without delay and offset, at which it keeps the path's time,
/// mm.
const IN_TIME_MM: f64 = 0.2;
/// Least offset between command and path that counts as a work offset, mm. A smaller one is a correction.
const LEAST_OFFSET_MM: f64 = 0.05;
/// Resolution of work offsets, mm.
const OFFSET_STEP_MM: f64 = 1e-4;

/// Distance within which a command is at the start or end of the path, mm.
const NEAR_MM: f64 = 0.02;
/// Largest rounding of the corner at the path's start, mm.
const CORNER_MM: f64 = 0.5;
/// Standstill that is kept before the start of the path, s.
const BEFORE_S: f64 = 0.02;

/// Part of a log from the first arrival of its command at the start of the path to its last point at the end, with the
/// times that were cut off at both ends, s.
///
/// A recording often begins with the approach from home. The log is returned unchanged where it begins on the path, has
/// a work offset, or holds no complete run.
///
/// # Errors
/// When the log's axes are not those of the path.
pub fn without_approach(log: &Log, desired: &DesiredPath) -> Result<(Log, [f64; 2])> {
    let (commanded, path) = (desired.tips_of(&log.reference)?, desired.tips());
    let (Some(start), Some(end), Some(first), Some(last)) = (path.first(), path.last(), commanded.first(), commanded.last())
    else {
        return Ok((log.clone(), [0.0; 2]));
    };
    // A control may round the corner at the start of the path. The nearest distance of the first approach therefore
    // counts.
    let off = commanded.iter().map(|point| (point - start).norm());
    let nearest = off.skip_while(|off| *off >= CORNER_MM).take_while(|off| *off < CORNER_MM).reduce(f64::min);
    let near_mm = nearest.map_or(NEAR_MM, |nearest| NEAR_MM.max(1.01 * nearest));
    let near = |point: &Vec3, end: &Vec3| (point - end).norm() < near_mm;
    let from = if near(first, start) {
        0
    } else {
        // Where the machine waits, its settling is not part of the run.
        let arrival = commanded.iter().position(|point| near(point, start)).unwrap_or(0);
        let waits = commanded[arrival..].iter().take_while(|point| near(point, start)).count();
        arrival + waits.saturating_sub((BEFORE_S / log.period_s()) as usize)
    };
    let to = if near(last, end) { None } else { commanded.iter().rposition(|point| near(point, end)) };
    let samples = from..to.filter(|to| *to > from).map_or(log.len(), |to| to + 1);
    // The start of a closed path is its end: the remaining log must still be a run.
    let length = |points: &[Vec3]| points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum::<f64>();
    let samples = if length(&commanded[samples.clone()]) < 0.5 * length(&path) { 0..log.len() } else { samples };
    let cut_s = [samples.start, log.len() - samples.end].map(|count| count as f64 * log.period_s());
    Ok((within(log, samples)?, cut_s))
}

/// The log and its alignment without the standstills of the command at both ends, but for a short time.
///
/// # Errors
/// None that a log causes.
pub fn without_rests(log: Log, matched: Match) -> Result<(Log, Match)> {
    let kept = (BEFORE_S / log.period_s()) as usize;
    let moves = |k: &usize| log.reference.columns().iter().any(|column| column[*k] != column[*k - 1]);
    let (Some(first), Some(last)) = ((1..log.len()).find(moves), (1..log.len()).rev().find(moves)) else {
        return Ok((log, matched));
    };
    let samples = first.saturating_sub(1 + kept)..(last + 1 + kept).min(log.len());
    let (path_positions, path) = (matched.path_positions[samples.clone()].to_vec(), matched.path[samples.clone()].to_vec());
    Ok((within(&log, samples)?, Match { path_positions, path, ..matched }))
}

fn within(log: &Log, samples: Range<usize>) -> Result<Log> {
    let part = |trajectory: &Trajectory| {
        let columns = trajectory.columns().iter().map(|column| column[samples.clone()].to_vec()).collect();
        Trajectory::new(trajectory.period_s(), trajectory.axes().to_vec(), columns)
    };
    Ok(Log::new(log.name.clone(), part(&log.reference)?, part(&log.actual)?)?)
}

/// Alignment of a run with the path.
#[derive(Debug, Clone)]
pub struct Match {
    /// Delay of the run, s; `None` where it does not keep the path's time.
    pub delay_s: Option<f64>,
    /// Machine minus path coordinates, mm.
    pub offset: Vec3,
    /// Path position of every sample of the run, as a sample index with fraction.
    pub path_positions: Vec<f64>,
    /// Tip positions of the desired path at these positions, one for each sample of the run, mm.
    pub path: Vec<Vec3>,
}

impl Match {
    /// Samples of the path and of the run between the rests at its ends.
    #[must_use]
    pub fn samples_in_motion(&self) -> (f64, f64) {
        let positions = &self.path_positions;
        let (Some(first), Some(last)) = (positions.first(), positions.last()) else { return (0.0, 0.0) };
        let before = positions.iter().take_while(|at| *at <= first).count();
        let after = positions.iter().rev().take_while(|at| *at >= last).count();
        (last - first, positions.len().saturating_sub(before + after) as f64 + 1.0)
    }

    /// Machine minus path coordinates of each of `axes`, mm or rad.
    #[must_use]
    pub fn offsets(&self, axes: &[Axis]) -> Vec<f64> {
        axes.iter().map(|axis| axis.slot().and_then(|slot| self.offset.get(slot)).copied().unwrap_or(0.0)).collect()
    }
}

/// Aligns a run with the desired path by its command, which has neither lag nor stiction. A delay and an offset are
/// used where the command keeps the path's time; otherwise (a compensated or replanned program) path positions are
/// found along the command.
///
/// # Errors
/// When the command leaves the path.
pub fn match_run(desired: &DesiredPath, command: &Trajectory) -> Result<Match> {
    let path = desired.tips();
    let commanded = desired.tips_of(command)?;
    let (delay_s, offset) = delay_and_offset(desired, &path, &commanded, command.period_s())?;
    let delay = delay_s / command.period_s();
    let last = path.len().saturating_sub(1) as f64;
    let path_positions: Vec<f64> = (0..commanded.len()).map(|k| (k as f64 - delay).clamp(0.0, last)).collect();
    let in_time = at_places(&path, &path_positions);
    if in_time.iter().zip(&commanded).all(|(wanted, commanded)| (wanted - (commanded - offset)).norm() < IN_TIME_MM) {
        return Ok(Match { delay_s: Some(delay_s), offset, path_positions, path: in_time });
    }
    by_position(desired, command, offset)
}

/// Same as [`match_run`], for a command on the path itself. Path positions are always found along the command, which
/// shows time differences that a single delay hides.
///
/// # Errors
/// When the command leaves the path.
pub fn match_by_position(desired: &DesiredPath, command: &Trajectory) -> Result<Match> {
    let (_, offset) = delay_and_offset(desired, &desired.tips(), &desired.tips_of(command)?, command.period_s())?;
    by_position(desired, command, offset)
}

/// Delay of the run, s, and machine minus path coordinates, mm.
fn delay_and_offset(desired: &DesiredPath, path: &[Vec3], commanded: &[Vec3], period_s: f64) -> Result<(f64, Vec3)> {
    let found = align(path, commanded, period_s, &AlignSettings::default())?;
    // On a machine with rotary axes, an offset of the axes is not an offset of the tip.
    let none = found.offset.norm() < LEAST_OFFSET_MM || desired.kinematics().has_rotary_axes();
    let rounded = found.offset.map(|value| (value / OFFSET_STEP_MM).round() * OFFSET_STEP_MM);
    Ok((found.delay_s, if none { Vec3::zeros() } else { rounded }))
}

fn by_position(desired: &DesiredPath, command: &Trajectory, offset: Vec3) -> Result<Match> {
    let path = desired.tips();
    let path_positions = if offset.norm() > 0.0 {
        let commanded: Vec<Vec3> = desired.tips_of(command)?.into_iter().map(|tip| tip - offset).collect();
        follow(&commanded, &path)?
    } else {
        follow_axes(command, desired)?
    };
    let path = at_places_and_corners(&path, &path_positions);
    Ok(Match { delay_s: None, offset, path_positions, path })
}

/// The log in the coordinates of the path.
///
/// # Errors
/// None that an alignment of the same log causes.
pub fn without_offset(log: Log, matched: &Match) -> Result<Log> {
    if matched.offset.norm() == 0.0 {
        return Ok(log);
    }
    let offsets = matched.offsets(log.axes());
    let moved = |run: &Trajectory| {
        let columns = run.columns().iter().zip(&offsets);
        run.with_columns(columns.map(|(column, offset)| column.iter().map(|x| x - offset).collect()).collect())
    };
    Ok(Log::new(log.name.clone(), moved(&log.reference)?, moved(&log.actual)?)?)
}
