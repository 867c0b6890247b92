//! A program in the time of a recorded run, with the command of its control.

use std::sync::Arc;

use datasets::{Finding, Log};
use models::Bundle;
use motion::contour::Exact;
use motion::{AxisKind, DesiredPath, PathSample, Piece, Plan, Pose, Trajectory, Vec3, cubic};

use crate::error::{Error, Result};
use crate::input::Input;
use crate::measure::{Match, Readback, readback, without_approach, without_rests};
use crate::part::{Part, Placement, Recording, TAPER_S, taper};
use crate::refine::is_compensated;

/// Largest distance of a command from the path, mm. Beyond it the command is of another program, or its positions no
/// longer identify lines.
const MAX_DISTANCE_MM: f64 = 0.2;
/// Distance within which a command has reached the end of the path, and within which a standstill lies at the end of a
/// move, mm.
const ARRIVAL_MM: f64 = 0.02;
const AT_END_MM: f64 = 0.002;
/// Smallest angle between consecutive lines that counts as a corner, rad.
const CORNER_RAD: f64 = 0.01;
/// Largest deviation of a rotary axis from its position at the same tip position, rad.
const MAX_ROTATION_RAD: f64 = 0.01;

/// A program as its control ran it.
#[derive(Debug)]
pub struct Recorded {
    /// The program, with its path in the time of the run and the recorded command; as planned where the control does as is planned: the plan
    /// of the compensated program is then known too.
    pub input: Input,
    /// Whether `input` is as planned.
    pub is_as_planned: bool,
    /// Differences between plan and command.
    pub readback: Readback,
    /// Finding of the resampling to the path's sampling period.
    pub resampled: Option<Finding>,
}

/// Brings `input` into the time of `log`, a run of the same program, and adds the recorded command, where the control does not do as is planned. In both cases it
/// takes the work offset from the log.
///
/// # Errors
/// [`Error::NoProgram`] for a path without a program; [`Error::CompensatedRecord`] for a run that `model` knows by its shifts as one of a compensated
/// program; when the log is not of a complete run of the program.
pub fn as_recorded(input: Input, model: &Bundle, log: &Log) -> Result<Recorded> {
    if input.part().is_none() {
        return Err(Error::NoProgram);
    }
    // A log that is of no run of the program is refused with its reason below.
    if is_compensated(&input, model, log).unwrap_or(false) {
        return Err(Error::CompensatedRecord { log: log.name.clone() });
    }
    let (log, resampled) = log.with_axes(input.trajectory().axes())?.resampled(input.trajectory().period_s())?;
    let (log, _) = without_approach(&log, input.desired())?;
    let (found, matched) = readback(&log, &input, &mut Exact::default()).map_err(|source| Error::OtherRun {
        log: log.name.clone(),
        program: input.name().to_owned(),
        source: Box::new(source),
    })?;
    check_reach(&input, &log, &matched)?;
    if found.path.max_mm > MAX_DISTANCE_MM {
        return Err(Error::CommandOffPath { off_mm: found.path.max_mm });
    }
    let Input::Program(part) = input else { return Err(Error::NoProgram) };
    let is_as_planned = found.is_as_planned();
    let part = placed(*part, &matched)?;
    let part = if is_as_planned {
        part
    } else {
        let (log, matched) = without_rests(log, matched)?;
        on_command(part, log.reference, &matched)?
    };
    Ok(Recorded { input: part.into(), is_as_planned, readback: found, resampled })
}

/// The part as planned, at the place of the run.
fn placed(part: Part, matched: &Match) -> Result<Part> {
    let part = Part { placement: placement(&part, matched), ..part };
    if matched.offset.norm() == 0.0 {
        return Ok(part);
    }
    let factors = part.feed_factors.clone();
    part.with_feeds(factors)
}

/// Where the part lies by the log, which is in machine coordinates. On a machine with rotary axes its offset is not searched for.
fn placement(part: &Part, matched: &Match) -> Placement {
    let known = part.placement.known() || !part.plan.desired.kinematics().has_rotary_axes();
    part.placement.clone().moved(matched.offset, known)
}

/// Refuses a command that does not lead from the start of the path to its end.
fn check_reach(path: &Input, log: &Log, matched: &Match) -> Result<()> {
    let commanded = path.desired().tips_of(&log.reference)?;
    let wanted = path.desired().poses();
    let off =
        |at: Option<&Vec3>, pose: Option<&Pose>| at.zip(pose).map_or(0.0, |(at, pose)| (at - matched.offset - pose.tip).norm());
    let (begins, ends) = (off(commanded.first(), wanted.first()), off(commanded.last(), wanted.last()));
    for (verb, place, off_mm) in [("begins", "start", begins), ("ends", "end", ends)] {
        if off_mm > ARRIVAL_MM {
            return Err(Error::PartOfRun { log: log.name.clone(), verb, place, off_mm });
        }
    }
    Ok(())
}

