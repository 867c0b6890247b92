//! Search for the feeds of the shortest cycle within a tolerance.
//!
//! The problem: the least sum of `length / feed` over groups of moves, with the predicted error of every group after compensation within the
//! tolerance, and feeds within their bounds. The error of a group has no formula: compensation, replanning and the feeds of its neighbours take
//! part in it. Every trial therefore plans, compensates and forecasts the whole program, and moves all factors at once, each by the secant of its
//! own trials in the logarithms of feed and error. First factors may rise and fall; at last they only fall where the tolerance is exceeded, so
//! that the search ends.

use models::{Bundle, OperatingRange};

use super::group::{Group, groups};
use super::limits::FeedLimits;
use super::trial::Trial;
use crate::error::Result;
use crate::model_based_ilc::{FewerPoints, Settings};
use crate::part::Part;
use crate::progress::Progress;

/// Time on both sides of a sample whose groups may cause its error, s: a model-based correction reaches as far.
const REACH_S: f64 = 0.02;

/// Share of the excess over a tolerance that a trial has to take off for as much time again, where the tolerance is what is asked for.
const PRICE_OF_TIME: f64 = 0.1;
/// The same where time is what is asked for. A pocket on `random:777331` took 18 % longer at the price of above, for 5.0 instead of 5.3 µm; an engraving
/// on `random:60607` still has 20.7 instead of 26.5 µm for 2.5 % here.
const HIGH_PRICE_OF_TIME: f64 = 1.0;
/// Larger limits of the increase of the cycle time by a correction, and the largest one.
const WIDER_LIMITS: [f64; 2] = [0.03, 0.1];
const MOST_CYCLE_LIMIT: f64 = 0.1;

/// A trial: its factors, one a group, and what it came to.
#[derive(Debug, Clone)]
pub(super) struct Visit {
    pub factors: Vec<f64>,
    /// How the correction was learned.
    pub settings: Settings,
    /// Duration of the program as written, s.
    pub cycle_s: f64,
    /// Largest predicted error of every group, mm.
    pub errors_mm: Vec<f64>,
    /// Predicted errors over feed moves, mm.
    pub max_mm: f64,
    pub rms_mm: f64,
}

/// Search over the factors of all groups.
pub(super) struct Search<'a> {
    model: &'a Bundle,
    ranges: Vec<OperatingRange>,
    /// Settings that were asked for, which the first trial has, and those of the others.
    pub asked: Settings,
    settings: Settings,
    progress: Progress<'a>,
    /// Cycle time up to which a correction may lengthen the cycle of slower trials beyond its own limit, s.
    pub most_s: Option<f64>,
    price_of_time: f64,
    pub groups: Vec<Group>,
    /// All trials.
    pub visits: Vec<Visit>,
}

impl<'a> Search<'a> {
    /// Begins with a trial at the programmed feeds, within the limits. It is what becomes of the program without other feeds.
    pub fn begin(
        part: Part,
        model: &'a Bundle,
        asked: &Settings,
        limits: &FeedLimits,
        progress: Progress<'a>,
    ) -> Result<(Self, Trial)> {
        limits.check(&part)?;
        let groups = groups(&part, limits, &durations_s(&part));
        // Of the points of a trial only the error counts, not their number.
        let fewer_points = match asked.fewer_points {
            FewerPoints::Never => FewerPoints::Never,
            FewerPoints::WhereTooSlow | FewerPoints::WhereForecastAllows => FewerPoints::WhereTooSlow,
        };
        // Other limits are trials of their own.
        let settings =
            Settings { fewer_points, tries_usual_limit: false, tries_larger_limit: false, unavoidable_apart: false, ..*asked };
        let (ranges, asked) = (model.coverage(), *asked);
        let (most_s, price_of_time, visits) = (None, PRICE_OF_TIME, Vec::new());
        let mut search = Self { model, ranges, asked, settings, progress, most_s, price_of_time, groups, visits };
        let trial = search.run_with(part, asked)?;
        Ok((search, trial))
    }

    /// Plans, compensates and forecasts `part` with the factors of the groups.
    pub fn run(&mut self, part: Part) -> Result<Trial> {
        let part = self.with_factors(part)?;
        let planned_s = part.plan.desired.trajectory().duration_s();
        let left = self.most_s.map_or(0.0, |most_s| (most_s / planned_s - 1.0).min(MOST_CYCLE_LIMIT));
        let cycle_limit = self.settings.cycle_limit.max(left);
        self.run_with(part, Settings { cycle_limit, ..self.settings })
    }

    /// The same with this limit of the increase of the cycle time by the correction.
    pub fn run_within(&mut self, part: Part, cycle_limit: f64) -> Result<Trial> {
        self.run_with(part, Settings { cycle_limit, ..self.settings })
    }

    fn with_factors(&self, part: Part) -> Result<Part> {
        let factors = self.factors(part.toolpath.moves.len());
        if part.feed_factors == factors { Ok(part) } else { part.with_feeds(factors) }
    }

