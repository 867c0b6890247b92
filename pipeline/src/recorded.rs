//! A program as a control ran it: its path in the time that was recorded, and what was commanded in place of it.

use std::sync::Arc;

use datasets::{Finding, Log};
use motion::contour::Exact;
use motion::{AxisKind, DesiredPath, PathSample, Piece, Plan, Pose, Trajectory, Vec3, cubic};

use crate::error::{Error, Result};
use crate::input::Input;
use crate::measure::{Match, Readback, readback, without_approach};
use crate::part::{FADE_S, Part, taper};

/// A command further off the program's path than this, mm, is not one of this program, or no longer says where its lines are.
const FARTHEST_MM: f64 = 0.2;
/// A command that ends within this of the path's end, mm, has come there; one at rest within this of a move's end is at it.
const THERE_MM: f64 = 0.02;
const AT_END_MM: f64 = 0.002;
/// Lines that meet at a larger angle, rad, meet in a corner.
const CORNER_RAD: f64 = 0.01;
/// A rotary axis this far from where it should be, rad, is somewhere else on its way.
const TURNED_RAD: f64 = 0.01;

/// A program in the time of a run of it.
#[derive(Debug)]
pub struct Recorded {
    /// The program, with its path in the run's time and the command of the run.
    pub input: Input,
    /// How far plan and command differ.
    pub readback: Readback,
    /// What bringing the log to the path's sampling period found.
    pub resampled: Option<Finding>,
}

/// `input` in the time of `log`, a run of the same program, and with its command.
///
/// # Errors
/// When the path was not planned from a program, or the log is not of a whole run of it.
pub fn as_recorded(input: Input, log: &Log) -> Result<Recorded> {
    if input.part().is_none() {
        return Err(Error::NoProgram);
    }
    let (log, resampled) = log.with_axes(input.trajectory().axes())?.resampled(input.trajectory().period_s())?;
    let (log, _) = without_approach(&log, input.desired())?;
    let (found, matched) = readback(&log, &input, &mut Exact::default()).map_err(|source| Error::OtherRun {
        log: log.name.clone(),
        program: input.name().to_owned(),
        source: Box::new(source),
    })?;
    check_reach(&input, &log, &matched)?;
    if found.path.max_mm > FARTHEST_MM {
        return Err(Error::CommandOffPath { off_mm: found.path.max_mm });
    }
    let Input::Program(part) = input else { return Err(Error::NoProgram) };
    let part = on_command(*part, log.reference, &matched)?;
    Ok(Recorded { input: part.into(), readback: found, resampled })
}

/// Refuses a command that does not lead from the path's start to its end.
fn check_reach(path: &Input, log: &Log, matched: &Match) -> Result<()> {
    let commanded = path.desired().tips_of(&log.reference)?;
    let wanted = path.desired().poses();
    let off =
        |at: Option<&Vec3>, pose: Option<&Pose>| at.zip(pose).map_or(0.0, |(at, pose)| (at - matched.offset - pose.tip).norm());
    let (begins, ends) = (off(commanded.first(), wanted.first()), off(commanded.last(), wanted.last()));
    for (verb, place, off_mm) in [("begins", "start", begins), ("ends", "end", ends)] {
        if off_mm > THERE_MM {
            return Err(Error::PartOfRun { log: log.name.clone(), verb, place, off_mm });
        }
    }
    Ok(())
}