/// The part in the time of `command`: one sample of the plan for each sample of the command, at its position on the
/// path.
///
/// Near corners the recorded command is the target: the control would round a shifted corner in the same way. Elsewhere
/// the deviation of the command, such as that of a smoothing filter on an arc, is corrected together with the servo's
/// error.
fn on_command(part: Part, command: Trajectory, matched: &Match) -> Result<Part> {
    let desired = &part.plan.desired;
    let at_positions = |column: &Vec<f64>| matched.path_positions.iter().map(|at| cubic(column, *at).0).collect();
    let in_time = command.with_columns(desired.trajectory().columns().iter().map(at_positions).collect())?;
    check_turned(&in_time, &command)?;
    let samples = located(&part.plan, &command, matched);
    let away: Vec<Option<()>> = away_from_corners(&part, &samples).iter().map(|away| away.then_some(())).collect();
    let kept = taper(&away, TAPER_S / command.period_s());
    let wanted = command.columns().iter().zip(in_time.columns()).map(|(command, path)| {
        let between = command.iter().zip(path).zip(&kept);
        between.map(|((command, path), kept)| command + (path - command) * kept).collect()
    });
    let kinematics = desired.kinematics();
    let plan = Plan {
        samples,
        desired: DesiredPath::new(command.with_columns(wanted.collect())?, Arc::clone(kinematics))?,
        piece_ends_mm: part.plan.piece_ends_mm.clone(),
        command: None,
    };
    let desired = DesiredPath::new(in_time, Arc::clone(kinematics))?;
    let path_positions = matched.path_positions.clone();
    let recording = Recording { plan: part.plan, command: part.command, desired, away: kept, path_positions };
    Ok(Part { plan, command: Some(command), recording: Some(Box::new(recording)), ..part })
}

/// Path position of every sample of `command`.
fn located(plan: &Plan, command: &Trajectory, matched: &Match) -> Vec<PathSample> {
    let ends = &plan.piece_ends_mm;
    let last = ends.len().saturating_sub(1);
    let is_still = |k: usize| command.columns().iter().all(|column| k > 0 && column[k] == column[k - 1]);
    let locate = |(k, path_position): (usize, &f64)| {
        let reached = position(&plan.samples, *path_position);
        // At a standstill the rounding of the command must not assign a sample to the neighbouring move.
        let near = ends[ends.partition_point(|end| *end < reached - AT_END_MM).min(last)];
        let position_mm = if is_still(k) && (near - reached).abs() <= AT_END_MM { near } else { reached };
        PathSample { piece: ends.partition_point(|end| *end < position_mm).min(last), position_mm }
    };
    matched.path_positions.iter().enumerate().map(locate).collect()
}

/// For every sample whether no corner of the path lies next to it.
fn away_from_corners(part: &Part, samples: &[PathSample]) -> Vec<bool> {
    let pieces = part.path.pieces();
    let direction = |piece: &Piece, at: f64| piece.curve.derivatives(at)[1];
    let is_corner =
        |pair: &[Piece]| direction(&pair[0], pair[0].range.1).angle(&direction(&pair[1], pair[1].range.0)) > CORNER_RAD;
    let mut open = vec![true; samples.len()];
    let corners = pieces.windows(2).zip(&part.plan.piece_ends_mm).filter(|(pair, _)| is_corner(pair));
    for (_, end) in corners {
        let after = samples.partition_point(|sample| sample.position_mm <= *end);
        open[after.saturating_sub(1)..(after + 1).min(samples.len())].fill(false);
    }
    open
}

/// Refuses rotary axes that deviate from the program. Path positions are found by the tool tip alone.
fn check_turned(in_time: &Trajectory, command: &Trajectory) -> Result<()> {
    for (axis, (wanted, commanded)) in in_time.axes().iter().zip(in_time.columns().iter().zip(command.columns())) {
        let off = wanted.iter().zip(commanded).map(|(wanted, commanded)| (wanted - commanded).abs()).fold(0.0, f64::max);
        if axis.kind == AxisKind::Rotary && off > MAX_ROTATION_RAD {
            return Err(Error::CommandTurnsElsewhere { axis: axis.to_string(), off_rad: off });
        }
    }
    Ok(())
}

/// Arc length at a sample index with fraction, mm.
fn position(samples: &[PathSample], path_position: f64) -> f64 {
    let last = samples.len().saturating_sub(1);
    let before = (path_position as usize).min(last);
    let (from, to) = (samples[before].position_mm, samples[(before + 1).min(last)].position_mm);
    from + (to - from) * (path_position - before as f64)
}
