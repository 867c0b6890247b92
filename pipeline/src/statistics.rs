//! Figures of a run.

use motion::contour::{
    ContourError, ContourEstimator, ContourSummary, Exact, ExactOnCurve, at_places, follow, orientation_errors, poses_at_places,
    summary, summary_of,
};
use motion::{DesiredPath, Pose, Trajectory, Vec3, poses_of};

use crate::error::{Error, Result};
use crate::part::Part;

/// Contour error of every sample of `actual`: distance from the nearest place of the desired path (actual → desired), exact, against
/// the analytic curve where one is known.
///
/// # Errors
/// When the two do not match.
pub fn contour_errors(desired: &DesiredPath, actual: &Trajectory) -> Result<Vec<ContourError>> {
    errors_from(desired, &desired.tips_of(actual)?, &desired.tips())
}

/// As [`contour_errors`], for a run whose command `reference` keeps near the path but not its time: a program that a control planned
/// anew. With the place on the path of every sample, in samples of `desired`.
///
/// # Errors
/// When `reference` leads elsewhere.
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
        let places = (0..path.len()).map(|k| k as f64).collect();
        return Ok((errors_from(desired, &desired.tips_of(actual)?, &path)?, places));
    }
    let places = follow(&commanded, &path)?;
    Ok((errors_from(desired, &desired.tips_of(actual)?, &at_places(&path, &places))?, places))
}

/// Errors of the tips of a run from the path whose places at the same instants are `path`.
fn errors_from(desired: &DesiredPath, tips: &[Vec3], path: &[Vec3]) -> Result<Vec<ContourError>> {
    let mut estimator: Box<dyn ContourEstimator> = match desired.curve() {
        Some(curve) => Box::new(ExactOnCurve::new(curve.clone())),
        None => Box::new(Exact::default()),
    };
    Ok(estimator.estimate(tips, path)?)
}

/// The figures of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figures {
    /// Contour error of the tool tip, mm.
    pub tip: ContourSummary,
    /// Contour error of the tool's direction, on a machine that turns it.
    pub orientation: Option<OrientationSummary>,
}

/// Orientation errors in three figures, rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrientationSummary {
    /// Root of the mean square.
    pub rms_rad: f64,
    /// Largest.
    pub max_rad: f64,
    /// What 95 % of the samples stay within.
    pub p95_rad: f64,
}

impl Figures {
    /// Every RMS and MAX the mean over the runs; `None` where there is none.
    #[must_use]
    pub fn mean(runs: &[Self]) -> Option<Self> {
        let over = |of: &dyn Fn(&Self) -> f64| runs.iter().map(of).sum::<f64>() / runs.len() as f64;
        let mut mean = *runs.first()?;
        mean.tip.rms_mm = over(&|run| run.tip.rms_mm);
        mean.tip.max_mm = over(&|run| run.tip.max_mm);
        mean.tip.p95_mm = over(&|run| run.tip.p95_mm);
        if let Some(orientation) = &mut mean.orientation {
            orientation.rms_rad = over(&|run| run.orientation.map_or(0.0, |o| o.rms_rad));
            orientation.max_rad = over(&|run| run.orientation.map_or(0.0, |o| o.max_rad));
            orientation.p95_rad = over(&|run| run.orientation.map_or(0.0, |o| o.p95_rad));
        }
        Some(mean)
    }
}

/// Length at which an error of the tool's direction counts like one of its tip, mm: the depth of a side mill's cut.
const LEVER_MM: f64 = 20.0;

impl Figures {
    /// One figure to judge a run by: the root mean square of the tip's error and of the direction's at a lever of 20 mm, mm.
    #[must_use]
    pub fn cost_mm(&self) -> f64 {
        self.tip.rms_mm.hypot(self.orientation.map_or(0.0, |orientation| orientation.rms_rad * LEVER_MM))
    }
}

/// Contour error of tip and tool over the samples of a run; of a program only over those of its feed moves.
///
/// # Errors
/// As [`contour_errors`].
pub fn figures(desired: &DesiredPath, part: Option<&Part>, actual: &Trajectory) -> Result<Figures> {
    figures_where(desired, actual, |k| counts(part, *k))
}

