//! Feed planning: from a path of curves to positions sampled every period, every limit held.
//!
//! The plan of a stretch between two rests is made in four steps, a file each:
//! 1. `geometry`: the stretch on a grid of its way, with the axes' `q′`, `q″`, `q‴`; corners are rounded within the tolerance before;
//! 2. `profile`: the fastest speed over arc length under the limits (centripetal and axis limits pointwise, acceleration by
//!    a forward and a backward pass over the whole stretch, so look-ahead is unlimited);
//! 3. `smooth`: sampled in time and smoothed by two moving averages, which bounds jerk;
//! 4. [`plan`]: checked sample by sample; where a limit is exceeded the speed is lowered there and the stretch planned anew.

mod corner;
mod excess;
mod geometry;
mod path;
mod piece;
mod profile;
mod settings;
mod smooth;

pub use path::ToolPath;
pub use piece::{MM_PER_RAD, Piece, RotaryPath, Turning};
pub use settings::PlanSettings;

use std::sync::Arc;

use crate::{Cartesian, Curve, DesiredPath, Kinematics, Limits, MotionError, Trajectory};
use corner::Rounding;
use excess::excess;
use geometry::{Followed, Stretch};
use piece::AxisSlots;
use profile::SpeedLimit;
use settings::check;

/// Where on the tool path a sample lies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathSample {
    /// Index of the piece of the [`ToolPath`].
    pub piece: usize,
    /// Way from the start of the whole path, mm: arc length, where a degree of a rotary axis that [`Turning`] states counts as a millimetre.
    pub position_mm: f64,
}

/// A planned motion.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The desired path: axis positions, poses, kinematics.
    pub desired: DesiredPath,
    /// One a sample.
    pub samples: Vec<PathSample>,
    /// Way from the start of the path at which each piece of the [`ToolPath`] ends, mm; a rounded corner is shared by half.
    pub piece_ends_mm: Vec<f64>,
}

/// Plans `path` on a machine with `kinematics` and `limits`, from rest to rest.
///
/// # Errors
/// When a setting or limit is not sound, a pose cannot be reached, or no speed holds the limits.
pub fn plan(
    path: &ToolPath,
    kinematics: &Arc<dyn Kinematics>,
    limits: &Limits,
    settings: &PlanSettings,
) -> Result<Plan, MotionError> {
    check(settings, limits, kinematics.as_ref())?;
    let period = settings.period_s;
    let rest = (settings.rest_s / period).round() as usize;
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); kinematics.axes().len()];
    let mut samples: Vec<PathSample> = Vec::new();
    let mut piece_ends_mm = vec![0.0; path.pieces().len()];
    let mut offset_mm = 0.0;
    let machine = AxisSlots::of(kinematics.as_ref());
    for pieces in path.stretches(&Rounding::new(settings, limits)) {
        let near: Vec<f64> = columns.iter().map(|column| column.last().copied().unwrap_or(0.0)).collect();
        // Pieces without length have nowhere to go; only their dwell counts.
        let stretch = Stretch::new(&pieces.pieces, &pieces.first_index, &machine, &near);
        if let Some(stretch) = stretch.map_err(|error| error.further(offset_mm))? {
            let (motion, followed) =
                plan_stretch(&stretch, &machine, limits, settings, &near).map_err(|error| error.further(offset_mm))?;
            // The path begins with a rest; consecutive stretches share the sample at which the first one comes to rest.
            let (before, first) = if offset_mm > 0.0 { (0, 1) } else { (rest, 0) };
            for (column, positions) in columns.iter_mut().zip(&followed.columns) {
                column.extend(std::iter::repeat_n(positions[0], before));
                column.extend(&positions[first..]);
            }
            let sample = |k: usize| PathSample { piece: followed.pieces[k], position_mm: offset_mm + motion[k] };
            samples.extend(std::iter::repeat_n(0, before).chain(first..motion.len()).map(sample));
            for (piece, end) in stretch.piece_ends() {
                piece_ends_mm[piece] = offset_mm + end;
            }
            offset_mm += stretch.length_mm();
        }
        let dwell = (pieces.dwell_s / period).round() as usize;
        if samples.len().saturating_add(dwell) > MOST_SAMPLES {
            let piece = pieces.first_index.last().copied().unwrap_or_default();
            return Err(too_long(piece, offset_mm, period));
        }
        stand(&mut columns, &mut samples, dwell);
    }
    stand(&mut columns, &mut samples, rest);
    let trajectory = Trajectory::new(period, kinematics.axes().to_vec(), columns)?;
    let desired = DesiredPath::new(trajectory, Arc::clone(kinematics))?;
    // Pieces without length end where the one before them does.
    for piece in 1..piece_ends_mm.len() {
        piece_ends_mm[piece] = piece_ends_mm[piece].max(piece_ends_mm[piece - 1]);
    }
    Ok(Plan { desired, samples, piece_ends_mm })
}

/// Samples of a plan at most: 28 h at 2 ms, some ten GB.
const MOST_SAMPLES: usize = 50_000_000;

fn too_long(piece: usize, position_mm: f64, period_s: f64) -> MotionError {
    MotionError::TooLong { piece, position_mm, hours: MOST_SAMPLES as f64 * period_s / 3600.0, most: MOST_SAMPLES }
}

/// Repeats the last sample `count` times.
fn stand(columns: &mut [Vec<f64>], samples: &mut Vec<PathSample>, count: usize) {
    if let Some(last) = samples.last().copied() {
        samples.extend(std::iter::repeat_n(last, count));
        for column in columns {
            column.extend(std::iter::repeat_n(column[column.len() - 1], count));
        }
    }
}

/// Plans one smooth curve at `feed_mm_s` on an x-y-z machine: the test curves' way.
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

/// Plans one smooth curve at `feed_mm_s` of the tool tip on a machine with `kinematics`, which turns the tool as the curve says.
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

/// How often a stretch is planned anew before giving up; every round lowers the speed where a limit was exceeded.
const ROUNDS: usize = 200;
/// Share of the squared speed that is kept beyond what a limit asks for, in the first rounds and in those for the few places that are left then.
const KEPT: [f64; 2] = [0.998, 0.97];
const FIRST_ROUNDS: usize = 3;

/// Arc length at every sample of one stretch, from rest to rest, and where the axes are.
fn plan_stretch(
    stretch: &Stretch,
    machine: &AxisSlots,
    limits: &Limits,
    settings: &PlanSettings,
    near: &[f64],
) -> Result<(Vec<f64>, Followed), MotionError> {
    let period = settings.period_s;
    let axes = machine.kinematics.axes();
    let mut speed = SpeedLimit::new(stretch, axes, limits, period);
    let windows = [
        ((2.0 * limits.path_acceleration_mm_s2 / limits.path_jerk_mm_s3) / period).ceil() as usize,
        (settings.smoothing_s / period).round() as usize,
    ];
    let spread_s = windows.iter().sum::<usize>() as f64 * period;
    let mut worst = (0.0, String::new());
    for round in 0..ROUNDS {
        let phases = speed.fastest();
        if let Some(position_mm) = smooth::position_after(&phases, MOST_SAMPLES, period) {
            return Err(too_long(stretch.index_of(stretch.piece_at(position_mm)), position_mm, period));
        }
        let motion = smooth::sample(&phases, period, windows);
        let followed = stretch.follow(&motion, machine, near)?;
        let excess = excess(&followed.columns, limits, period);
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
    Err(MotionError::Infeasible { piece: stretch.index_of(stretch.piece_at(position_mm)), position_mm, what })
}
