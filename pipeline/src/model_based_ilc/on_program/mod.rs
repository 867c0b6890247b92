//! Iteration on the replanned program: the smoothness of the correction, and the choice of the points.

mod candidate;
mod search;

use compensation::Iteration;
use models::LearnedMachine;
use motion::Trajectory;

use super::settings::{LawName, Settings};
use super::task::Task;
use crate::control::ControlledMachine;
use crate::error::Result;
use crate::input::Input;
use crate::refit::{RefitSettings, TimeEncoding};
use crate::statistics::Figures;

use candidate::Tried;
use search::{CUT_OFFS_HZ, Search};

/// Cost on the replanned program, as a multiple of that on the reference or of the forecast's floor, up to which no lower cut-off is tried.
const AS_GOOD: f64 = 1.5;
/// Cost of a cut-off, as a multiple of the least one, from which on no lower cut-off is tried.
const WORSE: f64 = 1.1;

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

/// Continues the iteration from `ideal`, the best run on the reference, on the replanned program. The points are as few as the forecast
/// allows; the cycle stays within its limit. With the command of an earlier run, `resumed`, the iteration also continues from there, and the
/// better result is taken.
pub(super) fn relearn_on_program(
    task: &Task<'_>,
    control: &mut ControlledMachine<'_, LearnedMachine>,
    input: &Input,
    settings: &Settings,
    written: RefitSettings,
    ideal: &Iteration,
    resumed: Option<&Trajectory>,
) -> Result<OnProgram> {
    let mut search = Search { task, control, path: input.trajectory(), settings, ideal, low_pass_hz: CUT_OFFS_HZ[0], updates: 0 };
    let (found, kept_feeds) = search.cut_offs(written)?;
    let mut found = search.stepped(found)?;
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

impl Search<'_, '_, '_> {
    /// The best of the cut-offs; with the increase of the cycle time by times of the points' own, where it is too large.
    fn cut_offs(&mut self, written: RefitSettings) -> Result<(Tried, Option<f64>)> {
        let good_mm = AS_GOOD * self.ideal.measure.max(self.task.floor_mm());
        let (mut best, mut kept_feeds) = self.encodings(written)?;
        if self.settings.law != LawName::ModelBased {
            return Ok((best, kept_feeds));
        }
        let mut serves = best.cost_mm() <= good_mm;
        best = self.reduced(best)?;
        let mut best_hz = self.low_pass_hz;
        for low_pass_hz in CUT_OFFS_HZ.into_iter().skip(1) {
            if serves {
                break;
            }
            self.low_pass_hz = low_pass_hz;
            let (found, keeps) = self.encodings(written)?;
            let cost_mm = found.cost_mm();
            serves = cost_mm <= good_mm || cost_mm.is_finite() && cost_mm > WORSE * best.cost_mm();
            let found = self.reduced(found)?;
            if !best.is_better(&found) {
                (best, kept_feeds, best_hz) = (found, keeps, low_pass_hz);
            }
        }
        self.low_pass_hz = best_hz;
        Ok((best, kept_feeds))
    }

    /// The fewest points with times of their own, or without where their cycle is too long; then also its relative increase.
    fn encodings(&mut self, written: RefitSettings) -> Result<(Tried, Option<f64>)> {
        let found = self.points(written)?;
        let kept = RefitSettings { encoding: TimeEncoding::Keep, ..written };
        match found {
            Tried::Long(shortest) if written.encoding != TimeEncoding::Keep && self.control.replans(kept) => {
                Ok((self.points(kept)?, Some(self.slowdown(shortest.cycle_s))))
            }
            found => Ok((found, None)),
        }
    }

    /// The better one of `found` and what is learned with the same points from the command of an earlier run.
    fn resume(&mut self, found: Tried, command: &Trajectory) -> Result<Tried> {
        let Tried::Short(candidate) = &found else { return Ok(found) };
        let resumed = self.learn(candidate.written, Some(command.clone()), f64::INFINITY)?;
        Ok(if resumed.cost_mm() < found.cost_mm() { resumed } else { found })
    }
}