/// As [`figures`], over the samples for which `counts` says so.
///
/// # Errors
/// As [`contour_errors`]; when no sample counts.
pub fn figures_where(desired: &DesiredPath, actual: &Trajectory, counts: impl Fn(&usize) -> bool) -> Result<Figures> {
    let poses = poses_of(actual, desired.kinematics().as_ref())?;
    let tips: Vec<Vec3> = poses.iter().map(|pose| pose.tip).collect();
    let errors = errors_from(desired, &tips, &desired.tips())?;
    let turns = desired.kinematics().has_rotary_axes();
    let orientation = turns.then(|| summary_of_directions(&errors, desired.poses(), &poses, &counts)).transpose()?;
    let counted: Vec<ContourError> = errors.into_iter().enumerate().filter(|(k, _)| counts(k)).map(|(_, error)| error).collect();
    let tip = summary(&counted).ok_or(Error::NoSamples)?;
    Ok(Figures { tip, orientation })
}

/// As [`figures`], for a run whose command `reference` keeps near the path but not its time.
///
/// # Errors
/// As [`contour_errors_along`].
pub fn figures_along(desired: &DesiredPath, part: Option<&Part>, reference: &Trajectory, actual: &Trajectory) -> Result<Figures> {
    let (errors, places) = contour_errors_along(desired, reference, actual)?;
    let poses = poses_at_places(desired.poses(), &places);
    let places: Vec<usize> = places.iter().map(|place| place.round() as usize).collect();
    let counts = |k: &usize| counts(part, places[*k]);
    let orientation = orientation(desired, &errors, &poses, actual, counts)?;
    Ok(Figures { tip: summary_of_feed_moves(part, places.iter().copied().zip(errors))?, orientation })
}

/// Figures of the tool's direction at the feet of `errors` on the poses `path`, over the samples of `actual` that count; `None` on a machine that
/// does not turn the tool.
///
/// # Errors
/// When the axes are not the path's, or no sample counts.
pub fn orientation(
    desired: &DesiredPath,
    errors: &[ContourError],
    path: &[Pose],
    actual: &Trajectory,
    counts: impl Fn(&usize) -> bool,
) -> Result<Option<OrientationSummary>> {
    if !desired.kinematics().has_rotary_axes() {
        return Ok(None);
    }
    let poses = poses_of(actual, desired.kinematics().as_ref())?;
    summary_of_directions(errors, path, &poses, counts).map(Some)
}

/// Figures of the tool's direction of the poses `actual`, at the feet of their `errors` on the poses `path`, over the samples that count.
fn summary_of_directions(
    errors: &[ContourError],
    path: &[Pose],
    actual: &[Pose],
    counts: impl Fn(&usize) -> bool,
) -> Result<OrientationSummary> {
    let angles = orientation_errors(errors, actual, path).into_iter().enumerate().filter(|(k, _)| counts(k));
    let angles: Vec<f64> = angles.map(|(_, error)| error.angle_rad).collect();
    let figures = summary_of(&angles, None).ok_or(Error::NoSamples)?;
    Ok(OrientationSummary { rms_rad: figures.rms_mm, max_rad: figures.max_mm, p95_rad: figures.p95_mm })
}

/// RMS, MAX and 95th percentile of the tip's contour error over the samples of a run, mm; of a program only over those of its feed moves.
///
/// # Errors
/// As [`contour_errors`].
pub fn contour(desired: &DesiredPath, part: Option<&Part>, actual: &Trajectory) -> Result<ContourSummary> {
    Ok(figures(desired, part, actual)?.tip)
}

/// Whether the sample `place` of a path counts in figures: every one of a reference or curve, of a program those of its feed moves. Rapids do not
/// cut.
#[must_use]
pub fn counts(part: Option<&Part>, place: usize) -> bool {
    part.is_none_or(|part| part.feeds_at(place))
}

/// What [`counts`], in words for headings.
pub const COUNTED: &str = "over feed moves; rapids do not count";

/// The figures of errors, each with its place on the path in samples, over those that count.
///
/// # Errors
/// When none counts.
pub fn summary_of_feed_moves(part: Option<&Part>, errors: impl Iterator<Item = (usize, ContourError)>) -> Result<ContourSummary> {
    let counted: Vec<ContourError> = errors.filter(|(place, _)| counts(part, *place)).map(|(_, error)| error).collect();
    summary(&counted).ok_or(Error::NoSamples)
}

/// Root mean square and largest magnitude; zeros of nothing.
#[must_use]
pub fn rms_max(values: &[f64]) -> (f64, f64) {
    let squares: f64 = values.iter().map(|v| v * v).sum();
    ((squares / values.len().max(1) as f64).sqrt(), values.iter().fold(0.0, |top, v| top.max(v.abs())))
}
