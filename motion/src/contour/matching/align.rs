//! Alignment of a recorded run with the desired path, in time and space.

use nalgebra::Matrix3;

use crate::contour::spline::SampledSpline;
use crate::contour::{ContourEstimator, ContourQuery, Exact, TimeMatch, check_point};
use crate::{MotionError, Vec3};

/// Shortest final standstill that is used, s: by then the slowest servo has settled.
const SETTLED_S: f64 = 0.08;
/// Two standstills whose offsets differ by more than this, mm, do not share one offset.
const SAME_OFFSET_MM: f64 = 0.05;
/// Number of samples used in the search for the delay.
const PROBES: usize = 512;
/// Weight of the time-matched offset relative to the contour of a sample. It only decides
/// directions that the contour leaves undetermined.
const TIME_WEIGHT: f64 = 1e-4;

/// Settings of [`align`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AlignSettings {
    /// Largest delay or lead, s.
    pub max_delay_s: f64,
    /// Largest movement of an axis at standstill, mm.
    pub rest_mm: f64,
    /// Resolution of the work offsets of the control, mm, to which the offset is rounded. `None`:
    /// no rounding.
    pub offset_step_mm: Option<f64>,
}

impl Default for AlignSettings {
    fn default() -> Self {
        Self { max_delay_s: 1.0, rest_mm: 5e-4, offset_step_mm: None }
    }
}

/// Source of the offset.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AlignedBy {
    /// The standstill before and after the motion, where machine and program agree for any servo
    /// lag.
    Rests,
    /// The least contour error, for a record that begins and ends in motion. Part of the mean
    /// contour error is then taken for offset.
    Contour,
}

/// Delay and offset of a recorded run relative to the desired path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alignment {
    /// Delay of the run, s: late start plus mean servo lag, which positions cannot separate. It
    /// only centres search windows. No contour error depends on it.
    pub delay_s: f64,
    /// Actual minus desired coordinates, mm.
    pub offset: Vec3,
    /// Source of the offset.
    pub by: AlignedBy,
    /// Difference between the offsets before and after the motion, mm, if there are both.
    pub rest_spread_mm: Option<f64>,
    /// Whether the desired path is closed.
    pub closed: bool,
    /// Whether another start on the path would fit as well: the path is closed and no standstill
    /// marks the start.
    pub ambiguous: bool,
    period_s: f64,
}

impl Alignment {
    /// The actual path in the coordinates of the desired path, mm.
    #[must_use]
    pub fn apply(&self, actual: &[Vec3]) -> Vec<Vec3> {
        actual.iter().map(|point| point - self.offset).collect()
    }

    /// Time match of desired → actual.
    #[must_use]
    pub fn desired_to_actual(&self) -> TimeMatch {
        TimeMatch { first: self.delay_s / self.period_s, rate: 1.0 }
    }

    /// Time match of actual → desired.
    #[must_use]
    pub fn actual_to_desired(&self) -> TimeMatch {
        TimeMatch { first: -self.delay_s / self.period_s, rate: 1.0 }
    }
}

