//! Search of the fewest points of a program at one cut-off.

use compensation::{Iteration, LowPass, StopRule, Worth};
use machine::Machine;
use motion::Trajectory;

use super::candidate::{Candidate, Tried};
use crate::control::ControlledMachine;
use crate::error::Result;
use crate::model_based_ilc::acceptance::{SAME_FORECAST, cost};
use crate::model_based_ilc::laws::spatial;
use crate::model_based_ilc::settings::{FewerPoints, LawName, Settings};
use crate::model_based_ilc::task::{Runs, Task};
use crate::refit::RefitSettings;
use crate::statistics::Figures;

/// Updates on the replanned program for each update on the reference, and largest number of consecutive updates that do not count.
pub(super) const REPLANNED_UPDATES: usize = 3;
const REPLANNED_PATIENCE: usize = 4;
/// The same after the first choice of points: the start is nearly learned.
const COARSER_UPDATES: usize = 5;
const COARSER_PATIENCE: usize = 2;
/// Largest number of replanned samples over all updates, and least number of updates for a program of hours: replanning takes most of the
/// time.
const REPLANNED_SAMPLES: usize = 12_000_000;
const LEAST_REPLANNED: usize = 2;
/// Gain of updates on the replanned program.
const REPLANNED_GAIN: f64 = 0.7;
/// Cut-offs of the start and of the updates, Hz, tried in this order. Corrections above the cut-off become kinks, at which a control slows
/// down. Six octaves from 40 to 1.25 Hz gave at most 11 % less on the pocket and two programs of short lines on `random:2`, `3`, `9`, `131`
/// and `ballscrew`, in twice the time.
pub(super) const CUT_OFFS_HZ: [f64; 3] = [40.0, 10.0, 2.5];
/// Largest number of Gauss–Newton steps from the best run, and share of its cost that they have to save. Spatial learning shifts points by errors alone, steps
/// also by the answer that the model expects: on LinuxCNC steps that saved 3 % of the forecast cost a half more in the measured run of a flower of short lines.
const MOST_STEPS: usize = 8;
const WORTH_A_STEP: f64 = 0.1;
/// Increase of the cost for which fewer points are taken: a share, and mm.
const COST_OF_FEWER: (f64, f64) = (0.02, 2e-5);
/// Cost of a cut-off, as a multiple of that of another one, from which on no fewer points are sought.
const WORSE: f64 = 1.1;
/// Cost of the first run with fewer points, as a multiple of what is allowed, from which on further updates are not tried.
const HOPELESS: f64 = 2.0;
/// Increase of the cycle time of the first run, as a multiple of its limit, from which on the points are not tried.
const HOPELESS_CYCLE: f64 = 4.0;
/// Largest number of reductions of a correction whose cycle is too long, and the increase of the cycle time they aim at, as a share of its
/// limit.
const REDUCTIONS: usize = 3;
const REDUCED_TO: f64 = 0.9;
/// Least share of a correction that is written.
const LEAST_SHARE: f64 = 0.1;
/// Largest number of doublings of the time between points, and of the chord tolerance.
pub(super) const DOUBLINGS: usize = 4;

/// Search of the fewest points.
pub(super) struct Search<'a, 'b, 'm, M: ?Sized> {
    pub(super) task: &'a Task<'b>,
    pub(super) control: &'a mut ControlledMachine<'m, M>,
    pub(super) path: &'a Trajectory,
    pub(super) settings: &'a Settings,
    /// The best runs on the reference: within the limits of the axes, and without them where that costs less.
    pub(super) ideals: &'a [&'a Iteration],
    /// Cut-off of the start and of the updates, Hz.
    pub(super) low_pass_hz: f64,
    /// Largest relative increase of the cycle time.
    pub(super) cycle_limit: f64,
    /// Updates so far.
    pub(super) updates: usize,
}

