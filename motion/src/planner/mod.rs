//! Feed planning: from a path of curves to positions sampled every period, every limit held.
//!
//! The plan of a stretch between two rests is made in four steps, a file each:
//! 1. `geometry`: the stretch on a grid of its way, with the axes' `q′`, `q″`, `q‴`; corners are rounded within the tolerance before;
//! 2. `profile`: the fastest speed over arc length under the limits (centripetal and axis limits pointwise, acceleration by
//!    a forward and a backward pass over the whole stretch, so look-ahead is unlimited);
//! 3. `smooth`: sampled in time and smoothed by two moving averages, which bounds jerk;
//! 4. [`plan`]: checked sample by sample; where a limit is exceeded the speed is lowered there and the stretch planned anew.

mod corner;
mod geometry;
mod path;
mod piece;
mod profile;
mod smooth;

pub use path::ToolPath;
pub use piece::{MM_PER_RAD, Piece, RotaryPath, Turning};

use std::sync::Arc;

use crate::{Cartesian, Curve, DesiredPath, Kinematics, Limits, MotionError, Trajectory};
use geometry::Stretch;
use profile::SpeedLimit;

/// Settings of the feed planner.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanSettings {
    /// Sampling period, s.
    pub period_s: f64,
    /// How far a corner may be rounded off, mm; 0 stops at every corner.
    pub corner_tolerance_mm: f64,
    /// Second smoothing window, s: acceleration is continuous in its derivative too.
    pub smoothing_s: f64,
    /// Rest before the first and after the last motion, s.
    pub rest_s: f64,
}

