//! Feed planning: from a path of curves to positions sampled every period, within every limit.
//!
//! The plan of a segment between two stops has four steps, one file each:
//! 1. `geometry`: the segment on an arc length grid, with the `q′`, `q″`, `q‴` of the axes. Corners
//!    are rounded within the tolerance before.
//! 2. `profile`: the fastest speed over arc length under the limits (centripetal and axis limits
//!    pointwise, acceleration by a forward and a backward pass over the whole segment, so look-ahead
//!    is unlimited unless `look_ahead` caps the speed).
//! 3. `smooth`: sampling in time and smoothing by two moving averages, which bounds jerk.
//! 4. [`plan`]: check of every sample. Where a limit is exceeded the speed is lowered and the
//!    segment is replanned.
//!
//! `filters` then gives the command of a control that filters its axes after interpolation.

mod corner;
mod excess;
mod filters;
mod geometry;
mod look_ahead;
mod path;
mod piece;
mod profile;
mod settings;
mod smooth;

pub use path::ToolPath;
pub use piece::{MM_PER_RAD, Piece, RotaryPath, Turning};
pub use settings::{AxisFilter, Corners, PlanSettings};

use std::sync::Arc;

use crate::{Cartesian, Curve, DesiredPath, Kinematics, Limits, MotionError, Trajectory};
use corner::Rounding;
use excess::excess;
use filters::Filters;
use geometry::{Followed, Segment};
use piece::AxisSlots;
use profile::SpeedLimit;
use settings::check;

/// Path position of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathSample {
    /// Index of the piece of the [`ToolPath`].
    pub piece: usize,
    /// Arc length from the start of the whole path, mm. A degree of a rotary axis stated by
    /// [`Turning`] counts as a millimetre.
    pub position_mm: f64,
}

/// A planned motion.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The desired path: axis positions, poses, kinematics.
    pub desired: DesiredPath,
    /// One per sample.
    pub samples: Vec<PathSample>,
    /// Arc length from the start of the path at the end of each piece of the [`ToolPath`], mm. Each
    /// half of a rounded corner counts to its own piece.
    pub piece_ends_mm: Vec<f64>,
    /// Command of a control that filters every axis after interpolation, one sample for each of the desired path, which has the
    /// same smoothing along the path; `None` where the control commands the desired path itself.
    pub command: Option<Trajectory>,
}