    fn run_with(&mut self, part: Part, settings: Settings) -> Result<Trial> {
        let trial = Trial::of(self.with_factors(part)?, self.model, &settings, self.progress)?;
        let errors = self.errors_mm(&trial)?;
        for (group, error) in self.groups.iter_mut().zip(&errors) {
            group.note(*error);
        }
        self.visits.push(Visit {
            factors: self.groups.iter().map(|group| group.factor).collect(),
            settings,
            cycle_s: trial.cycle_s(),
            errors_mm: errors,
            max_mm: trial.max_mm(),
            rms_mm: trial.outcome.after.tip.rms_mm,
        });
        Ok(trial)
    }

    /// Runs the program once more as in a visit, unless that is the last one.
    pub fn run_as(&mut self, trial: Trial, visit: &Visit) -> Result<Trial> {
        if self.visits.last().is_some_and(|last| last.factors == visit.factors && last.settings == visit.settings) {
            return Ok(trial);
        }
        self.set_factors(&visit.factors);
        self.run_with(trial.into_part()?, visit.settings)
    }

    fn set_factors(&mut self, factors: &[f64]) {
        for (group, factor) in self.groups.iter_mut().zip(factors) {
            group.factor = *factor;
        }
    }

    /// Limits of the correction's increase of the cycle time for settings that state none: the usual one, and larger ones. A program whose corners need
    /// time gains more from these than from lower feeds: an engraving on `random:60607` has 26.6 µm MAX within 1 %, and 20.7 within 5.
    pub fn cycle_limits(&self) -> Vec<f64> {
        let own = self.asked.cycle_limit;
        let is_usual = own == Settings::default().cycle_limit;
        std::iter::once(own).chain(WIDER_LIMITS.into_iter().filter(|_| is_usual)).collect()
    }

    /// Prefers short cycles where no trial keeps the tolerance.
    pub fn prefer_short(&mut self) {
        self.price_of_time = HIGH_PRICE_OF_TIME;
    }

    /// Settings of the last trial.
    pub fn last_settings(&self) -> Settings {
        self.visits.last().map_or(self.settings, |visit| visit.settings)
    }

    /// Takes this limit for all further trials.
    pub fn limit(&mut self, cycle_limit: f64) {
        self.settings.cycle_limit = cycle_limit;
    }

    /// Sets the factors of all groups to their bounds, and runs the program with them.
    pub fn run_at_bounds(&mut self, trial: Trial) -> Result<Trial> {
        let mut bounds = self.groups.clone();
        bounds.iter_mut().for_each(|group| group.set(group.highest));
        let factors: Vec<f64> = bounds.iter().map(|group| group.factor).collect();
        if self.groups.iter().map(|group| group.factor).eq(factors.iter().copied()) {
            return Ok(trial);
        }
        self.set_factors(&factors);
        self.run(trial.into_part()?)
    }

    /// Looks for the shortest cycle within `tolerance_mm` in up to `rounds` trials in which factors rise and fall, and as many in which they
    /// only fall. Returns the trial of the shortest cycle that keeps the tolerance, else the last one.
    pub fn settle(&mut self, mut trial: Trial, tolerance_mm: f64, rounds: usize) -> Result<Trial> {
        self.groups.iter_mut().for_each(Group::restart);
        let mut best: Option<Visit> = None;
        for round in 0..2 * rounds {
            if self.groups.iter().all(|group| group.holds(tolerance_mm))
                && let Some(visit) = self.visits.last()
                && best.as_ref().is_none_or(|best| visit.cycle_s < best.cycle_s)
            {
                best = Some(visit.clone());
            }
            let may_raise = round < rounds;
            if !may_raise && best.is_some() {
                break;
            }
            let changed = self.groups.iter_mut().fold(false, |any, group| group.step(tolerance_mm, may_raise) | any);
            if !changed {
                break;
            }
            trial = self.run(trial.into_part()?)?;
        }
        match best {
            Some(best) => self.run_as(trial, &best),
            None => Ok(trial),
        }
    }

    /// Settles for `count` tolerances in turn, from `most_mm` down to `least_mm`, which is not above it.
    pub fn sweep(&mut self, mut trial: Trial, (most_mm, least_mm): (f64, f64), count: usize, rounds: usize) -> Result<Trial> {
        for number in 1..=count {
            let tolerance_mm = most_mm * (least_mm / most_mm).powf(number as f64 / count as f64);
            trial = self.settle(trial, tolerance_mm, rounds)?;
            // A lower tolerance takes longer still.
            if self.most_s.is_some_and(|most_s| trial.cycle_s() > most_s) {
                break;
            }
        }
        Ok(trial)
    }

    /// The trial of the least MAX whose cycle takes at most `most_s`, and of the least RMS where several are as good in MAX.
    pub fn best_within(&self, most_s: f64) -> Option<&Visit> {
        best_within(&self.visits, most_s)
    }

