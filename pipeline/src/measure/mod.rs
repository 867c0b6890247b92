//! A recorded run against the path that the part needs.

mod matching;
mod model_check;
mod readback;
mod reversals;

use std::collections::BTreeMap;

use datasets::Log;
use motion::contour::{
    CirclePlane, CircularTest, ContourError, ContourEstimator, ContourSummary, NominalCircle, circular_test, poses_at_places,
    summary_of,
};
use motion::{Vec3, lag_s};

use crate::error::Result;
use crate::input::Input;
use crate::statistics::{self, OrientationSummary, summary_of_feed_moves};

pub use matching::{Match, in_path_time, in_time_of, match_places, match_run, without_approach};
pub use model_check::{Fit, fits};
pub use readback::{Readback, readback};
pub use reversals::{Reversal, reversals};

/// Worst places that are shown, and how far apart they have to be, s.
const WORST: usize = 5;
const APART_S: f64 = 0.05;

/// Everything measured of a run. Lengths in mm, times in s.
#[derive(Debug)]
pub struct Measurement {
    /// Contour error over the samples of the run.
    pub contour: ContourSummary,
    /// Error of the tool's direction, on a machine that turns it.
    pub orientation: Option<OrientationSummary>,
    /// How the run lies against the path.
    pub matched: Match,
    /// Delay of every axis's actual position behind its command; `None` where it does not move.
    pub lags_s: Vec<Option<f64>>,
    /// Every reversal of an axis.
    pub reversals: Vec<Reversal>,
    /// The worst places, worst first; none on rapids.
    pub worst: Vec<Place>,
    /// Lines of a program that feed, or stretches between rests, in order.
    pub segments: Vec<Segment>,
    /// Circular-test figures, where the path is a full circle.
    pub circle: Option<CircularTest>,
}

/// One place of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Time in the log, s.
    pub time_s: f64,
    /// Where on the desired path, mm.
    pub at: Vec3,
    /// Contour error, mm.
    pub error_mm: f64,
    /// Line of the program, from 1.
    pub line: Option<usize>,
}

/// One stretch of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// Line of the program, from 1, where there is one.
    pub line: Option<usize>,
    /// Time of its first sample, s.
    pub from_s: f64,
    /// Its contour error.
    pub contour: ContourSummary,
    /// Its samples.
    pub samples: usize,
}

/// Measures `log` against `desired` (the log's own command where that is `None`).
///
/// # Errors
/// When the run leads elsewhere than the path.
pub fn measure(log: &Log, desired: &Input, estimator: &mut dyn ContourEstimator) -> Result<Measurement> {
    let (path, part, period) = (desired.desired(), desired.part(), log.period_s());
    let (commanded, actual) = (path.tips_of(&log.reference)?, path.tips_of(&log.actual)?);
    let matched = match_run(path, &commanded, period)?;
    let actual: Vec<Vec3> = actual.into_iter().map(|point| point - matched.offset).collect();
    let errors = estimator.estimate(&actual, &matched.path)?;
    let placed = matched.places.iter().map(|place| place.round() as usize).zip(errors.iter().copied());
    let contour = summary_of_feed_moves(part, placed)?;
    let counts = |k: &usize| statistics::counts(part, matched.places[*k].round() as usize);
    let poses = poses_at_places(path.poses(), &matched.places);
    let orientation = statistics::orientation(path, &errors, &poses, &log.actual, counts)?;
    let line = |k: usize| {
        let part = part?;
        part.line_at((matched.places[k].round() as usize).min(part.plan.samples.len().saturating_sub(1)))
    };
    let lags_s: Vec<Option<f64>> = log
        .reference
        .columns()
        .iter()
        .zip(log.actual.columns())
        .map(|(reference, actual)| lag_s(reference, actual, period))
        .collect();
    let circle = circle(&matched.path, &actual);
    Ok(Measurement {
        contour,
        orientation,
        reversals: reversals(log, &errors, &lags_s),
        worst: worst(&errors, period, counts, line),
        segments: segments(&errors, &matched.path, period, part.is_some(), |k| line(k).filter(|_| counts(&k))),
        lags_s,
        circle,
        matched,
    })
}

impl Measurement {
    /// Delay that all axes share, s: it hardly hurts a contour. The mean over the moving axes.
    #[must_use]
    pub fn common_lag_s(&self) -> Option<f64> {
        let lags: Vec<f64> = self.lags_s.iter().flatten().copied().collect();
        (!lags.is_empty()).then(|| lags.iter().sum::<f64>() / lags.len() as f64)
    }
}

fn worst(
    errors: &[ContourError],
    period_s: f64,
    counts: impl Fn(&usize) -> bool,
    line: impl Fn(usize) -> Option<usize>,
) -> Vec<Place> {
    let apart = (APART_S / period_s).ceil() as usize;
    let mut order: Vec<usize> = (0..errors.len()).filter(counts).collect();
    order.sort_by(|a, b| errors[*b].magnitude_mm.total_cmp(&errors[*a].magnitude_mm));
    let mut chosen: Vec<usize> = Vec::new();
    for k in order {
        if chosen.len() == WORST {
            break;
        }
        if chosen.iter().all(|other| other.abs_diff(k) > apart) {
            chosen.push(k);
        }
    }
    let place =
        |k: usize| Place { time_s: k as f64 * period_s, at: errors[k].foot, error_mm: errors[k].magnitude_mm, line: line(k) };
    chosen.into_iter().map(place).collect()
}

/// By line of the program; without one, by stretches between rests of the path.
fn segments(
    errors: &[ContourError],
    path: &[Vec3],
    period_s: f64,
    by_line: bool,
    line: impl Fn(usize) -> Option<usize>,
) -> Vec<Segment> {
    let mut groups: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    let mut stretch = 0;
    for k in 0..errors.len() {
        let moves = k > 0 && path[k] != path[k - 1];
        if by_line {
            if let Some(line) = line(k) {
                groups.entry(line).or_default().push(k);
            }
        } else if moves {
            groups.entry(stretch).or_default().push(k);
        } else if groups.contains_key(&stretch) {
            stretch += 1;
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

/// How round a path has to be to be taken for a programmed circle, mm.
const ROUND_MM: f64 = 5e-4;

/// Circular-test figures, where the desired path is a circle in one of the main planes.
fn circle(desired: &[Vec3], actual: &[Vec3]) -> Option<CircularTest> {
    let range = |axis: usize| {
        let values = desired.iter().map(|point| point[axis]);
        values.clone().fold(f64::NEG_INFINITY, f64::max) - values.fold(f64::INFINITY, f64::min)
    };
    let planes = [(CirclePlane::Yz, 0), (CirclePlane::Zx, 1), (CirclePlane::Xy, 2)];
    let (plane, _) = planes.into_iter().find(|(_, normal)| range(*normal) < ROUND_MM)?;
    let wanted = circular_test(desired, plane, NominalCircle { centre: None, radius_mm: 1.0 }).ok()?;
    let round = [wanted.counterclockwise, wanted.clockwise].into_iter().flatten().all(|one| one.circular_deviation_mm < ROUND_MM);
    let nominal = NominalCircle { centre: Some(wanted.centre), radius_mm: wanted.radius_mm };
    round.then(|| circular_test(actual, plane, nominal).ok()).flatten()
}