/// Plans `path` on a machine with `kinematics` and `limits`, from standstill to standstill.
///
/// # Errors
/// If a setting or limit is invalid, a pose cannot be reached, or no speed satisfies the limits.
pub fn plan(
    path: &ToolPath,
    kinematics: &Arc<dyn Kinematics>,
    limits: &Limits,
    settings: &PlanSettings,
) -> Result<Plan, MotionError> {
    check(settings, limits, kinematics.as_ref())?;
    let period = settings.period_s;
    check_duration(path, period)?;
    let standstill = (settings.rest_s / period).round() as usize;
    let filters = Filters::new(settings);
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); kinematics.axes().len()];
    let mut commanded: Vec<Vec<f64>> = vec![Vec::new(); kinematics.axes().len()];
    let mut samples: Vec<PathSample> = Vec::new();
    let mut piece_ends_mm = vec![0.0; path.pieces().len()];
    let mut offset_mm = 0.0;
    let machine = AxisSlots::of(kinematics.as_ref());
    for pieces in path.segments(&Rounding::new(settings, limits)) {
        let near: Vec<f64> = columns.iter().map(|column| column.last().copied().unwrap_or(0.0)).collect();
        // Pieces without length have no motion. Only their dwell counts.
        let segment = Segment::new(&pieces.pieces, &pieces.piece_indices, &machine, &near);
        if let Some(segment) = segment.map_err(|error| error.further(offset_mm))? {
            let further = |error: MotionError| error.further(offset_mm);
            let (mut motion, mut followed) = plan_segment(&segment, &machine, limits, settings, &near).map_err(further)?;
            // The path begins with a dwell. Consecutive segments share the sample at which the
            // first one stops.
            let (before, first) = if offset_mm > 0.0 { (0, 1) } else { (standstill, 0) };
            let append = |to: &mut [Vec<f64>], positions: &[Vec<f64>]| {
                for (column, positions) in to.iter_mut().zip(positions) {
                    column.extend(std::iter::repeat_n(positions[0], before));
                    column.extend(&positions[first..]);
                }
            };
            if let Some(filters) = &filters {
                followed.columns.iter_mut().for_each(|column| filters.settle(column));
                append(&mut commanded, &followed.columns);
                motion = filters.along_path(motion);
                followed = segment.follow(&motion, &machine, &near).map_err(further)?;
            }
            append(&mut columns, &followed.columns);
            let sample = |k: usize| PathSample { piece: followed.pieces[k], position_mm: offset_mm + motion[k] };
            samples.extend(std::iter::repeat_n(0, before).chain(first..motion.len()).map(sample));
            for (piece, end) in segment.piece_ends() {
                piece_ends_mm[piece] = offset_mm + end;
            }
            offset_mm += segment.length_mm();
        }
        let dwell = (pieces.dwell_s / period).round() as usize;
        if samples.len().saturating_add(dwell) > MAX_SAMPLES {
            let piece = pieces.piece_indices.last().copied().unwrap_or_default();
            return Err(too_long(piece, offset_mm, period));
        }
        hold(&mut columns, &mut samples, dwell);
        hold_columns(&mut commanded, dwell);
    }
    hold(&mut columns, &mut samples, standstill);
    hold_columns(&mut commanded, standstill);
    let trajectory = Trajectory::new(period, kinematics.axes().to_vec(), columns)?;
    let command = filters.map(|filters| trajectory.with_columns(filters.apply(&commanded))).transpose()?;
    let desired = DesiredPath::new(trajectory, Arc::clone(kinematics))?;
    // Pieces without length end where the piece before them ends.
    for piece in 1..piece_ends_mm.len() {
        piece_ends_mm[piece] = piece_ends_mm[piece].max(piece_ends_mm[piece - 1]);
    }
    Ok(Plan { desired, samples, piece_ends_mm, command })
}

/// Maximum samples of a plan: 11 h at 2 ms, some three GB.
const MAX_SAMPLES: usize = 20_000_000;

/// Refuses a path that takes more samples at its feeds alone, before anything is planned.
fn check_duration(path: &ToolPath, period_s: f64) -> Result<(), MotionError> {
    let (mut left_s, mut position_mm) = (MAX_SAMPLES as f64 * period_s, 0.0);
    for (index, piece) in path.pieces().iter().enumerate() {
        let length_mm = piece.least_length_mm();
        let reached_mm = length_mm.min(left_s * piece.feed_mm_s);
        left_s -= length_mm / piece.feed_mm_s + piece.dwell_s;
        position_mm += reached_mm;
        if left_s < 0.0 {
            return Err(too_long(index, position_mm, period_s));
        }
    }
    Ok(())
}

fn too_long(piece: usize, position_mm: f64, period_s: f64) -> MotionError {
    MotionError::TooLong { piece, position_mm, hours: MAX_SAMPLES as f64 * period_s / 3600.0, most: MAX_SAMPLES }
}

/// Repeats the last sample `count` times.
fn hold(columns: &mut [Vec<f64>], samples: &mut Vec<PathSample>, count: usize) {
    if let Some(last) = samples.last().copied() {
        samples.extend(std::iter::repeat_n(last, count));
        hold_columns(columns, count);
    }
}

fn hold_columns(columns: &mut [Vec<f64>], count: usize) {
    for column in columns {
        if let Some(last) = column.last().copied() {
            column.extend(std::iter::repeat_n(last, count));
        }
    }
}

/// Plans one smooth curve at `feed_mm_s` on an x-y-z machine, as for the test curves.
///
/// # Errors
/// As [`plan`].
pub fn plan_curve(
    curve: Arc<dyn Curve>,
    feed_mm_s: f64,
    limits: &Limits,
    settings: &PlanSettings,
) -> Result<DesiredPath, MotionError> {
    let kinematics: Arc<dyn Kinematics> = Arc::new(Cartesian::new(crate::Axis::xyz()));
    plan_curve_on(curve, feed_mm_s, &kinematics, limits, settings)
}

