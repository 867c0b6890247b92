//! Iteration on the replanned program: the smoothness of the correction, and the choice of the points.

mod candidate;
mod opening;
mod search;

use compensation::Iteration;
use machine::Machine;
use motion::Trajectory;

use super::settings::{CYCLE_LIMIT, LawName, Settings};
use super::task::Task;
use crate::control::ControlledMachine;
use crate::error::Result;
use crate::input::Input;
use crate::refit::RefitSettings;
use crate::statistics::Figures;

use candidate::Tried;
use opening::Opening;
use search::{CUT_OFFS_HZ, REPLANNED_UPDATES, Search};

/// Cost on the replanned program, as a multiple of that on the reference or of the forecast's floor, up to which no other cut-off is tried; and
/// the same for the errors expected on the machine.
const AS_GOOD: f64 = 1.5;
const NEAR: f64 = 1.2;
/// Larger limit of the cycle time, as a multiple of the own one. Of seven programs on `random:60607` and `random:545547` an engraving comes to 3.9 instead of
/// 5.2 µm RMS that way and the others to the same within 0.3 %, in twice the computing time; with 5 % instead of 1 a pocket came to 1.62 instead of 0.83 µm.
const BEYOND: f64 = 3.0;
/// Cost of an opening, as a multiple of the best cost so far, from which on it is not learned with.
const LEARNABLE: f64 = 1.5;

/// Candidate for the result, on the feed profile that the control uses.
#[derive(Default)]
pub(super) struct OnProgram {
    pub(super) run: Option<(Iteration, Figures)>,
    /// Updates so far, on the reference and on the replanned program.
    pub(super) updates: usize,
    /// Cycle time before and after, s, where the control replans the program.
    pub(super) cycle_s: Option<(f64, f64)>,
    /// Relative increase of the cycle time by timed points, where it is too large and the program therefore keeps its feeds.
    pub(super) kept_feeds: Option<f64>,
    /// Least relative increase of the cycle time that was found, where it is beyond its limit whatever the points.
    pub(super) too_slow: Option<f64>,
    /// Settings of the points, where the control replans the program.
    pub(super) written: Option<RefitSettings>,
}

/// Continues the iteration from the best of `ideals`, runs on the reference within the limits of the axes and without them, on the replanned
/// program. The points are as few as the forecast
/// allows; the cycle stays within its limit. With the command of an earlier run, `resumed`, the iteration also continues from there, and the
/// better result is taken.
pub(super) fn relearn_on_program<M: Machine + ?Sized>(
    task: &Task<'_>,
    control: &mut ControlledMachine<'_, M>,
    input: &Input,
    settings: &Settings,
    written: RefitSettings,
    ideals: &[&Iteration],
    resumed: Option<&Trajectory>,
) -> Result<OnProgram> {
    let mut search = Search {
        task,
        control,
        path: input.trajectory(),
        settings,
        ideals,
        low_pass_hz: CUT_OFFS_HZ[0],
        cycle_limit: settings.cycle_limit,
        updates: 0,
    };
    let (found, kept_feeds) = search.cut_offs(written)?;
    let found = search.stepped(found)?;
    let (mut found, kept_feeds) = search.with_other_limits(found, kept_feeds, written)?;
    if let Some(command) = resumed {
        found = search.resume(found, command)?;
    }
    let updates = search.updates;
    Ok(match found {
        Tried::Short(found) => OnProgram {
            run: Some(found.run),
            updates,
            cycle_s: Some((input.trajectory().duration_s(), found.cycle_s)),
            kept_feeds,
            written: Some(found.written),
            ..OnProgram::default()
        },
        Tried::Long(shortest) => OnProgram { updates, too_slow: Some(search.slowdown(shortest.cycle_s)), ..OnProgram::default() },
    })
}

