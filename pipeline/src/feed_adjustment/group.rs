//! Groups of moves with a common feed factor, and the search for the factor of one group.

use std::ops::Range;

use super::limits::FeedLimits;
use crate::part::Part;

/// Least planned duration of a group at its highest feed, s. Feeds of shorter moves change together, so that the control does not speed up
/// and slow down within every line of a curve.
const GROUP_S: f64 = 0.1;
/// Lowest feed factor.
const LOWEST: f64 = 0.1;
/// Error that the next trial aims at, as a share of the tolerance.
const AIM: f64 = 0.95;
/// Ratio of two factors below which they count as one.
const SAME_FACTOR: f64 = 1.03;
/// Range of one step down or up without a trial beyond the target.
const DOWN: (f64, f64) = (0.5, 0.93);
const UP: f64 = 2.0;
/// Range of the exponent of error over feed by which a step is chosen.
const EXPONENTS: (f64, f64) = (0.5, 2.0);
/// Exponent of error over feed below which the feed is not the cause of the error. Inertial errors grow with its square, servo lag linearly.
const LEAST_EXPONENT: f64 = 0.2;
/// Factors between which the exponent is judged: the lower one is at most this share of the other.
const JUDGED_OVER: f64 = 0.6;
/// Ratio of errors below which a higher feed counts as no worse.
const ABOUT: f64 = 1.02;
/// Significant digits of a written feed.
const FEED_DIGITS: i32 = 3;

/// Consecutive moves with a common programmed feed and a common factor on it.
#[derive(Debug, Clone)]
pub(super) struct Group {
    /// Indices of the moves.
    pub moves: Range<usize>,
    /// Programmed F.
    word: f64,
    /// Bound on the factor.
    pub highest: f64,
    /// Factor in force.
    pub factor: f64,
    /// Factors of all trials with the errors, mm, that they came to.
    seen: Vec<(f64, f64)>,
    /// Whether lower feeds do not reduce the error.
    pub is_speed_independent: bool,
}

/// Groups of the moves whose feeds may change. `duration_s` are the planned durations of all moves.
pub(super) fn groups(part: &Part, limits: &FeedLimits, duration_s: &[f64]) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    let mut open_s = f64::INFINITY;
    for (index, step) in part.toolpath.moves.iter().enumerate() {
        let Some(word) = step.feed_word.filter(|_| limits.allows(part, index)) else { continue };
        let highest = limits.highest(part, index, 1.0);
        let own_s = duration_s[index] / highest.max(1.0);
        let modal = |index: usize| part.toolpath.modal(&part.toolpath.moves[index]);
        match groups.last_mut() {
            Some(last)
                if open_s < GROUP_S
                    && own_s < GROUP_S
                    && last.moves.end == index
                    && last.word == word
                    && last.highest == highest
                    && (modal(index - 1).feed_mode, modal(index - 1).feed_unit_mm)
                        == (modal(index).feed_mode, modal(index).feed_unit_mm) =>
            {
                last.moves.end = index + 1;
                open_s += own_s;
            }
            _ => {
                let factor = 1.0_f64.min(rounded(word, highest));
                groups.push(Group {
                    moves: index..index + 1,
                    word,
                    highest,
                    factor,
                    seen: Vec::new(),
                    is_speed_independent: false,
                });
                open_s = own_s;
            }
        }
    }
    groups
}

impl Group {
    /// Sets the factor, rounded to a feed of few digits; the programmed feed stays as it is.
    pub fn set(&mut self, factor: f64) {
        self.factor = rounded(self.word, factor.min(self.highest));
    }

    /// Notes the largest error, mm, of a trial with the factor in force.
    pub fn note(&mut self, error_mm: f64) {
        self.seen.push((self.factor, error_mm));
    }

    /// Whether the last trial kept the tolerance, mm, or no feed does.
    pub fn holds(&self, tolerance_mm: f64) -> bool {
        self.is_speed_independent || self.seen.last().is_none_or(|(_, error)| *error <= tolerance_mm)
    }

    /// Begins to look for the factor of another tolerance. What the trials came to stays known.
    pub fn restart(&mut self) {
        self.is_speed_independent = false;
    }

