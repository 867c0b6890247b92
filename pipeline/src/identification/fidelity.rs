//! Agreement of a planned command with a recorded one.

use machine::MachineSpec;

use super::observed::{Difference, Observed};

/// Agreement of plans with recorded commands.
#[derive(Debug, Clone, PartialEq)]
pub struct Fidelity {
    /// Distance between the planned and the recorded command at the same place of the path, RMS and MAX, mm.
    pub path_rms_mm: f64,
    /// Its largest value, mm.
    pub path_max_mm: f64,
    /// Sum of the differences of time over parts of the path of some 10 ms, as a share of the time.
    pub time_share: f64,
    /// Mean over the programs of the difference of their time in motion, as a share of it, without sign.
    pub cycle_share: f64,
}

/// The differences that count as much as one another: those that a forecast stands without harm.
pub(super) const TIME_SHARE: f64 = 0.01;
pub(super) const PATH_MM: f64 = 2e-3;
/// Distance beyond which a sample counts no more, mm: one misread corner must not decide.
const FAR_MM: f64 = 0.2;
/// Score of a plan that cannot be made.
const IMPOSSIBLE: f64 = 1e9;

impl Fidelity {
    /// Agreement of the plans of `machine` with `runs`.
    pub(super) fn of(machine: &MachineSpec, runs: &[&Observed]) -> Self {
        let found: Option<Vec<Difference>> = runs.iter().map(|run| run.difference(machine)).collect();
        let Some(found) = found.filter(|found| !found.is_empty()) else {
            return Self {
                path_rms_mm: f64::INFINITY,
                path_max_mm: f64::INFINITY,
                time_share: f64::INFINITY,
                cycle_share: f64::INFINITY,
            };
        };
        let sum = |of: &dyn Fn(&Difference) -> f64| found.iter().map(of).sum::<f64>();
        let count = sum(&|run| run.distances_mm().count() as f64).max(1.0);
        let squares = sum(&|run| run.distances_mm().map(|off| off.min(FAR_MM).powi(2)).sum());
        Self {
            path_rms_mm: (squares / count).sqrt(),
            path_max_mm: found.iter().flat_map(Difference::distances_mm).fold(0.0, f64::max),
            time_share: sum(&|run| run.late_s.iter().map(|late| late.abs()).sum()) / sum(&|run| run.recorded_s).max(1e-9),
            cycle_share: sum(&|run| (run.planned_s / run.recorded_s.max(1e-9) - 1.0).abs()) / found.len() as f64,
        }
    }

    /// One number for both: less is better.
    pub(super) fn score(&self) -> f64 {
        let score = self.time_share / TIME_SHARE + self.path_rms_mm / PATH_MM + self.cycle_share / TIME_SHARE;
        if score.is_finite() { score } else { IMPOSSIBLE }
    }
}
