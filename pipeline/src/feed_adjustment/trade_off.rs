//! Cycle time against predicted error: the trade-off between both over the feeds.

use models::Bundle;

use super::limits::FeedLimits;
use super::search::{Search, Visit};
use crate::error::Result;
use crate::model_based_ilc::Settings;
use crate::part::Part;
use crate::progress::Progress;

/// Tolerances for which feeds are looked for, and trials for each of them.
const TOLERANCES: usize = 8;
const ROUNDS_EACH: usize = 2;
/// Least tolerance as a share of the error at the programmed feeds.
const LEAST_SHARE: f64 = 0.25;

/// Share by which MAX has to be less for a longer cycle to count.
const SAME: f64 = 5e-3;

/// One choice of feeds, which no other one undercuts in both figures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TradeOff {
    /// Cycle time of the compensated program, s.
    pub cycle_s: f64,
    /// Largest predicted contour error over feed moves, mm.
    pub max_mm: f64,
    /// Root mean square of it, mm.
    pub rms_mm: f64,
}

/// Up to `count` choices of feeds from the shortest cycle to the least predicted error, and the one of the programmed feeds. Also returns the
/// part, at its programmed feeds.
///
/// # Errors
/// When `limits` leave no feed to change, planning fails, or the path does not fit the model.
pub fn trade_off(
    part: Part,
    model: &Bundle,
    settings: &Settings,
    count: usize,
    limits: &FeedLimits,
    progress: Progress<'_>,
) -> Result<(Part, TradeOff, Vec<TradeOff>)> {
    let programmed = part.feed_factors.clone();
    let (mut search, trial) = Search::begin(part, model, settings, limits, progress)?;
    let own = TradeOff::from(&search.visits[0]);
    let mut trial = trial;
    for cycle_limit in search.cycle_limits().into_iter().skip(1) {
        trial = search.run_within(trial.into_part()?, cycle_limit)?;
    }
    let trial = search.run_at_bounds(trial)?;
    let most_mm = trial.max_mm();
    let trial = search.sweep(trial, (most_mm, LEAST_SHARE * own.max_mm.min(most_mm)), TOLERANCES, ROUNDS_EACH)?;
    let part = trial.into_part()?;
    let part = if part.feed_factors == programmed { part } else { part.with_feeds(programmed)? };
    Ok((part, own, spread(front(&search.visits), count)))
}

impl From<&Visit> for TradeOff {
    fn from(visit: &Visit) -> Self {
        Self { cycle_s: visit.cycle_s, max_mm: visit.max_mm, rms_mm: visit.rms_mm }
    }
}

/// The trials that no other one undercuts in both figures, the shortest cycle first.
fn front(visits: &[Visit]) -> Vec<TradeOff> {
    let mut points: Vec<TradeOff> = visits.iter().map(TradeOff::from).collect();
    points.sort_by(|a, b| a.cycle_s.total_cmp(&b.cycle_s).then(a.max_mm.total_cmp(&b.max_mm)));
    let mut least_mm = f64::INFINITY;
    points.retain(|point| {
        let is_less = point.max_mm < (1.0 - SAME) * least_mm;
        if is_less {
            least_mm = point.max_mm;
        }
        is_less
    });
    points
}

/// At most `count` of the points: both ends, and those nearest to even shares of the cycle time between them.
fn spread(points: Vec<TradeOff>, count: usize) -> Vec<TradeOff> {
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return points };
    if points.len() <= count {
        return points;
    }
    let at = |number: usize| first.cycle_s + (last.cycle_s - first.cycle_s) * number as f64 / (count.max(2) - 1) as f64;
    let nearest = |wanted: f64| {
        (0..points.len()).min_by(|a, b| (points[*a].cycle_s - wanted).abs().total_cmp(&(points[*b].cycle_s - wanted).abs()))
    };
    let mut chosen: Vec<usize> = (0..count).filter_map(|number| nearest(at(number))).collect();
    chosen.dedup();
    chosen.into_iter().map(|index| points[index]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn visit(cycle_s: f64, max_mm: f64) -> Visit {
        Visit { factors: Vec::new(), settings: Settings::default(), cycle_s, errors_mm: Vec::new(), max_mm, rms_mm: 0.3 * max_mm }
    }

    #[test]
    fn of_the_front_no_point_is_undercut_in_both_figures() {
        let front =
            front(&[visit(5.0, 1.0), visit(1.0, 9.0), visit(3.0, 9.5), visit(3.0, 2.0), visit(3.0, 4.0), visit(6.0, 1.0)]);
        let figures: Vec<(f64, f64)> = front.iter().map(|point| (point.cycle_s, point.max_mm)).collect();
        assert_eq!(figures, [(1.0, 9.0), (3.0, 2.0), (5.0, 1.0)]);
    }

    #[test]
    fn few_points_of_many_keep_both_ends() {
        let points: Vec<TradeOff> = (0..50).map(|k| TradeOff::from(&visit(f64::from(k).powi(2), f64::from(100 - k)))).collect();
        let few = spread(points.clone(), 10);
        assert!(few.len() <= 10 && few.len() >= 8, "{few:?}");
        assert_eq!((few[0], few[few.len() - 1]), (points[0], points[49]));
    }
}