/// Finds delay and offset of a recorded run (both paths in mm, one sample every `period_s`).
///
/// The offset is taken from the standstill before and after the motion if there is one, so that
/// servo lag does not count as offset. The delay minimises the spread of `actual − desired`, which
/// does not depend on a constant offset.
///
/// # Errors
/// If a path has fewer than 2 samples or a sample that is not finite, or a setting is out of range.
pub fn align(desired: &[Vec3], actual: &[Vec3], period_s: f64, settings: &AlignSettings) -> Result<Alignment, MotionError> {
    check(desired, actual, period_s, settings)?;
    let spline = SampledSpline::new(actual)?;
    let start = coarse_delay(desired, actual, (settings.max_delay_s / period_s) as i64);
    let (delay, matched) = fine_delay(desired, &spline, start as f64);

    let standstills = [
        standstill_before(desired, actual, settings.rest_mm),
        standstill_after(desired, actual, settings.rest_mm, (SETTLED_S / period_s).ceil() as usize),
    ];
    let (by, offset, rest_spread_mm) = match standstills {
        [Some(before), Some(after)] => {
            let spread = (before - after).norm();
            let offset = if spread <= SAME_OFFSET_MM {
                0.5 * (before + after)
            } else if (before - matched).norm() <= (after - matched).norm() {
                before
            } else {
                after
            };
            (AlignedBy::Rests, offset, Some(spread))
        }
        [Some(standstill), None] | [None, Some(standstill)] => (AlignedBy::Rests, standstill, None),
        [None, None] => (AlignedBy::Contour, least_contour(desired, actual, delay, matched)?, None),
    };
    let rounded = |step: f64| offset.map(|value| (value / step).round() * step);
    let closed = is_closed(desired);
    Ok(Alignment {
        delay_s: delay * period_s,
        offset: settings.offset_step_mm.map_or(offset, rounded),
        by,
        rest_spread_mm,
        closed,
        ambiguous: closed && by == AlignedBy::Contour,
        period_s,
    })
}

fn check(desired: &[Vec3], actual: &[Vec3], period_s: f64, settings: &AlignSettings) -> Result<(), MotionError> {
    if !(period_s.is_finite() && period_s > 0.0) {
        return Err(MotionError::BadPeriod(period_s));
    }
    let step = settings.offset_step_mm.unwrap_or(1.0);
    for (name, value) in [
        ("the largest delay, s,", settings.max_delay_s),
        ("the wander of a resting axis, mm,", settings.rest_mm),
        ("the work offset's resolution, mm,", step),
    ] {
        if !(value.is_finite() && value > 0.0) {
            return Err(MotionError::BadSetting { name, value, remedy: "it must be positive and finite" });
        }
    }
    if desired.len() < 2 || actual.len() < 2 {
        return Err(MotionError::Mismatch("a path of fewer than 2 samples cannot be aligned".into()));
    }
    desired.iter().chain(actual).try_for_each(check_point)
}

/// Delay in whole samples with the least spread of `actual − desired`. Among equal delays (laps of
/// a closed path) the smallest.
fn coarse_delay(desired: &[Vec3], actual: &[Vec3], most: i64) -> i64 {
    let stride = desired.len().div_ceil(PROBES);
    let spread = |delay: i64| {
        let pairs = (0..desired.len()).step_by(stride).filter_map(|k| {
            let i = usize::try_from(k as i64 + delay).ok()?;
            Some(actual.get(i)? - desired[k])
        });
        let (count, sum, squares) = pairs
            .fold((0.0, Vec3::zeros(), 0.0), |(count, sum, squares), gap| (count + 1.0, sum + gap, squares + gap.norm_squared()));
        let enough = 2.0 * count * stride as f64 >= desired.len().min(actual.len()) as f64;
        enough.then(|| squares / count - (sum / count).norm_squared())
    };
    let mut best = (0, spread(0).unwrap_or(f64::INFINITY));
    for delay in (1..=most).flat_map(|delay| [delay, -delay]) {
        if let Some(found) = spread(delay).filter(|found| *found < 0.99 * best.1) {
            best = (delay, found);
        }
    }
    best.0
}

/// Delay in fractional samples, and the mean of `actual − desired` at it: Gauss-Newton on the
/// spread.
fn fine_delay(desired: &[Vec3], actual: &SampledSpline, start: f64) -> (f64, Vec3) {
    let pieces = &actual.pieces;
    let last = actual.segments() as f64;
    let mut delay = start;
    let mut mean = Vec3::zeros();
    for _ in 0..20 {
        let pairs: Vec<(Vec3, Vec3)> = desired
            .iter()
            .enumerate()
            .filter(|(k, _)| (0.0..=last).contains(&(*k as f64 + delay)))
            .map(|(k, point)| {
                let (piece, t) = pieces.split(k as f64 + delay);
                let cubic = pieces.cubic(piece);
                (cubic.point(t) - point, cubic.slope(t))
            })
            .collect();
        if pairs.is_empty() {
            return (start, mean);
        }
        let count = pairs.len() as f64;
        mean = pairs.iter().map(|pair| pair.0).sum::<Vec3>() / count;
        let mean_slope = pairs.iter().map(|pair| pair.1).sum::<Vec3>() / count;
        let (against, speed) = pairs.iter().fold((0.0, 0.0), |(against, speed), (gap, slope)| {
            let slope = slope - mean_slope;
            (against + (gap - mean).dot(&slope), speed + slope.norm_squared())
        });
        let step = if speed > 0.0 { (against / speed).clamp(-1.0, 1.0) } else { 0.0 };
        delay = (delay - step).clamp(start - 2.0, start + 2.0);
        if step.abs() < 1e-9 {
            break;
        }
    }
    (delay, mean)
}