    /// Of the trials whose cycle takes at most `most_s` and whose MAX is not above that at the programmed feeds, the one whose groups exceed the tolerance
    /// least, where time has its price: what takes as long again as the first one has to take this share off the excess.
    pub fn least_excess(&self, tolerance_mm: f64, most_s: f64) -> Option<&Visit> {
        let first = self.visits.first()?;
        let excess = |visit: &Visit| visit.errors_mm.iter().map(|error| (error - tolerance_mm).max(0.0)).sum::<f64>();
        let own = excess(first).max(f64::MIN_POSITIVE);
        let cost = |visit: &Visit| excess(visit) / own + self.price_of_time * (visit.cycle_s / first.cycle_s - 1.0);
        let allowed = |visit: &&Visit| visit.cycle_s <= most_s && visit.max_mm <= first.max_mm;
        self.visits.iter().filter(allowed).min_by(|a, b| cost(a).total_cmp(&cost(b)))
    }

    /// The trial of the shortest cycle.
    pub fn shortest(&self) -> Option<&Visit> {
        self.visits.iter().min_by(|a, b| a.cycle_s.total_cmp(&b.cycle_s))
    }

    /// The least MAX of the trials whose cycle takes at most `most_s`, mm.
    pub fn least_max_mm(&self, most_s: f64) -> Option<f64> {
        least_max_mm(&self.visits, most_s)
    }

    /// Factors of all moves of a program.
    fn factors(&self, moves: usize) -> Vec<f64> {
        let mut factors = vec![1.0; moves];
        for group in &self.groups {
            factors[group.moves.clone()].fill(group.factor);
        }
        factors
    }

    /// Largest predicted error of every group, mm, with what lies within [`REACH_S`] of its moves. A group above its programmed feed that is
    /// faster than the training data of the model has no forecast: its error counts as infinite.
    fn errors_mm(&self, trial: &Trial) -> Result<Vec<f64>> {
        let part = trial.part()?;
        let mut group_of = vec![None; part.toolpath.moves.len()];
        for (number, group) in self.groups.iter().enumerate() {
            group_of[group.moves.clone()].fill(Some(number));
        }
        let reach = (REACH_S / part.settings.period_s).round() as usize;
        let at = |sample: usize| part.move_at(sample).and_then(|index| group_of[index]);
        let mut worst = vec![0.0_f64; self.groups.len()];
        for (k, error) in trial.errors_mm.iter().enumerate() {
            for number in [k.saturating_sub(reach), k, k + reach].into_iter().filter_map(at) {
                worst[number] = worst[number].max(*error);
            }
        }
        for (k, _) in trial.too_fast(&self.ranges).iter().enumerate().filter(|(_, fast)| **fast) {
            if let Some(number) = at(k).filter(|number| self.groups[*number].factor > 1.0) {
                worst[number] = f64::INFINITY;
            }
        }
        Ok(worst)
    }
}

/// Ratio to the least MAX up to which it counts as the same: that of a move beside a rapid hardly depends on feeds.
const SAME_MAX: f64 = 1.02;

fn least_max_mm(visits: &[Visit], most_s: f64) -> Option<f64> {
    visits.iter().filter(|visit| visit.cycle_s <= most_s).map(|visit| visit.max_mm).reduce(f64::min)
}

fn best_within(visits: &[Visit], most_s: f64) -> Option<&Visit> {
    let most_mm = SAME_MAX * least_max_mm(visits, most_s)?;
    let as_good = visits.iter().filter(|visit| visit.cycle_s <= most_s && visit.max_mm <= most_mm);
    as_good.min_by(|a, b| a.rms_mm.total_cmp(&b.rms_mm).then(a.cycle_s.total_cmp(&b.cycle_s)))
}

/// Planned duration of every move, s.
fn durations_s(part: &Part) -> Vec<f64> {
    let mut durations_s = vec![0.0; part.toolpath.moves.len()];
    for index in (0..part.plan.samples.len()).filter_map(|k| part.move_at(k)) {
        durations_s[index] += part.settings.period_s;
    }
    durations_s
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_trials_with_the_same_max_the_least_rms_is_the_best() {
        let visit = |cycle_s: f64, max_mm: f64, rms_mm: f64| Visit {
            factors: Vec::new(),
            settings: Settings::default(),
            cycle_s,
            errors_mm: Vec::new(),
            max_mm,
            rms_mm,
        };
        let visits = [visit(33.0, 42.7, 1.67), visit(34.0, 42.0, 2.88), visit(30.0, 50.0, 1.0), visit(40.0, 20.0, 0.5)];
        assert_eq!(best_within(&visits, 35.0).map(|best| best.rms_mm), Some(1.67));
        assert_eq!(best_within(&visits, 50.0).map(|best| best.rms_mm), Some(0.5));
        assert!(best_within(&visits, 1.0).is_none());
    }
}