/// Plans one smooth curve at the tip feed `feed_mm_s` on a machine with `kinematics`. The curve
/// states the tool direction.
///
/// # Errors
/// As [`plan`].
pub fn plan_curve_on(
    curve: Arc<dyn Curve>,
    feed_mm_s: f64,
    kinematics: &Arc<dyn Kinematics>,
    limits: &Limits,
    settings: &PlanSettings,
) -> Result<DesiredPath, MotionError> {
    let mut path = ToolPath::default();
    path.push(Piece::whole(Arc::clone(&curve), feed_mm_s));
    Ok(plan(&path, kinematics, limits, settings)?.desired.with_curve(curve))
}

/// Whether one of the positions `corners` lies within the differences at a sample.
fn passes(motion: &[f64], sample: usize, corners: &[f64]) -> bool {
    let [from, to] = [sample.saturating_sub(EXCESS_SAMPLES), sample].map(|k| motion[k.min(motion.len() - 1)]);
    corners.get(corners.partition_point(|at| *at < from)).is_some_and(|at| *at <= to)
}

/// Samples over which the third difference extends.
const EXCESS_SAMPLES: usize = 3;

/// Maximum replans of a segment. Each lowers the speed where a limit was exceeded.
const ROUNDS: usize = 200;
/// Factor on the squared speed that the limit allows, in the first replans and in the later ones
/// for the few remaining samples.
const KEPT: [f64; 2] = [0.998, 0.97];
const FIRST_ROUNDS: usize = 3;

/// Arc length at every sample of one segment, from standstill to standstill, and the axis
/// positions.
fn plan_segment(
    segment: &Segment,
    machine: &AxisSlots,
    limits: &Limits,
    settings: &PlanSettings,
    near: &[f64],
) -> Result<(Vec<f64>, Followed), MotionError> {
    let period = settings.period_s;
    let axes = machine.kinematics.axes();
    let mut speed = SpeedLimit::new(segment, axes, limits, settings);
    let windows = [
        // A whole number of periods stays one after rounding errors.
        ((2.0 * limits.path_acceleration_mm_s2 / limits.path_jerk_mm_s3) / period - 1e-6).ceil() as usize,
        (settings.smoothing_s / period).round() as usize,
    ];
    // A control that blends passes no corner without a blend: where directions differ a little all the same, the limits hold.
    let corners = if settings.corners == Corners::Blend { Vec::new() } else { segment.sharp_corners() };
    let spread_s = windows.iter().sum::<usize>() as f64 * period;
    let mut worst = (0.0, String::new());
    for round in 0..ROUNDS {
        let phases = speed.fastest();
        if let Some(position_mm) = smooth::position_after(&phases, MAX_SAMPLES, period) {
            return Err(too_long(segment.index_of(segment.piece_at(position_mm)), position_mm, period));
        }
        let motion = smooth::sample(&phases, period, windows);
        let followed = segment.follow(&motion, machine, near)?;
        let mut excess = excess(&followed.columns, limits, period);
        // At a corner without a blend the rule of the control holds instead.
        excess.retain(|found| !passes(&motion, found.sample, &corners));
        let Some(top) = excess.iter().max_by(|a, b| a.ratio.total_cmp(&b.ratio)) else {
            return Ok((motion, followed));
        };
        let what = format!(
            "axis {} would reach {:.4} times its {} limit",
            axes[top.axis],
            top.ratio,
            ["velocity", "acceleration", "jerk"][top.order - 1]
        );
        worst = (motion[top.sample], what);
        speed.lower(&motion, &excess, spread_s, period, KEPT[usize::from(round >= FIRST_ROUNDS)]);
    }
    let (position_mm, what) = worst;
    Err(MotionError::Infeasible { piece: segment.index_of(segment.piece_at(position_mm)), position_mm, what })
}