/// Offset at the standstill before the motion. Only its first quarter counts, which excludes the
/// start of the first movement.
fn standstill_before(desired: &[Vec3], actual: &[Vec3], rest_mm: f64) -> Option<Vec3> {
    let starts_slowly = |path: &[Vec3]| (path[1] - path[0]).norm() <= 0.1 * longest_step(path);
    if !starts_slowly(desired) || !starts_slowly(actual) {
        return None;
    }
    let still = actual.iter().take_while(|point| (*point - actual[0]).norm() <= rest_mm).count();
    let first = &actual[..still.div_ceil(4)];
    Some(first.iter().sum::<Vec3>() / first.len() as f64 - desired[0])
}

/// Offset at the standstill after the motion, if it lasts `settled` samples. Its last quarter
/// counts.
fn standstill_after(desired: &[Vec3], actual: &[Vec3], rest_mm: f64, settled: usize) -> Option<Vec3> {
    let (end, last) = (desired.last()?, actual.last()?);
    if (end - desired[desired.len() - 2]).norm() > 0.1 * longest_step(desired) {
        return None;
    }
    let still = actual.iter().rev().take_while(|point| (*point - last).norm() <= rest_mm).count();
    // A record without motion has no standstill after a motion.
    if still < settled || still == actual.len() {
        return None;
    }
    let tail = &actual[actual.len() - still.div_ceil(4)..];
    Some(tail.iter().sum::<Vec3>() / tail.len() as f64 - end)
}

fn longest_step(path: &[Vec3]) -> f64 {
    path.windows(2).map(|pair| (pair[1] - pair[0]).norm()).fold(0.0, f64::max)
}

/// The offset with the least contour error. Undetermined directions, as along a straight line, are
/// taken from `matched`.
fn least_contour(desired: &[Vec3], actual: &[Vec3], delay: f64, matched: Vec3) -> Result<Vec3, MotionError> {
    let mut exact = Exact::default();
    let mut errors = Vec::with_capacity(desired.len());
    let matching = TimeMatch { first: delay, rate: 1.0 };
    let mut offset = matched;
    for _ in 0..20 {
        let shifted: Vec<Vec3> = actual.iter().map(|point| point - offset).collect();
        exact.estimate_into(ContourQuery::new(desired, &shifted, matching), &mut errors)?;
        let mut normal = Matrix3::identity() * (TIME_WEIGHT * desired.len() as f64);
        let mut right = (matched - offset) * (TIME_WEIGHT * desired.len() as f64);
        for error in errors.iter().filter(|error| !error.at_end) {
            let across = Matrix3::identity() - error.tangent * error.tangent.transpose();
            normal += across;
            right -= across * error.vector;
        }
        let Some(step) = normal.cholesky().map(|factors| factors.solve(&right)) else {
            break;
        };
        offset += step;
        if step.norm() < 1e-10 {
            break;
        }
    }
    Ok(offset)
}

/// Whether the path leaves its start and returns to it within two of its longest steps.
fn is_closed(path: &[Vec3]) -> bool {
    let near = 2.0 * longest_step(path);
    let length: f64 = path.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
    let last = path.len() - 1;
    near > 0.0 && (path[last] - path[0]).norm() <= near && length > 10.0 * near
}