impl<M: Machine + ?Sized> Search<'_, '_, '_, M> {
    /// Learns with the points of `opening`. Then doubles the time between points and the chord tolerance, up to [`DOUBLINGS`] times those of
    /// `written`, for as long as the cost stays within [`COST_OF_FEWER`] of the least one; not where that is beyond [`WORSE`] times `to_beat_mm`.
    pub(super) fn points(&mut self, opening: Tried, written: RefitSettings, to_beat_mm: f64) -> Result<Tried> {
        let mut best = self.learn(opening, f64::INFINITY, REPLANNED_UPDATES * self.settings.iterations)?;
        let mut least = best.cost_mm();
        if self.settings.fewer_points != FewerPoints::WhereForecastAllows || least > WORSE * to_beat_mm {
            return Ok(best);
        }
        let most = f64::from(1 << DOUBLINGS);
        for step in [further_in_time as fn(_) -> _, further_from_curve] {
            loop {
                let Tried::Short(candidate) = &best else { return Ok(best) };
                let next = step(candidate.written);
                let is_coarsest =
                    next.spacing_s > most * written.spacing_s || next.chord_tolerance_mm > most * written.chord_tolerance_mm;
                if is_coarsest || !self.may_coarsen(next) {
                    break;
                }
                let known = self.run(candidate.run.0.reference.clone(), next)?;
                let next = self.learn(known, allowed(least), COARSER_UPDATES)?;
                if next.cost_mm() > allowed(least) {
                    break;
                }
                least = least.min(next.cost_mm());
                best = next;
            }
        }
        Ok(best)
    }

    /// Whether there are points that can be further apart.
    pub(super) fn may_coarsen(&self, written: RefitSettings) -> bool {
        written.spacing_s.is_finite() && self.settings.fewer_points != FewerPoints::Never
    }

    /// A run of the program with these points.
    pub(super) fn run(&mut self, reference: Trajectory, written: RefitSettings) -> Result<Tried> {
        self.control.replans(written);
        let actual = self.control.run(&reference)?;
        let cycle_s = self.control.last_s();
        let figures = self.task.figures(&self.task.errors(&actual)?)?;
        let measure = cost(&figures);
        Ok(self.tried((Iteration { reference, actual, measure }, figures), cycle_s, written))
    }

    /// Learns on the program from a run, by up to `updates` further ones. Gives up where a cost of `allowed` mm is out of reach. The papers' laws
    /// are not iterated again; only their forecast is that of the replanned program.
    pub(super) fn learn(&mut self, first: Tried, allowed: f64, updates: usize) -> Result<Tried> {
        let (Tried::Short(known) | Tried::Long(known)) = &first;
        let (start, written) = (&known.run.0, known.written);
        let is_same = (start.measure / self.ideal_mm() - 1.0).abs() <= SAME_FORECAST;
        let is_too_slow = self.slowdown(known.cycle_s) > HOPELESS_CYCLE * self.cycle_limit;
        if self.settings.law != LawName::ModelBased || is_same || is_too_slow || start.measure > HOPELESS * allowed {
            return Ok(first);
        }
        self.control.replans(written);
        let patience = if allowed.is_finite() { COARSER_PATIENCE } else { REPLANNED_PATIENCE };
        let runs = self.iterate(start.clone(), updates, patience, allowed)?;
        let better = |best: Tried, run: Tried| if best.is_better(&run) { best } else { run };
        Ok(self.all_tried(runs, written).into_iter().fold(first, better))
    }

    /// The latest runs as candidates.
    fn all_tried(&self, runs: Runs, written: RefitSettings) -> Vec<Tried> {
        let durations_s = self.control.durations_s();
        let durations_s = &durations_s[durations_s.len() - runs.len()..];
        runs.into_iter().zip(durations_s).map(|(run, cycle_s)| self.tried(run, *cycle_s, written)).collect()
    }

    /// The best of Gauss–Newton steps from `found` with its points, where that is worth it.
    pub(super) fn stepped(&mut self, found: Tried) -> Result<Tried> {
        let Tried::Short(candidate) = &found else { return Ok(found) };
        if !self.task.knows_responses() || self.settings.law != LawName::ModelBased {
            return Ok(found);
        }
        let worth = self.worth();
        if worth.left(found.cost_mm()) < WORTH_A_STEP {
            return Ok(found);
        }
        self.control.replans(candidate.written);
        let runs = self.task.steps(self.control, candidate.run.0.clone(), self.low_pass_hz, MOST_STEPS, worth)?;
        self.updates += runs.len();
        let best = self.all_tried(runs, candidate.written).into_iter().min_by(|a, b| a.cost_mm().total_cmp(&b.cost_mm()));
        Ok(best.filter(|best| best.cost_mm() < (1.0 - WORTH_A_STEP) * found.cost_mm()).unwrap_or(found))
    }

    fn iterate(&mut self, start: Iteration, updates: usize, patience: usize, to_reach: f64) -> Result<Runs> {
        let mut law = spatial(REPLANNED_GAIN, LowPass::new(self.low_pass_hz, self.path.period_s())?)?;
        let affordable = (REPLANNED_SAMPLES / self.path.len().max(1)).max(LEAST_REPLANNED);
        let updates = updates.min(affordable);
        let stop = StopRule { updates, patience, worth: self.worth(), to_reach };
        let runs = self.task.iterate_from(self.control, &mut law, start, stop)?;
        self.updates += runs.len();
        Ok(runs)
    }

    /// What a run has to save to count.
    fn worth(&self) -> Worth {
        self.task.worth(self.settings.worth)
    }

    /// A run as a candidate.
    fn tried(&self, run: (Iteration, Figures), cycle_s: f64, written: RefitSettings) -> Tried {
        self.judged(Box::new(Candidate { run, cycle_s, written }))
    }

    /// A candidate by the limit of the cycle time.
    pub(super) fn judged(&self, candidate: Box<Candidate>) -> Tried {
        if self.is_short(candidate.cycle_s) { Tried::Short(candidate) } else { Tried::Long(candidate) }
    }

    /// Least cost on the reference, mm.
    pub(super) fn ideal_mm(&self) -> f64 {
        self.ideals.iter().map(|ideal| ideal.measure).fold(f64::INFINITY, f64::min)
    }

    /// A reference, its correction smoothed with the cut-off where that is not the highest.
    pub(super) fn start(&self, ideal: &Trajectory) -> Result<Trajectory> {
        let low_pass = LowPass::new(self.low_pass_hz, self.path.period_s())?;
        let Some(low_pass) = low_pass.filter(|_| self.low_pass_hz < CUT_OFFS_HZ[0]) else {
            return Ok(ideal.clone());
        };
        let pairs = self.path.columns().iter().zip(ideal.columns());
        let columns = pairs.map(|(path, ideal)| {
            let correction: Vec<f64> = ideal.iter().zip(path).map(|(ideal, path)| ideal - path).collect();
            path.iter().zip(low_pass.zero_phase(&correction)).map(|(path, correction)| path + correction).collect()
        });
        self.task.limited(&self.path.with_columns(columns.collect())?)
    }

    /// Takes the share of the correction with which the cycle is short enough.
    pub(super) fn reduced(&mut self, found: Tried) -> Result<Tried> {
        let Tried::Long(shortest) = found else { return Ok(found) };
        self.control.replans(shortest.written);
        let mut share = 1.0;
        let mut cycle_s = shortest.cycle_s;
        for _ in 0..REDUCTIONS {
            share *= REDUCED_TO * self.cycle_limit / self.slowdown(cycle_s);
            if share < LEAST_SHARE {
                break;
            }
            let pairs = self.path.columns().iter().zip(shortest.run.0.reference.columns());
            let columns = pairs
                .map(|(path, command)| path.iter().zip(command).map(|(path, command)| path + share * (command - path)).collect());
            let reference = self.path.with_columns(columns.collect())?;
            let actual = self.control.run(&reference)?;
            cycle_s = self.control.last_s();
            if self.is_short(cycle_s) {
                let figures = self.task.figures(&self.task.errors(&actual)?)?;
                let run = (Iteration { reference, actual, measure: cost(&figures) }, figures);
                return Ok(self.tried(run, cycle_s, shortest.written));
            }
        }
        Ok(Tried::Long(shortest))
    }

    fn is_short(&self, cycle_s: f64) -> bool {
        self.slowdown(cycle_s) <= self.cycle_limit
    }

    /// Relative increase of the cycle time.
    pub(super) fn slowdown(&self, cycle_s: f64) -> f64 {
        cycle_s / self.path.duration_s() - 1.0
    }
}

/// Points at twice the time from each other.
pub(super) fn further_in_time(points: RefitSettings) -> RefitSettings {
    RefitSettings { spacing_s: 2.0 * points.spacing_s, ..points }
}

/// Lines at up to twice the distance from the curve.
fn further_from_curve(points: RefitSettings) -> RefitSettings {
    RefitSettings { chord_tolerance_mm: 2.0 * points.chord_tolerance_mm, ..points }
}

/// Largest cost of a program with fewer points, mm, where the least one is `least`.
fn allowed(least: f64) -> f64 {
    let (share, more) = COST_OF_FEWER;
    (least * (1.0 + share)).max(least + more)
}
