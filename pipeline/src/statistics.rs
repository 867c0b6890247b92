//! Error figures of a run: RMS, MAX and 95th percentile of contour and orientation error.

use motion::contour::{
    ContourError, ContourEstimator, ContourSummary, Exact, ExactOnCurve, LEVER_MM, at_places_and_corners, follow_axes,
    orientation_errors, poses_at_places, summary, summary_of,
};
use motion::{DesiredPath, Pose, Trajectory, Vec3, poses_of};

use crate::error::{Error, Result};
use crate::part::Part;
use crate::path_time;

/// Contour error of every sample of `actual`: distance from the nearest point of the desired path (actual → desired).
/// It is exact, and uses the analytic curve where one is known.
///
/// # Errors
/// When the samples or axes of the two do not match.
pub fn contour_errors(desired: &DesiredPath, actual: &Trajectory) -> Result<Vec<ContourError>> {
    errors_from(desired, &desired.tips_of(actual)?, &desired.tips())
}

/// Same as [`contour_errors`], for a run whose command `reference` follows the path in another time, such as a
/// replanned program. Also returns the path position of every sample, as a sample index of `desired` with fraction.
///
/// # Errors
/// When `reference` leaves the path.
pub fn contour_errors_along(
    desired: &DesiredPath,
    reference: &Trajectory,
    actual: &Trajectory,
) -> Result<(Vec<ContourError>, Vec<f64>)> {
    let path = desired.tips();
    let commanded = desired.tips_of(reference)?;
    let in_time =
        path.len() == commanded.len() && path.iter().zip(&commanded).all(|(wanted, commanded)| (wanted - commanded).norm() < 0.2);
    if in_time {
        let path_positions = (0..path.len()).map(|k| k as f64).collect();
        return Ok((errors_from(desired, &desired.tips_of(actual)?, &path)?, path_positions));
    }
    let path_positions = follow_axes(reference, desired)?;
    Ok((errors_from(desired, &desired.tips_of(actual)?, &at_places_and_corners(&path, &path_positions))?, path_positions))
}

/// Contour errors of `tips` against `path`, the desired points at the same instants.
fn errors_from(desired: &DesiredPath, tips: &[Vec3], path: &[Vec3]) -> Result<Vec<ContourError>> {
    let mut estimator: Box<dyn ContourEstimator> = match desired.curve() {
        Some(curve) => Box::new(ExactOnCurve::new(curve.clone())),
        None => Box::new(Exact::default()),
    };
    Ok(estimator.estimate(tips, path)?)
}

/// Error figures of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figures {
    /// Contour error of the tool tip, mm.
    pub tip: ContourSummary,
    /// Contour error of the tool direction; `None` on a machine without rotary axes.
    pub orientation: Option<OrientationSummary>,
}

/// Figures of the orientation error, rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrientationSummary {
    /// Root mean square.
    pub rms_rad: f64,
    /// Arithmetic mean.
    pub mean_rad: f64,
    /// Largest error.
    pub max_rad: f64,
    /// 95th percentile.
    pub p95_rad: f64,
}

impl Figures {
    /// Mean of every figure over the runs; `None` without runs.
    #[must_use]
    pub fn mean(runs: &[Self]) -> Option<Self> {
        let over = |of: &dyn Fn(&Self) -> f64| runs.iter().map(of).sum::<f64>() / runs.len() as f64;
        let mut mean = *runs.first()?;
        mean.tip.rms_mm = over(&|run| run.tip.rms_mm);
        mean.tip.mean_mm = over(&|run| run.tip.mean_mm);
        mean.tip.max_mm = over(&|run| run.tip.max_mm);
        mean.tip.p95_mm = over(&|run| run.tip.p95_mm);
        if let Some(orientation) = &mut mean.orientation {
            orientation.rms_rad = over(&|run| run.orientation.map_or(0.0, |o| o.rms_rad));
            orientation.mean_rad = over(&|run| run.orientation.map_or(0.0, |o| o.mean_rad));
            orientation.max_rad = over(&|run| run.orientation.map_or(0.0, |o| o.max_rad));
            orientation.p95_rad = over(&|run| run.orientation.map_or(0.0, |o| o.p95_rad));
        }
        Some(mean)
    }
}

impl Figures {
    /// Cost of a run, mm: root sum of squares of the tip's RMS error and the direction's RMS error at a lever of 20 mm.
    #[must_use]
    pub fn cost_mm(&self) -> f64 {
        self.tip.rms_mm.hypot(self.orientation.map_or(0.0, |orientation| orientation.rms_rad * LEVER_MM))
    }
}