impl<M: Machine + ?Sized> Search<'_, '_, '_, M> {
    /// The best of the cut-offs; with the increase of the cycle time by times of the points' own, where it is too large.
    ///
    /// The highest alone where it is near the best reference; otherwise learning goes on with the one whose opening is best.
    fn cut_offs(&mut self, written: RefitSettings) -> Result<(Tried, Option<f64>)> {
        let [first, ..] = CUT_OFFS_HZ;
        let mut opening = self.opening(first, written)?;
        let learns = self.settings.law == LawName::ModelBased;
        let is_first_near = self.is_near(&opening.tried);
        let mut others = if learns && !is_first_near { self.lower(written)? } else { Vec::new() };
        for other in &mut others {
            if !opening.tried.is_better(&other.tried) {
                std::mem::swap(&mut opening, other);
            }
        }
        let mut best = self.learned(opening, written, f64::INFINITY)?;
        if learns && is_first_near && !self.is_near(&best.tried) {
            others = self.lower(written)?;
        }
        others.sort_by(|a, b| a.tried.cost_mm().total_cmp(&b.tried.cost_mm()));
        for other in others {
            let least_mm = best.tried.cost_mm();
            if self.is_near(&best.tried) || least_mm.is_finite() && other.tried.cost_mm() > LEARNABLE * least_mm {
                break;
            }
            let next = self.learned(other, written, least_mm)?;
            if !best.tried.is_better(&next.tried) {
                best = next;
            }
        }
        self.low_pass_hz = best.low_pass_hz;
        Ok((best.tried, best.kept_feeds))
    }

    /// The better one of `found` and what searches with other limits of the cycle time come to, where they keep the own one all the same: a larger limit, since
    /// the points at which a search begins may be too many for the limit and those at which it ends not; and the usual one, where the limit is larger, since
    /// other points then lead to another program.
    fn with_other_limits(
        &mut self,
        mut found: Tried,
        mut kept_feeds: Option<f64>,
        written: RefitSettings,
    ) -> Result<(Tried, Option<f64>)> {
        let limit = self.cycle_limit;
        if self.settings.law != LawName::ModelBased || !(limit > 0.0 && limit < f64::INFINITY) {
            return Ok((found, kept_feeds));
        }
        let usual = Some(CYCLE_LIMIT).filter(|usual| *usual < limit && self.settings.tries_usual_limit);
        let larger = self.settings.tries_larger_limit.then_some(BEYOND * limit);
        for other in usual.into_iter().chain(larger) {
            if self.is_near(&found) {
                break;
            }
            let low_pass_hz = self.low_pass_hz;
            self.cycle_limit = other;
            let (other, other_kept_feeds) = self.cut_offs(written)?;
            let (Tried::Short(candidate) | Tried::Long(candidate)) = self.stepped(other)?;
            self.cycle_limit = limit;
            match self.judged(candidate) {
                other @ Tried::Short(_) if !found.is_better(&other) => (found, kept_feeds) = (other, other_kept_feeds),
                _ => self.low_pass_hz = low_pass_hz,
            }
        }
        Ok((found, kept_feeds))
    }

    /// Openings with the lower cut-offs.
    fn lower(&mut self, written: RefitSettings) -> Result<Vec<Opening>> {
        CUT_OFFS_HZ[1..].iter().map(|low_pass_hz| self.opening(*low_pass_hz, written)).collect()
    }

    /// The result of learning with the cut-off of an opening.
    fn learned(&mut self, opening: Opening, written: RefitSettings, to_beat_mm: f64) -> Result<Opening> {
        self.low_pass_hz = opening.low_pass_hz;
        let found = self.points(opening.tried, written, to_beat_mm)?;
        Ok(Opening { tried: self.reduced(found)?, ..opening })
    }

    /// Whether no other cut-off can save much.
    fn is_near(&self, tried: &Tried) -> bool {
        let expected = |cost_mm: f64| self.task.worth(0.0).expected(cost_mm);
        let (cost_mm, ideal_mm) = (tried.cost_mm(), self.ideal_mm().max(self.task.floor_mm()));
        cost_mm <= AS_GOOD * ideal_mm || expected(cost_mm) <= NEAR * expected(ideal_mm)
    }

    /// The better one of `found` and what is learned with the same points from the command of an earlier run.
    fn resume(&mut self, found: Tried, command: &Trajectory) -> Result<Tried> {
        let Tried::Short(candidate) = &found else { return Ok(found) };
        let known = self.run(command.clone(), candidate.written)?;
        let resumed = self.learn(known, f64::INFINITY, REPLANNED_UPDATES * self.settings.iterations)?;
        Ok(if resumed.cost_mm() < found.cost_mm() { resumed } else { found })
    }
}