/// The part with its path in the time that `command` takes: a sample of the plan for each of the command, at its place on the path.
///
/// What a control rounds off at a corner it rounds off again wherever the corner is shifted: there the command itself is what is wanted.
/// Elsewhere its deviation, as from a smoothing filter on an arc, is corrected with the servo's.
fn on_command(part: Part, command: Trajectory, matched: &Match) -> Result<Part> {
    let desired = &part.plan.desired;
    let columns = desired.trajectory().columns().iter().zip(matched.offsets(command.axes()));
    let at_places = |(column, offset): (&Vec<f64>, f64)| matched.places.iter().map(|at| cubic(column, *at).0 + offset).collect();
    let in_time = command.with_columns(columns.map(at_places).collect())?;
    check_turned(&in_time, &command)?;
    let samples = located(&part.plan, &command, matched);
    let kept = taper(&away_from_corners(&part, &samples), FADE_S / command.period_s());
    let wanted = command.columns().iter().zip(in_time.columns()).map(|(command, path)| {
        let between = command.iter().zip(path).zip(&kept);
        between.map(|((command, path), kept)| command + (path - command) * kept).collect()
    });
    let plan = Plan {
        samples,
        desired: DesiredPath::new(command.with_columns(wanted.collect())?, Arc::clone(desired.kinematics()))?,
        piece_ends_mm: part.plan.piece_ends_mm.clone(),
    };
    // A log is in machine coordinates; where the workpiece turns its offset is not looked for.
    let known = part.placement.known() || !plan.desired.kinematics().has_rotary_axes();
    Ok(Part { placement: part.placement.moved(matched.offset, known), plan, command: Some(command), ..part })
}

/// Where on the path every sample of `command` lies.
fn located(plan: &Plan, command: &Trajectory, matched: &Match) -> Vec<PathSample> {
    let ends = &plan.piece_ends_mm;
    let last = ends.len().saturating_sub(1);
    let rests = |k: usize| command.columns().iter().all(|column| k > 0 && column[k] == column[k - 1]);
    let locate = |(k, place): (usize, &f64)| {
        let reached = position(&plan.samples, *place);
        // Where the control waits, rounding of its command must not put it into the move before or after.
        let near = ends[ends.partition_point(|end| *end < reached - AT_END_MM).min(last)];
        let position_mm = if rests(k) && (near - reached).abs() <= AT_END_MM { near } else { reached };
        PathSample { piece: ends.partition_point(|end| *end < position_mm).min(last), position_mm }
    };
    matched.places.iter().enumerate().map(locate).collect()
}

/// For every sample whether no corner of the path lies between it and its neighbours.
fn away_from_corners(part: &Part, samples: &[PathSample]) -> Vec<bool> {
    let pieces = part.path.pieces();
    let direction = |piece: &Piece, at: f64| piece.curve.derivatives(at)[1];
    let turns = |pair: &[Piece]| direction(&pair[0], pair[0].range.1).angle(&direction(&pair[1], pair[1].range.0)) > CORNER_RAD;
    let mut open = vec![true; samples.len()];
    let corners = pieces.windows(2).zip(&part.plan.piece_ends_mm).filter(|(pair, _)| turns(pair));
    for (_, end) in corners {
        let after = samples.partition_point(|sample| sample.position_mm <= *end);
        open[after.saturating_sub(1)..(after + 1).min(samples.len())].fill(false);
    }
    open
}

/// Places are found by the tool tip: refuses rotary axes that turn elsewhere than they say.
fn check_turned(in_time: &Trajectory, command: &Trajectory) -> Result<()> {
    for (axis, (wanted, commanded)) in in_time.axes().iter().zip(in_time.columns().iter().zip(command.columns())) {
        let off = wanted.iter().zip(commanded).map(|(wanted, commanded)| (wanted - commanded).abs()).fold(0.0, f64::max);
        if axis.kind == AxisKind::Rotary && off > TURNED_RAD {
            return Err(Error::CommandTurnsElsewhere { axis: axis.to_string(), off_rad: off });
        }
    }
    Ok(())
}

/// Way along the path at a place between samples, mm.
fn position(samples: &[PathSample], place: f64) -> f64 {
    let last = samples.len().saturating_sub(1);
    let before = (place as usize).min(last);
    let (from, to) = (samples[before].position_mm, samples[(before + 1).min(last)].position_mm);
    from + (to - from) * (place - before as f64)
}
