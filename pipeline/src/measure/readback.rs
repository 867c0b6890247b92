//! Readback: comparison of a recorded command with the command that its program intends.

use datasets::Log;
use motion::contour::{ContourEstimator, ContourSummary};

use super::matching::{Match, match_by_position};
use crate::error::{Error, Result};
use crate::input::Input;
use crate::statistics::{counts, summary_of_feed_moves};

/// Largest distance of a faithful command from the intended path, mm: a tenth of the residual error of a first run.
const NEAR_MM: f64 = 1e-3;
/// Largest relative difference of the duration of a faithful command.
const SAME_TIME: f64 = 0.03;
/// Largest RMS of relative speed differences over feed moves of a command that is as planned, and the time over which a speed is taken, s.
const SAME_SPEED: f64 = 0.02;
const SPEED_SPAN_S: f64 = 0.02;

/// Comparison of a command with the intended one.
#[derive(Debug, Clone, Copy)]
pub struct Readback {
    /// Distance of the commanded path from the intended one over feed moves, mm.
    pub path: ContourSummary,
    /// Intended time from the start to the end of the path, s.
    pub intended_s: f64,
    /// Commanded time from the start to the end of the path, s.
    pub commanded_s: f64,
    /// Largest time difference at a path position, with a common start, s.
    pub largest_delay_s: f64,
    /// RMS of the relative difference of speeds at the same place of the path, over feed moves.
    pub speed_difference: f64,
}

impl Readback {
    /// Whether the control took longer than intended.
    #[must_use]
    pub fn is_slow(&self) -> bool {
        self.commanded_s > (1.0 + SAME_TIME) * self.intended_s
    }

    /// Whether the program's output format reproduces the path in space, and in time.
    #[must_use]
    pub fn is_faithful(&self) -> [bool; 2] {
        let ratio = self.commanded_s / self.intended_s;
        [self.path.max_mm <= NEAR_MM, (ratio - 1.0).abs() <= SAME_TIME]
    }

    /// Whether the control plans as was intended: path, time and speeds are the same.
    #[must_use]
    pub fn is_as_planned(&self) -> bool {
        self.is_faithful() == [true, true] && self.speed_difference <= SAME_SPEED
    }
}

/// Compares the command of `log` with the plan of `intended`. Also returns their alignment.
///
/// # Errors
/// When the command leaves the path, or the path has no motion.
pub fn readback(log: &Log, intended: &Input, estimator: &mut dyn ContourEstimator) -> Result<(Readback, Match)> {
    let period = log.period_s();
    let commanded = intended.desired().tips_of(&log.reference)?;
    let matched = match_by_position(intended.desired(), &log.reference)?;
    let is_still = |k: usize| k == 0 || commanded[k] == commanded[k - 1];
    let on_path: Vec<_> = commanded.iter().map(|point| point - matched.offset).collect();
    let errors = estimator.estimate(&on_path, &matched.path)?;
    let path_positions = &matched.path_positions;
    let path =
        summary_of_feed_moves(intended.part(), path_positions.iter().map(|position| position.round() as usize).zip(errors))?;
    // From the end of the first standstill to the start of the last one.
    let tips = intended.desired().tips();
    let moves = |k: &usize| tips[*k] != tips[k - 1];
    let ends = (1..tips.len()).find(moves).zip((1..tips.len()).rev().find(moves));
    let (start, end) = ends.ok_or(Error::NoMotion)?;
    let passed = |position: usize| path_positions.partition_point(|known| *known < position as f64);
    // Whether a command that rests within a fraction of a micrometre of an end lies before or behind it is chance: such a
    // rest is not part of the path.
    let leaves = |k: &usize| k + 1 >= commanded.len() || !is_still(k + 1);
    let first = (passed(start)..commanded.len()).find(leaves).unwrap_or(0);
    let reached = passed(end).min(commanded.len().saturating_sub(1));
    let last = (first..=reached).rev().find(|k| !is_still(*k)).unwrap_or(reached);
    let (first, last) = (first as f64, last as f64);
    // A standstill is one position at many instants and counts as no delay.
    let within = |(k, position): &(usize, &f64)| !is_still(*k) && **position >= start as f64 && **position <= end as f64;
    let late = path_positions.iter().enumerate().filter(within);
    let largest = late.map(|(k, position)| ((k as f64 - first) - (position - start as f64)).abs()).fold(0.0, f64::max);
    let span = (SPEED_SPAN_S / period).round().max(1.0) as usize;
    let differences = path_positions.windows(span + 1).enumerate().filter_map(|(from, passed)| {
        let moves = (from + 1..=from + span).all(|k| !is_still(k));
        let counts = counts(intended.part(), passed[0].round() as usize);
        (moves && counts).then_some((passed[span] - passed[0]) / span as f64 - 1.0)
    });
    let (count, squares) =
        differences.fold((0_usize, 0.0), |(count, sum), difference| (count + 1, sum + difference * difference));
    let found = Readback {
        speed_difference: (squares / count.max(1) as f64).sqrt(),
        path,
        intended_s: (end - start) as f64 * period,
        commanded_s: (last - first) * period,
        largest_delay_s: largest * period,
    };
    Ok((found, matched))
}