impl Default for PlanSettings {
    fn default() -> Self {
        Self { period_s: 0.002, corner_tolerance_mm: 0.01, smoothing_s: 0.02, rest_s: 0.2 }
    }
}

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
    for pieces in path.stretches(settings.corner_tolerance_mm) {
        let near: Vec<f64> = columns.iter().map(|column| column.last().copied().unwrap_or(0.0)).collect();
        // Pieces without length have nowhere to go; only their dwell counts.
        let stretch = Stretch::new(&pieces.pieces, &pieces.first_index, kinematics.as_ref(), &near);
        if let Some(stretch) = stretch.map_err(|error| error.further(offset_mm))? {
            let motion = plan_stretch(&stretch, kinematics, limits, settings, &near).map_err(|error| error.further(offset_mm))?;
            // Consecutive stretches share the sample at which the first one comes to rest.
            let first = usize::from(offset_mm > 0.0);
            let motion = std::iter::repeat_n(0.0, rest * (1 - first)).chain(motion.into_iter().skip(first));
            let motion: Vec<f64> = motion.collect();
            stretch
                .columns(motion.iter().copied(), kinematics.as_ref(), &near, &mut columns)
                .map_err(|error| error.further(offset_mm))?;
            samples.extend(
                motion.iter().map(|s| PathSample { piece: stretch.index_of(stretch.at(*s).piece), position_mm: offset_mm + s }),
            );
            for (piece, end) in stretch.piece_ends() {
                piece_ends_mm[piece] = offset_mm + end;
            }
            offset_mm += stretch.length_mm();
        }
        stand(&mut columns, &mut samples, (pieces.dwell_s / period).round() as usize);
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

fn check(settings: &PlanSettings, limits: &Limits, kinematics: &dyn Kinematics) -> Result<(), MotionError> {
    limits.check()?;
    if limits.axes.len() != kinematics.axes().len() {
        return Err(MotionError::Mismatch(format!(
            "limits for {} axes, but the machine has {}",
            limits.axes.len(),
            kinematics.axes().len()
        )));
    }
    if !(settings.period_s.is_finite() && settings.period_s > 0.0) {
        return Err(MotionError::BadPeriod(settings.period_s));
    }
    let rest = [
        ("corner_tolerance_mm", settings.corner_tolerance_mm),
        ("smoothing_s", settings.smoothing_s),
        ("rest_s", settings.rest_s),
    ];
    match rest.into_iter().find(|(_, value)| !(value.is_finite() && *value >= 0.0)) {
        Some((name, value)) => Err(MotionError::BadSetting { name, value, remedy: "it must be finite and not negative" }),
        None => Ok(()),
    }
}

/// How often a stretch is planned anew before giving up; every round lowers the speed where a limit was exceeded.
const ROUNDS: usize = 200;
/// Room left for rounding when limits are compared.
const SLACK: f64 = 1.0 + 1e-7;

/// Arc length at every sample of one stretch, from rest to rest.
fn plan_stretch(
    stretch: &Stretch,
    kinematics: &Arc<dyn Kinematics>,
    limits: &Limits,
    settings: &PlanSettings,
    near: &[f64],
) -> Result<Vec<f64>, MotionError> {
    let period = settings.period_s;
    let mut speed = SpeedLimit::new(stretch, kinematics.axes(), limits, period);
    let windows = [
        ((2.0 * limits.path_acceleration_mm_s2 / limits.path_jerk_mm_s3) / period).ceil() as usize,
        (settings.smoothing_s / period).round() as usize,
    ];
    let spread_s = windows.iter().sum::<usize>() as f64 * period;
    let mut worst = (0.0, String::new());
    for _ in 0..ROUNDS {
        let motion = smooth::sample(&speed.fastest(), period, windows);
        let mut columns = vec![Vec::with_capacity(motion.len()); kinematics.axes().len()];
        stretch.columns(motion.iter().copied(), kinematics.as_ref(), near, &mut columns)?;
        let trajectory = Trajectory::new(period, kinematics.axes().to_vec(), columns)?;
        let excess = excess(&trajectory, limits);
        let Some(top) = excess.iter().max_by(|a, b| a.ratio.total_cmp(&b.ratio)) else {
            return Ok(motion);
        };
        let what = format!(
            "axis {} would reach {:.4} times its {} limit",
            kinematics.axes()[top.axis],
            top.ratio,
            ["velocity", "acceleration", "jerk"][top.order - 1]
        );
        worst = (motion[top.sample], what);
        speed.lower(&motion, &excess, spread_s, period);
    }
    let (position_mm, what) = worst;
    Err(MotionError::Infeasible { piece: stretch.index_of(stretch.at(position_mm).piece), position_mm, what })
}

/// A sample at which an axis exceeds a limit.
struct Excess {
    sample: usize,
    axis: usize,
    /// 1 velocity, 2 acceleration, 3 jerk.
    order: usize,
    /// Value over limit, above 1.
    ratio: f64,
}

/// Every sample whose backward differences exceed a limit; positions before the first and after the last sample rest.
fn excess(trajectory: &Trajectory, limits: &Limits) -> Vec<Excess> {
    let period = trajectory.period_s();
    let mut found = Vec::new();
    for (axis, (column, limit)) in trajectory.columns().iter().zip(&limits.axes).enumerate() {
        let bounds = [limit.velocity, limit.acceleration, limit.jerk];
        let n = column.len();
        let at = |k: usize| column[k.min(n - 1)];
        let mut before = [0.0; 3];
        for k in 1..n + 3 {
            let v = (at(k) - at(k - 1)) / period;
            let a = (v - before[0]) / period;
            let j = (a - before[1]) / period;
            // Positions carry rounding errors, which a third difference magnifies.
            let rounding = 8.0 * f64::EPSILON * at(k).abs().max(1.0);
            for (order, value) in [(1, v), (2, a), (3, j)] {
                let noise = rounding / period.powi(order as i32);
                let ratio = (value.abs() - noise) / bounds[order - 1];
                if ratio > SLACK {
                    found.push(Excess { sample: k.min(n - 1), axis, order, ratio });
                }
            }
            before = [v, a, j];
        }
    }
    found
}