/// Error figures over the samples of a run; of a program over its feed moves only.
///
/// # Errors
/// As [`contour_errors`].
pub fn figures(desired: &DesiredPath, part: Option<&Part>, actual: &Trajectory) -> Result<Figures> {
    SampleErrors::of(desired, actual)?.figures(|k| counts(part, *k))
}

/// Same as [`figures`] of a program, with a weight for every sample.
///
/// # Errors
/// As [`contour_errors`].
pub fn weighted_figures(desired: &DesiredPath, part: &Part, weights: &[f64], actual: &Trajectory) -> Result<Figures> {
    let errors = contour_errors(desired, actual)?;
    let weights: Vec<Option<f64>> =
        weights.iter().enumerate().map(|(k, weight)| counts(Some(part), k).then_some(*weight)).collect();
    let orientation = orientation(desired, &errors, desired.poses(), actual, &weights)?;
    Ok(Figures { tip: weighted(&errors, &weights)?, orientation })
}

/// Errors of every sample of a run in the path's time.
pub(crate) struct SampleErrors {
    tip: Vec<ContourError>,
    /// Errors of the direction, rad; `None` on a machine without rotary axes.
    direction_rad: Option<Vec<f64>>,
}

impl SampleErrors {
    /// Errors of `actual`.
    ///
    /// # Errors
    /// As [`contour_errors`].
    pub(crate) fn of(desired: &DesiredPath, actual: &Trajectory) -> Result<Self> {
        let poses = poses_of(actual, desired.kinematics().as_ref())?;
        let tips: Vec<Vec3> = poses.iter().map(|pose| pose.tip).collect();
        let tip = errors_from(desired, &tips, &desired.tips())?;
        let angles = || orientation_errors(&tip, &poses, desired.poses()).iter().map(|error| error.angle_rad).collect();
        let direction_rad = desired.kinematics().has_rotary_axes().then(angles);
        Ok(Self { tip, direction_rad })
    }

    /// Figures over the samples for which `counts` is true.
    ///
    /// # Errors
    /// [`Error::NoSamples`] when no sample counts.
    pub(crate) fn figures(&self, counts: impl Fn(&usize) -> bool) -> Result<Figures> {
        self.figures_above(&[], counts)
    }

    /// Contour error of every sample, mm.
    pub(crate) fn magnitudes_mm(&self) -> impl Iterator<Item = f64> {
        self.tip.iter().map(|error| error.magnitude_mm)
    }

    /// Error of the direction of every sample, rad; `None` on a machine without rotary axes.
    pub(crate) fn direction_rad(&self) -> Option<&[f64]> {
        self.direction_rad.as_deref()
    }

    /// Same as [`SampleErrors::figures`], of the part of the tip's errors that exceeds `unavoidable_mm`; all of it where that is empty.
    pub(crate) fn figures_above(&self, unavoidable_mm: &[f64], counts: impl Fn(&usize) -> bool) -> Result<Figures> {
        let counted = || (0..self.tip.len()).filter(|k| counts(k));
        let above = |k: usize| (self.tip[k].magnitude_mm - unavoidable_mm.get(k).copied().unwrap_or(0.0)).max(0.0);
        let tip: Vec<f64> = counted().map(above).collect();
        let direction = self.direction_rad.as_ref().map(|angles| counted().map(|k| angles[k]).collect::<Vec<f64>>());
        let orientation = direction.map(|angles| summary_of_angles(&angles)).transpose()?;
        Ok(Figures { tip: summary_of(&tip, None).ok_or(Error::NoSamples)?, orientation })
    }

    /// Cost of every sample, mm: contour error of the tip, and the direction's error at a lever of 20 mm.
    pub(crate) fn costs_mm(&self) -> Vec<f64> {
        let tip = self.magnitudes_mm();
        match &self.direction_rad {
            Some(angles) => tip.zip(angles).map(|(tip, angle)| tip.hypot(angle * LEVER_MM)).collect(),
            None => tip.collect(),
        }
    }
}

/// Same as [`figures`], for a run whose command `reference` follows the path in another time. Every sample of the path counts once; MAX is that of
/// all samples of the run.
///
/// # Errors
/// As [`contour_errors_along`].
pub fn figures_along(desired: &DesiredPath, part: Option<&Part>, reference: &Trajectory, actual: &Trajectory) -> Result<Figures> {
    let (errors, path_positions) = contour_errors_along(desired, reference, actual)?;
    figures_of(desired, part, &errors, &path_positions, actual)
}

/// Same as [`figures_along`], with the path positions of the samples of `actual` known.
///
/// # Errors
/// When the axes differ from those of the path, or no sample counts.
pub fn figures_at(desired: &DesiredPath, part: Option<&Part>, path_positions: &[f64], actual: &Trajectory) -> Result<Figures> {
    let errors = errors_from(desired, &desired.tips_of(actual)?, &at_places_and_corners(&desired.tips(), path_positions))?;
    figures_of(desired, part, &errors, path_positions, actual)
}

