//! An adjustment of feeds, from its first trial to its result.

use models::Bundle;

use super::adjusted::{Adjusted, Bounds, above, changed_moves, chip_loads, unlimited_s};
use super::limits::FeedLimits;
use super::search::Search;
use super::trial::{Trial, errors_mm};
use crate::error::Result;
use crate::model_based_ilc::{Settings, model_based_ilc};
use crate::part::Part;
use crate::progress::Progress;

/// Trials of a search within a tolerance in which factors rise and fall.
pub(super) const ROUNDS: usize = 8;
/// Relative increase of the cycle time that the program may have once it is learned as was asked.
const SAME_CYCLE: f64 = 2e-3;

/// A search, and what it begins from.
pub(super) struct Adjustment<'a> {
    pub search: Search<'a>,
    model: &'a Bundle,
    progress: Progress<'a>,
    /// Planned duration at the programmed feeds, s.
    pub programmed_s: f64,
    /// Largest predicted error there, compensated, mm.
    max_mm: f64,
    /// Planned duration at the limits of the machine alone, s.
    machine_s: f64,
    bounds: Option<Bounds>,
}

impl<'a> Adjustment<'a> {
    /// Begins with a trial at the programmed feeds.
    pub fn begin(
        part: Part,
        model: &'a Bundle,
        settings: &Settings,
        limits: &FeedLimits,
        progress: Progress<'a>,
    ) -> Result<(Self, Trial)> {
        let programmed_s = part.plan.desired.trajectory().duration_s();
        let allowed: Vec<bool> = (0..part.toolpath.moves.len()).map(|index| limits.allows(&part, index)).collect();
        let (part, machine_s) = unlimited_s(part, |index| allowed[index])?;
        let (search, trial) = Search::begin(part, model, settings, limits, progress)?;
        let max_mm = trial.max_mm();
        Ok((Self { search, model, progress, programmed_s, max_mm, machine_s, bounds: None }, trial))
    }

    /// A trial at the highest feeds allowed.
    pub fn at_bounds(&mut self, trial: Trial) -> Result<Trial> {
        let at_bounds = self.search.run_at_bounds(trial)?;
        self.bounds = Some(Bounds { allowed_s: at_bounds.planned_s(), machine_s: self.machine_s });
        Ok(at_bounds)
    }

    /// The result: the last trial, learned as was asked where that neither exceeds the tolerance nor takes longer.
    pub fn finish(self, trial: Trial, tolerance_mm: f64) -> Result<Adjusted> {
        let (asked, last) = (self.search.asked, self.search.last_settings());
        let (cycle_s, max_mm) = (trial.cycle_s(), trial.max_mm());
        let Trial { input, mut outcome, errors_mm: mut errors } = trial;
        if asked.written.is_some() && last != asked {
            let settings = Settings { cycle_limit: last.cycle_limit, unavoidable_apart: last.unavoidable_apart, ..asked };
            let whole = model_based_ilc(&input, self.model, &settings, self.progress)?;
            let of_whole = errors_mm(&input, &whole)?;
            let is_short = whole.cycle_s.is_some_and(|(_, after_s)| after_s <= cycle_s * (1.0 + SAME_CYCLE));
            if is_short && of_whole.iter().all(|error| *error <= tolerance_mm.min(max_mm)) {
                (outcome, errors) = (whole, of_whole);
            }
        }
        let trial = Trial { input, outcome, errors_mm: errors };
        let (cycle_s, max_mm, worst_mm) = (trial.cycle_s(), trial.max_mm(), trial.worst_mm()?);
        let part = trial.part()?;
        Ok(Adjusted {
            cycle_s: (self.programmed_s, cycle_s),
            bounds: self.bounds,
            moves: changed_moves(part),
            max_mm: (self.max_mm, max_mm),
            above: above(part, &worst_mm, tolerance_mm),
            chip_loads: chip_loads(part),
            input: trial.input,
            outcome: trial.outcome,
        })
    }
}

/// Trials at the programmed feeds with larger limits of the correction's increase of the cycle time, until one keeps the tolerance. Takes the limit of
/// the least excess for what follows.
pub(super) fn wider(search: &mut Search<'_>, mut trial: Trial, tolerance_mm: f64) -> Result<Trial> {
    for cycle_limit in search.cycle_limits().into_iter().skip(1) {
        if trial.max_mm() <= tolerance_mm {
            break;
        }
        trial = search.run_within(trial.into_part()?, cycle_limit)?;
    }
    if trial.max_mm() > tolerance_mm
        && let Some(best) = search.least_excess(tolerance_mm, f64::INFINITY).cloned()
    {
        trial = search.run_as(trial, &best)?;
    }
    search.limit(search.last_settings().cycle_limit);
    Ok(trial)
}