    /// Chooses the factor of the next trial. Returns whether it changed.
    pub fn step(&mut self, tolerance_mm: f64, may_raise: bool) -> bool {
        let before = self.factor;
        let Some(&(factor, error)) = self.seen.last() else { return false };
        if self.is_speed_independent {
            return false;
        }
        if error > tolerance_mm {
            if self.is_hopeless(factor, error, tolerance_mm) {
                self.is_speed_independent = true;
                self.set(self.least_error());
            } else {
                self.set(self.lower(factor, error, tolerance_mm));
            }
        } else if let (true, Some(higher)) = (may_raise, self.higher(factor, error, tolerance_mm)) {
            self.set(higher);
        }
        self.factor != before
    }

    /// Whether a lower feed than `factor` would not help: it is the lowest one, or the errors so far hardly depend on the feed.
    fn is_hopeless(&self, factor: f64, error: f64, tolerance_mm: f64) -> bool {
        let any_holds = self.seen.iter().any(|(_, error)| *error <= tolerance_mm);
        let is_flat = |(faster, larger): &(f64, f64)| {
            factor <= JUDGED_OVER * faster
                && larger.is_finite()
                && (larger / error).ln() < LEAST_EXPONENT * (faster / factor).ln()
        };
        let far_down = factor <= JUDGED_OVER * self.highest.min(1.0);
        !any_holds && (factor <= LOWEST * SAME_FACTOR || (far_down && self.seen.iter().any(is_flat)))
    }

    /// The highest factor whose error is about the least one, up to the programmed feed where that was tried: what is above the tolerance is not
    /// sped up.
    fn least_error(&self) -> f64 {
        let is_tried = self.seen.iter().any(|(factor, _)| *factor <= 1.0);
        let seen = || self.seen.iter().filter(|(factor, _)| *factor <= 1.0 || !is_tried);
        let least = seen().map(|(_, error)| *error).fold(f64::INFINITY, f64::min);
        let about = seen().filter(|(_, error)| *error <= ABOUT * least);
        about.map(|(factor, _)| *factor).fold(LOWEST, f64::max)
    }

    /// Exponent of error over feed between the last two trials; that of inertial errors where they show none.
    fn exponent(&self) -> f64 {
        let exponent = match self.seen.as_slice() {
            [.., a, b] => (b.1 / a.1).ln() / (b.0 / a.0).ln(),
            _ => f64::NAN,
        };
        if exponent.is_finite() { exponent.clamp(EXPONENTS.0, EXPONENTS.1) } else { EXPONENTS.1 }
    }

    /// A lower factor: between a known good one and this, else by the power law.
    fn lower(&self, factor: f64, error: f64, tolerance_mm: f64) -> f64 {
        let holds = self.seen.iter().filter(|(f, e)| *f < factor && *e <= tolerance_mm).copied();
        let next = match holds.max_by(|a, b| a.0.total_cmp(&b.0)) {
            Some(good) if factor < good.0 * SAME_FACTOR => good.0,
            Some(good) => between(good, (factor, error), tolerance_mm).clamp(good.0, factor / SAME_FACTOR),
            None => factor * (AIM * tolerance_mm / error).powf(1.0 / self.exponent()).clamp(DOWN.0, DOWN.1),
        };
        next.max(LOWEST)
    }

    /// A higher factor: between this and a known bad one, else by the power law; `None` where there is nothing to gain.
    fn higher(&self, factor: f64, error: f64, tolerance_mm: f64) -> Option<f64> {
        let fails = self.seen.iter().filter(|(f, e)| *f > factor && *e > tolerance_mm).copied();
        let next = match fails.min_by(|a, b| a.0.total_cmp(&b.0)) {
            Some(bad) if bad.0 < factor * SAME_FACTOR * SAME_FACTOR => return None,
            Some(bad) => between((factor, error), bad, tolerance_mm).clamp(factor, bad.0 / SAME_FACTOR),
            None => factor * (AIM * tolerance_mm / error.max(f64::MIN_POSITIVE)).powf(1.0 / self.exponent()).clamp(1.0, UP),
        };
        let next = next.min(self.highest);
        (next > factor * SAME_FACTOR || (next == self.highest && next > factor)).then_some(next)
    }
}