fn figures_of(
    desired: &DesiredPath,
    part: Option<&Part>,
    errors: &[ContourError],
    path_positions: &[f64],
    actual: &Trajectory,
) -> Result<Figures> {
    let poses = poses_at_places(desired.poses(), path_positions);
    let weights = weights(desired, part, path_positions);
    Ok(Figures { tip: weighted(errors, &weights)?, orientation: orientation(desired, errors, &poses, actual, &weights)? })
}

/// Weights of the samples of a run with path positions `path_positions`, with which every sample of the path counts once; `None` for a sample that
/// does not count.
#[must_use]
pub fn weights(desired: &DesiredPath, part: Option<&Part>, path_positions: &[f64]) -> Vec<Option<f64>> {
    let counted = path_positions.iter().map(|position| counts(part, position.round() as usize));
    counted.zip(path_time::weights(desired, path_positions)).map(|(counts, weight)| counts.then_some(weight)).collect()
}

/// Figures of contour errors with these weights.
///
/// # Errors
/// [`Error::NoSamples`] when no sample counts.
pub fn weighted(errors: &[ContourError], weights: &[Option<f64>]) -> Result<ContourSummary> {
    weighted_summary(errors.iter().map(|error| error.magnitude_mm), weights)
}

fn weighted_summary(values: impl Iterator<Item = f64>, weights: &[Option<f64>]) -> Result<ContourSummary> {
    let counted = values.zip(weights).filter_map(|(value, weight)| Some((value, (*weight)?)));
    let (values, weights): (Vec<f64>, Vec<f64>) = counted.unzip();
    summary_of(&values, Some(&weights)).ok_or(Error::NoSamples)
}

/// Orientation figures over the samples of `actual`, with their weights, at the foot points of `errors` on the poses `path`;
/// `None` on a machine without rotary axes.
///
/// # Errors
/// When the axes differ from those of the path, or no sample counts.
pub fn orientation(
    desired: &DesiredPath,
    errors: &[ContourError],
    path: &[Pose],
    actual: &Trajectory,
    weights: &[Option<f64>],
) -> Result<Option<OrientationSummary>> {
    if !desired.kinematics().has_rotary_axes() {
        return Ok(None);
    }
    let poses = poses_of(actual, desired.kinematics().as_ref())?;
    let angles = orientation_errors(errors, &poses, path).into_iter().map(|error| error.angle_rad);
    Ok(Some(angular(&weighted_summary(angles, weights)?)))
}

fn summary_of_angles(angles_rad: &[f64]) -> Result<OrientationSummary> {
    Ok(angular(&summary_of(angles_rad, None).ok_or(Error::NoSamples)?))
}

/// Figures of angles, rad.
fn angular(figures: &ContourSummary) -> OrientationSummary {
    OrientationSummary { rms_rad: figures.rms_mm, mean_rad: figures.mean_mm, max_rad: figures.max_mm, p95_rad: figures.p95_mm }
}

/// RMS, MAX and 95th percentile of the tip's contour error, mm; of a program over its feed moves only.
///
/// # Errors
/// As [`contour_errors`].
pub fn contour(desired: &DesiredPath, part: Option<&Part>, actual: &Trajectory) -> Result<ContourSummary> {
    Ok(figures(desired, part, actual)?.tip)
}

/// Whether sample `sample` of a path is evaluated: every sample of a reference or curve; of a program those of feed
/// moves, since rapids do not cut.
#[must_use]
pub fn counts(part: Option<&Part>, sample: usize) -> bool {
    part.is_none_or(|part| part.feeds_at(sample))
}

/// Rule of [`counts`] for headings.
pub const COUNTED: &str = "over feed moves; rapids do not count";

/// Figures of contour errors, each with its sample index on the path, over the samples that count.
///
/// # Errors
/// When no sample counts.
pub fn summary_of_feed_moves(part: Option<&Part>, errors: impl Iterator<Item = (usize, ContourError)>) -> Result<ContourSummary> {
    let counted: Vec<ContourError> = errors.filter(|(sample, _)| counts(part, *sample)).map(|(_, error)| error).collect();
    summary(&counted).ok_or(Error::NoSamples)
}

/// Root mean square and largest magnitude; zeros for an empty slice.
#[must_use]
pub fn rms_max(values: &[f64]) -> (f64, f64) {
    let squares = values.iter().fold(0.0, |sum, v| sum + v * v);
    ((squares / values.len().max(1) as f64).sqrt(), values.iter().fold(0.0, |top, v| top.max(v.abs())))
}
