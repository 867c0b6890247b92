//! Contour error: the distance in space between a desired and an actual path, whatever the time.
//!
//! An estimator takes the samples of one path, `from`, and finds for each the nearest place, the *foot point*, on the other
//! path, `to`. Desired → actual is what every update law uses (Papers A-D): the error is anchored on the desired path. Actual →
//! desired is the conventional figure of a report (Paper E). Only the order of the arguments differs. The error vector always
//! points from the foot point to the sample, so that desired → actual the update is `x_r + Q·ε` (Paper A, eq. 21-23).

mod estimators;
mod matching;
mod spline;
mod statistics;

pub use estimators::{
    Exact, ExactOnCurve, ExactStream, HermiteFootPoint, Horizon, MovingWindow, OsculatingCircle, SplineSearch, Tangent, Window,
};
pub use matching::{AlignSettings, AlignedBy, Alignment, align, at_places, follow, poses_at_places};
pub use spline::SampledSpline;
pub use statistics::{
    CirclePlane, CircularTest, ContourSummary, DirectionFigures, NominalCircle, OrientationError, PAPER_B_RATIO, PAPER_B_SUPPORT,
    SupportRegion, TableRow, circular_test, corner_flags, corner_ratios, orientation_errors, sample_estimators, stretches,
    summary, summary_by_length, summary_of, table_row,
};

use crate::{MotionError, Vec3};

/// A place on the path `to`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Location {
    /// Index of the sample of `to` that begins the segment.
    pub segment: usize,
    /// Share of the segment that lies before the place, in `[0, 1]`; it is a share of the segment's time.
    pub fraction: f64,
    /// Length of `to` from its first sample, mm, measured along its chords.
    pub arc_mm: f64,
}

/// The contour error of one sample.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ContourError {
    /// From the foot point to the sample, mm.
    pub vector: Vec3,
    /// Nearest place on `to`, mm.
    pub foot: Vec3,
    /// Unit vector along `to` at the foot point, in its direction of travel; zero where `to` has not moved at all.
    pub tangent: Vec3,
    /// Length of `vector`, mm, never negative.
    pub magnitude_mm: f64,
    /// Where on `to` the foot point lies.
    pub location: Location,
    /// Whether the foot point is the first or the last point of `to`, so that the error need not be perpendicular.
    pub at_end: bool,
}

impl ContourError {
    /// The error of a planar path with its sign, mm: positive where the sample lies to the left of `to`, seen along its
    /// direction of travel and from `+z`.
    #[must_use]
    pub fn left_mm(&self) -> f64 {
        let side = self.tangent.x * self.vector.y - self.tangent.y * self.vector.x;
        self.magnitude_mm.copysign(side)
    }
}

/// Which place of `to` was passed at the instant of a sample of `from`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeMatch {
    /// Index in `to`, in fractions of a sample, at the instant of the first sample of `from`.
    pub first: f64,
    /// Samples of `to` for each sample of `from`: the ratio of their sampling periods, positive.
    pub rate: f64,
}

impl TimeMatch {
    /// Both paths start together and are sampled alike.
    pub const SAME: Self = Self { first: 0.0, rate: 1.0 };

    /// Index in `to` that matches sample `k` of `from`; it may lie outside `to`.
    #[must_use]
    pub fn index(self, k: usize) -> f64 {
        self.first + self.rate * k as f64
    }

    /// Nearest sample of a `to` of `len > 0` samples that matches sample `k` of `from`.
    pub(crate) fn sample(self, k: usize, len: usize) -> usize {
        // A cast saturates: below zero to the first sample, above to the last.
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

/// A way to find foot points; it owns its buffers, so that repeated calls do not allocate.
pub trait ContourEstimator: Send {
    /// Short name for tables and the command line.
    fn name(&self) -> &'static str;

    /// Contour error of every sample of `from` (mm, in time order) against the path `to` (mm, in time order), into `out`,
    /// which is cleared first.
    ///
    /// # Errors
    /// When `to` is empty and `from` is not, a coordinate is not finite or beyond 1e9 mm, or `matching` is not usable.
    fn estimate_into(
        &mut self,
        from: &[Vec3],
        to: &[Vec3],
        matching: TimeMatch,
        out: &mut Vec<ContourError>,
    ) -> Result<(), MotionError>;

    /// As [`ContourEstimator::estimate_into`], for paths that start together, into a new vector.
    ///
    /// # Errors
    /// As [`ContourEstimator::estimate_into`].
    fn estimate(&mut self, from: &[Vec3], to: &[Vec3]) -> Result<Vec<ContourError>, MotionError> {
        let mut out = Vec::with_capacity(from.len());
        self.estimate_into(from, to, TimeMatch::SAME, &mut out)?;
        Ok(out)
    }
}

/// Largest coordinate that keeps the promised digits, mm.
const LARGEST_MM: f64 = 1e9;

/// Refuses what no estimator can work on.
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
    // Without early exit the pass over a sound path costs next to nothing.
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
