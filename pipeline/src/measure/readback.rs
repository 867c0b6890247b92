//! What a control commanded, against what its program was to make it command.

use datasets::Log;
use motion::contour::{ContourEstimator, ContourSummary};

use super::matching::{Match, match_places};
use crate::error::{Error, Result};
use crate::input::Input;
use crate::statistics::summary_of_feed_moves;

/// A command this near to the intended path, mm at most, is what was meant: a tenth of what a first run leaves.
const NEAR_MM: f64 = 1e-3;
/// Share by which the time between the path's ends may differ.
const SAME_TIME: f64 = 0.03;

/// A command beside its intention.
#[derive(Debug, Clone, Copy)]
pub struct Readback {
    /// Distance of the commanded path from the intended one, over feed moves, mm.
    pub path: ContourSummary,
    /// Time from the path's start to its end as intended, s.
    pub intended_s: f64,
    /// The same as commanded, s.
    pub commanded_s: f64,
    /// Largest difference between the instants at which both pass a place, both starting together, s.
    pub largest_delay_s: f64,
}

impl Readback {
    /// Whether the carrier of the program's points is faithful in space, and in time.
    #[must_use]
    pub fn is_faithful(&self) -> [bool; 2] {
        let ratio = self.commanded_s / self.intended_s;
        [self.path.max_mm <= NEAR_MM, (ratio - 1.0).abs() <= SAME_TIME]
    }
}

/// Compares the command of `log` with what is planned for `intended`; with how the one lies against the other.
///
/// # Errors
/// When the command leads elsewhere.
pub fn readback(log: &Log, intended: &Input, estimator: &mut dyn ContourEstimator) -> Result<(Readback, Match)> {
    let period = log.period_s();
    let commanded = intended.desired().tips_of(&log.reference)?;
    let matched = match_places(intended.desired(), &commanded, period)?;
    let rests = |k: usize| k == 0 || commanded[k] == commanded[k - 1];
    let on_path: Vec<_> = commanded.iter().map(|point| point - matched.offset).collect();
    let errors = estimator.estimate(&on_path, &matched.path)?;
    let places = &matched.places;
    let path = summary_of_feed_moves(intended.part(), places.iter().map(|place| place.round() as usize).zip(errors))?;
    // From where the intended path leaves its start to where it comes to its end.
    let tips = intended.desired().tips();
    let moves = |k: &usize| tips[*k] != tips[k - 1];
    let ends = (1..tips.len()).find(moves).zip((1..tips.len()).rev().find(moves));
    let (start, end) = ends.ok_or(Error::NoMotion)?;
    let passed = |place: usize| places.partition_point(|known| *known < place as f64) as f64;
    let (first, last) = (passed(start), passed(end));
    // A rest is one place at many instants: it makes no one late.
    let within = |(k, place): &(usize, &f64)| !rests(*k) && **place >= start as f64 && **place <= end as f64;
    let late = places.iter().enumerate().filter(within);
    let largest = late.map(|(k, place)| ((k as f64 - first) - (place - start as f64)).abs()).fold(0.0, f64::max);
    let found = Readback {
        path,
        intended_s: (end - start) as f64 * period,
        commanded_s: (last - first) * period,
        largest_delay_s: largest * period,
    };
    Ok((found, matched))
}
