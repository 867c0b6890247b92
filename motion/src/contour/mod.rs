//! Contour error: the distance in space between a desired and an actual path, independent of time.
//!
//! An estimator takes the samples of one path, `from`, and finds for each the nearest point, the
//! *foot point*, on the other path, `to`. Desired → actual is the direction of every update law
//! (Papers A-D): the error is anchored on the desired path. Actual → desired is the conventional
//! direction of reports (Paper E). Only the order of the arguments differs. The error vector points
//! from the foot point to the sample, so the desired → actual update is `x_r + Q·ε` (Paper A, eq.
//! 21-23).

mod estimators;
mod matching;
mod spline;
mod statistics;
mod turns;

pub use estimators::{
    Exact, ExactOnCurve, ExactStream, HermiteFootPoint, Horizon, MovingWindow, OsculatingCircle, SplineSearch, Tangent, Window,
};
pub use matching::{
    AlignSettings, AlignedBy, Alignment, align, at_places, at_places_and_corners, follow, follow_axes, poses_at_places,
};
pub use spline::SampledSpline;
pub use statistics::{
    CirclePlane, CircularTest, ContourSummary, DirectionFigures, NominalCircle, OrientationError, PAPER_B_RATIO, PAPER_B_SUPPORT,
    SupportRegion, TableRow, circular_test, corner_flags, corner_ratios, orientation_errors, sample_estimators, stretches,
    summary, summary_by_length, summary_of, table_row,
};
pub use turns::{LEVER_MM, Turning, axis_turns, turns};

use crate::{MotionError, Vec3};

/// A position on the path `to`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Location {
    /// Index of the sample of `to` that begins the segment.
    pub segment: usize,
    /// Fraction of the segment before the position, in `[0, 1]`, measured in time.
    pub fraction: f64,
    /// Length of `to` from its first sample, mm, along its chords.
    pub arc_mm: f64,
}

/// The contour error of one sample.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ContourError {
    /// From the foot point to the sample, mm.
    pub vector: Vec3,
    /// Nearest point on `to`, mm.
    pub foot: Vec3,
    /// Unit vector along `to` at the foot point, in the direction of travel. Zero if `to` has not
    /// moved at all.
    pub tangent: Vec3,
    /// Length of `vector`, mm, non-negative.
    pub magnitude_mm: f64,
    /// Position of the foot point on `to`.
    pub location: Location,
    /// Whether the foot point is the first or the last point of `to`. The error need not be
    /// perpendicular there.
    pub at_end: bool,
}

impl ContourError {
    /// Signed error of a planar path, mm: positive if the sample lies to the left of `to`, seen
    /// along the direction of travel and from `+z`.
    #[must_use]
    pub fn left_mm(&self) -> f64 {
        let side = self.tangent.x * self.vector.y - self.tangent.y * self.vector.x;
        self.magnitude_mm.copysign(side)
    }
}

/// Time match: the index in `to` at the instant of a sample of `from`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeMatch {
    /// Fractional index in `to` at the instant of the first sample of `from`.
    pub first: f64,
    /// Samples of `to` per sample of `from`: the ratio of their sampling periods, positive.
    pub rate: f64,
}

impl TimeMatch {
    /// Both paths start together and have the same period.
    pub const SAME: Self = Self { first: 0.0, rate: 1.0 };

    /// Index in `to` that matches sample `k` of `from`. It may lie outside `to`.
    #[must_use]
    pub fn index(self, k: usize) -> f64 {
        self.first + self.rate * k as f64
    }

    /// Nearest sample of a `to` of `len > 0` samples that matches sample `k` of `from`.
    pub(crate) fn sample(self, k: usize, len: usize) -> usize {
        // Casts saturate: below zero to the first sample, above the end to the last.
        (self.index(k).round() as usize).min(len - 1)
    }

    fn check(self) -> Result<(), MotionError> {
        if !self.first.is_finite() {
            return Err(MotionError::BadSetting {
                name: "the time match's first index",
                value: self.first,
                remedy: "it must be finite",
            });
        }
        if !(self.rate.is_finite() && self.rate > 0.0) {
            return Err(MotionError::BadSetting {
                name: "the time match's rate",
                value: self.rate,
                remedy: "it must be positive and finite",
            });
        }
        Ok(())
    }
}

/// Samples to measure, and the path to measure them against.
#[derive(Debug, Clone, Copy)]
pub struct ContourQuery<'a> {
    /// Samples in time order, mm.
    pub from: &'a [Vec3],
    /// Path in time order, mm.
    pub to: &'a [Vec3],
    /// Sample of the path that belongs to each sample in time.
    pub matching: TimeMatch,
}

impl<'a> ContourQuery<'a> {
    /// The contour error of `from` against the path `to`.
    #[must_use]
    pub fn new(from: &'a [Vec3], to: &'a [Vec3], matching: TimeMatch) -> Self {
        Self { from, to, matching }
    }
}

/// A foot point estimator. It owns its buffers, so repeated calls do not allocate.
pub trait ContourEstimator: Send {
    /// Short name for tables and the command line.
    fn name(&self) -> &'static str;

    /// Contour error of every sample of the query, into `out`, which is cleared first.
    ///
    /// # Errors
    /// If the path is empty and the samples are not, a coordinate is not finite or beyond 1e9 mm, or the time match is invalid.
    fn estimate_into(&mut self, query: ContourQuery<'_>, out: &mut Vec<ContourError>) -> Result<(), MotionError>;

    /// As [`ContourEstimator::estimate_into`], for paths that start together, into a new vector.
    ///
    /// # Errors
    /// As [`ContourEstimator::estimate_into`].
    fn estimate(&mut self, from: &[Vec3], to: &[Vec3]) -> Result<Vec<ContourError>, MotionError> {
        let mut out = Vec::with_capacity(from.len());
        self.estimate_into(ContourQuery::new(from, to, TimeMatch::SAME), &mut out)?;
        Ok(out)
    }
}

/// Largest coordinate for which the stated accuracy holds, mm.
const LARGEST_MM: f64 = 1e9;

/// Refuses invalid input.
fn check_paths(from: &[Vec3], to: &[Vec3], matching: TimeMatch) -> Result<(), MotionError> {
    matching.check()?;
    if to.is_empty() && !from.is_empty() {
        return Err(MotionError::Mismatch("there is no path to measure against".into()));
    }
    check_points(from)?;
    check_points(to)
}

/// Refuses a path with a point that is not finite or too far away.
fn check_points(path: &[Vec3]) -> Result<(), MotionError> {
    let sound = |point: &Vec3| point.iter().fold(true, |sound, value| sound & (value.abs() <= LARGEST_MM));
    // Without early exit the check of a valid path is cheap.
    if path.iter().fold(true, |all, point| all & sound(point)) {
        return Ok(());
    }
    path.iter().try_for_each(check_point)
}

/// Refuses a point that is not finite or too far away.
fn check_point(point: &Vec3) -> Result<(), MotionError> {
    match point.iter().find(|value| value.is_nan() || value.abs() > LARGEST_MM) {
        None => Ok(()),
        Some(value) => Err(MotionError::BadSetting {
            name: "a coordinate of a path, mm,",
            value: *value,
            remedy: "it must be finite and within 1e9 mm",
        }),
    }
}