/// Factor at which a power law through two trials meets the aim; the geometric mean where they give no such law.
fn between(good: (f64, f64), bad: (f64, f64), tolerance_mm: f64) -> f64 {
    let (width, rise) = ((bad.0 / good.0).ln(), (bad.1 / good.1.max(f64::MIN_POSITIVE)).ln());
    let share = if rise.is_finite() && rise > 0.0 { (AIM * tolerance_mm / good.1).ln() / rise } else { 0.5 };
    good.0 * (share.clamp(0.0, 1.0) * width).exp()
}

/// The factor at which the feed has few digits, not above `factor`.
fn rounded(word: f64, factor: f64) -> f64 {
    if factor == 1.0 {
        return 1.0;
    }
    let feed = word * factor;
    let unit = 10.0_f64.powi(feed.log10().floor() as i32 + 1 - FEED_DIGITS);
    // A feed of few digits is not rounded down by its last bit.
    ((feed / unit + 1e-9).floor() * unit) / word
}

#[cfg(test)]
mod tests {
    use super::*;

    fn group(highest: f64) -> Group {
        Group { moves: 0..1, word: 1200.0, highest, factor: 1.0, seen: Vec::new(), is_speed_independent: false }
    }

    /// Steps until nothing changes; the factors of all trials.
    fn run(group: &mut Group, tolerance_mm: f64, error_mm: impl Fn(f64) -> f64) -> Vec<f64> {
        let mut factors = Vec::new();
        for _ in 0..12 {
            factors.push(group.factor);
            group.note(error_mm(group.factor));
            if !group.step(tolerance_mm, true) {
                break;
            }
        }
        factors
    }

    #[test]
    fn the_factor_comes_near_the_tolerance_from_below_whatever_the_law_of_the_error() {
        for exponent in [0.7, 1.0, 2.0, 3.0] {
            for at_one in [0.5e-3, 2e-3, 30e-3] {
                let error = |factor: f64| at_one * factor.powf(exponent);
                let mut group = group(10.0);
                let factors = run(&mut group, 5e-3, error);
                let best = (5e-3 / at_one).powf(1.0 / exponent).min(10.0);
                let expected = best.max(LOWEST);
                assert!(group.holds(5e-3) && factors.len() < 12, "{exponent} {at_one}: {factors:?}");
                assert!(group.factor <= expected * 1.001 && group.factor >= 0.85 * expected, "{exponent} {at_one}: {factors:?}");
            }
        }
    }

    #[test]
    fn an_error_that_appears_above_a_speed_is_bracketed() {
        let mut group = group(4.0);
        let factors = run(&mut group, 5e-3, |factor| if factor > 1.7 { 20e-3 } else { 1e-3 });
        assert!(group.factor > 1.5 && group.factor <= 1.7, "{factors:?}");
    }

    #[test]
    fn a_tolerance_out_of_reach_leaves_the_highest_feed_of_the_least_error_up_to_the_programmed_one() {
        let settled = |error: fn(f64) -> f64| {
            let mut group = group(2.0);
            group.note(error(1.0));
            group.set(2.0);
            let factors = run(&mut group, 5e-3, error);
            assert!(group.is_speed_independent, "{factors:?}");
            group.factor
        };
        assert_eq!(settled(|_| 9e-3), 1.0);
        assert_eq!(settled(|factor| if factor > 1.5 { 15e-3 } else { 9e-3 }), 1.0);
        let below = settled(|factor| if factor > 0.8 { 15e-3 } else { 9e-3 });
        assert!(below <= 0.8 && below > 0.4, "{below}");
    }

    #[test]
    fn feeds_have_few_digits_and_are_not_above_their_bound() {
        let mut group = group(1.7777);
        group.set(1.23456);
        assert_eq!(group.factor * group.word, 1480.0);
        group.set(5.0);
        assert!(group.factor <= group.highest && group.factor * group.word == 2130.0, "{}", group.factor);
        group.set(1.0);
        assert_eq!(group.factor, 1.0);
    }
}
