//! Measurement of a recorded run against the desired path.
//!
//! The path is always the one that the part needs: for the run of a compensated program the original program. Use
//! [`Exact::default()`](motion::contour::Exact) as estimator; the others reproduce the papers.
//!
//! [`measure`] aligns a log with the path and evaluates contour error, lags, reversals and, on a full circle, the
//! circular test. [`readback`] compares command and program, [`fits`] compares model and log.

mod long;
mod matching;
mod measurement;
mod model_check;
mod readback;
mod reversals;

use std::collections::BTreeMap;

use datasets::Log;
use motion::contour::{
    CirclePlane, CircularTest, ContourError, ContourEstimator, NominalCircle, circular_test, poses_at_places, summary_of,
};
use motion::{Vec3, lag_s};

use crate::analysis::worst_samples;
use crate::error::Result;
use crate::input::Input;
use crate::statistics::{self, rms_max};

use measurement::{APART_S, WORST};

pub use long::LongLog;
pub use matching::{Match, match_by_position, match_run, without_approach, without_offset, without_rests};
pub use measurement::{Measurement, Segment, WorstPoint};
pub use model_check::{Fit, fits};
pub use readback::{Readback, readback};
pub use reversals::{Reversal, reversal_samples, reversals};

/// Measures `log` against the path `desired`, with contour errors from `estimator`.
///
/// # Errors
/// When the command of the log leaves the path.
pub fn measure(log: &Log, desired: &Input, estimator: &mut dyn ContourEstimator) -> Result<Measurement> {
    let (path, part, period) = (desired.desired(), desired.part(), log.period_s());
    let matched = match_run(path, &log.reference)?;
    let actual: Vec<Vec3> = path.tips_of(&log.actual)?.into_iter().map(|point| point - matched.offset).collect();
    let errors = estimator.estimate(&actual, &matched.path)?;
    let weights = statistics::weights(path, part, &matched.path_positions);
    let contour = statistics::weighted(&errors, &weights)?;
    let counts = |k: &usize| weights[*k].is_some();
    let poses = poses_at_places(path.poses(), &matched.path_positions);
    let orientation = statistics::orientation(path, &errors, &poses, &log.actual, &weights)?;
    let line = |k: usize| {
        let part = part?;
        part.line_at((matched.path_positions[k].round() as usize).min(part.plan.samples.len().saturating_sub(1)))
    };
    let lags_s: Vec<Option<f64>> = log
        .reference
        .columns()
        .iter()
        .zip(log.actual.columns())
        .map(|(reference, actual)| lag_s(reference, actual, period))
        .collect();
    let circle = circle(&matched.path, &actual);
    let reversals = reversals(log, &errors, &lags_s);
    let segments = segments(&errors, &matched.path, period, part.is_some(), |k| line(k).filter(|_| counts(&k)));
    Ok(Measurement {
        axes: log.axes().to_vec(),
        tracking: log.reference.tracking_error(&log.actual)?.iter().map(|error| rms_max(error)).collect(),
        contour,
        orientation,
        reversals_found: reversals.len(),
        reversals,
        worst: worst(&errors, period, counts, line),
        segments_found: segments.len(),
        segments,
        lags_s,
        circle,
        matched,
        weights,
        errors,
    })
}

fn worst(
    errors: &[ContourError],
    period_s: f64,
    counts: impl Fn(&usize) -> bool,
    line: impl Fn(usize) -> Option<usize>,
) -> Vec<WorstPoint> {
    let apart = (APART_S / period_s).ceil() as usize;
    let magnitude = |k: usize| if counts(&k) { errors[k].magnitude_mm } else { f64::NAN };
    let chosen = worst_samples(&(0..errors.len()).map(magnitude).collect::<Vec<f64>>(), WORST, apart);
    let point = |k: usize| WorstPoint {
        time_s: k as f64 * period_s,
        at: errors[k].foot,
        error_mm: errors[k].magnitude_mm,
        line: line(k),
    };
    chosen.into_iter().map(point).collect()
}

/// Segments by program line; without a program by motion between standstills of the path.
fn segments(
    errors: &[ContourError],
    path: &[Vec3],
    period_s: f64,
    by_line: bool,
    line: impl Fn(usize) -> Option<usize>,
) -> Vec<Segment> {
    let mut groups: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    let mut segment = 0;
    for k in 0..errors.len() {
        let moves = k > 0 && path[k] != path[k - 1];
        if by_line {
            if let Some(line) = line(k) {
                groups.entry(line).or_default().push(k);
            }
        } else if moves {
            groups.entry(segment).or_default().push(k);
        } else if groups.contains_key(&segment) {
            segment += 1;
        }
    }
    groups
        .into_iter()
        .filter_map(|(key, samples)| {
            let magnitudes: Vec<f64> = samples.iter().map(|&k| errors[k].magnitude_mm).collect();
            Some(Segment {
                line: by_line.then_some(key),
                from_s: *samples.first()? as f64 * period_s,
                contour: summary_of(&magnitudes, None)?,
                samples: samples.len(),
            })
        })
        .collect()
}

/// Largest circular deviation of a path that counts as a programmed circle, mm.
const CIRCULARITY_MM: f64 = 5e-4;

/// Circular-test figures of a run along `desired`, mm; `None` where that is not a circle in a main plane.
#[must_use]
pub fn circle(desired: &[Vec3], actual: &[Vec3]) -> Option<CircularTest> {
    let (plane, nominal) = nominal_circle(desired)?;
    circular_test(actual, plane, nominal).ok()
}

/// The circle in a main plane that a path follows, at most with a lead-in and a lead-out, mm; `None` for other paths.
#[must_use]
pub fn nominal_circle(desired: &[Vec3]) -> Option<(CirclePlane, NominalCircle)> {
    let range = |axis: usize| {
        let values = desired.iter().map(|point| point[axis]);
        values.clone().fold(f64::NEG_INFINITY, f64::max) - values.fold(f64::INFINITY, f64::min)
    };
    let planes = [(CirclePlane::Yz, 0), (CirclePlane::Zx, 1), (CirclePlane::Xy, 2)];
    let (plane, _) = planes.into_iter().find(|(_, normal)| range(*normal) < CIRCULARITY_MM)?;
    let wanted = circular_test(desired, plane, NominalCircle { centre: None, radius_mm: 1.0 }).ok()?;
    let round =
        [wanted.counterclockwise, wanted.clockwise].into_iter().flatten().all(|one| one.circular_deviation_mm < CIRCULARITY_MM);
    round.then_some((plane, NominalCircle { centre: Some(wanted.centre), radius_mm: wanted.radius_mm }))
}
