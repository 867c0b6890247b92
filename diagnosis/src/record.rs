//! The runs of one axis, as the analyses take them.

use datasets::Log;
use motion::{Axis, AxisKind};
use servo::{MOVING_MM_S, Record};

use crate::error::DiagnosisError;

/// Time at the start of a run that is not scored: the command before it is not known, s.
pub const UNSCORED_S: f64 = 0.3;
/// Lever arm at which a rotary axis is treated as a linear one, mm.
const LEVER_MM: f64 = 100.0;
/// Shortest motion of an axis that can be diagnosed, s.
const SHORTEST_S: f64 = 2.0;

/// Runs of one axis. Positions of a rotary axis are those of a lever arm of 100 mm, so that all thresholds are lengths.
#[derive(Debug, Clone)]
pub struct AxisRecord {
    /// Name of the axis.
    pub name: String,
    /// Whether it is rotary.
    pub rotary: bool,
    /// Sampling period, s.
    pub period_s: f64,
    /// The runs.
    pub runs: Vec<Run>,
}

/// One run of one axis, mm.
#[derive(Debug, Clone)]
pub struct Run {
    /// Name of its log.
    pub name: String,
    /// Commanded positions.
    pub reference: Vec<f64>,
    /// Actual positions.
    pub actual: Vec<f64>,
}

impl Run {
    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.reference.len().min(self.actual.len())
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Position and velocity at its start, mm and mm/s.
    #[must_use]
    pub fn start(&self, period_s: f64) -> (f64, f64) {
        let position = self.actual.first().copied().unwrap_or(0.0);
        // A command at rest means an axis at rest; encoder counts must not become a speed.
        let over = 5.min(self.len().saturating_sub(1));
        let moves = over > 0 && servo::speed_at_start(&self.reference, period_s) != 0.0;
        let velocity = if moves { (self.actual[over] - position) / (over as f64 * period_s) } else { 0.0 };
        (position, velocity)
    }

    /// Velocity of the command at sample `k`, mm/s: central difference.
    #[must_use]
    pub fn velocity(&self, k: usize, period_s: f64) -> f64 {
        let (before, after) = (k.saturating_sub(1), (k + 1).min(self.len().saturating_sub(1)));
        if after == before {
            0.0
        } else {
            (self.reference[after] - self.reference[before]) / ((after - before) as f64 * period_s)
        }
    }
}

impl AxisRecord {
    /// The records of the axes of `logs` that move; every log has to have the same axes and period.
    ///
    /// # Errors
    /// When there is no log, logs do not match, or no axis moves long enough.
    pub fn of(logs: &[Log]) -> Result<Vec<Self>, DiagnosisError> {
        let first = logs.first().ok_or(DiagnosisError::NoLog)?;
        for log in logs {
            log.reference
                .check_axes(first.axes())
                .map_err(|source| DiagnosisError::Mismatch { name: log.name.clone(), source })?;
            if (log.period_s() / first.period_s() - 1.0).abs() > 1e-6 {
                return Err(DiagnosisError::Periods { name: log.name.clone(), own_s: log.period_s(), first_s: first.period_s() });
            }
        }
        let records: Vec<Self> = (0..first.axes().len()).map(|index| Self::axis(logs, index, &first.axes()[index])).collect();
        let moving: Vec<Self> = records.into_iter().filter(|record| record.moving_s() >= SHORTEST_S).collect();
        if moving.is_empty() { Err(DiagnosisError::NoMotion { shortest_s: SHORTEST_S }) } else { Ok(moving) }
    }

    fn axis(logs: &[Log], index: usize, axis: &Axis) -> Self {
        let rotary = axis.kind == AxisKind::Rotary;
        let scale = if rotary { LEVER_MM } else { 1.0 };
        let scaled = |column: &[f64]| column.iter().map(|position| scale * position).collect();
        let run = |log: &Log| Run {
            name: log.name.clone(),
            reference: scaled(&log.reference.columns()[index]),
            actual: scaled(&log.actual.columns()[index]),
        };
        Self {
            name: axis.name.clone(),
            rotary,
            period_s: logs.first().map_or(1.0, Log::period_s),
            runs: logs.iter().map(run).collect(),
        }
    }

    /// Time during which the command moves, s.
    fn moving_s(&self) -> f64 {
        let moving =
            |run: &Run| run.reference.windows(2).filter(|pair| (pair[1] - pair[0]).abs() > MOVING_MM_S * self.period_s).count();
        self.runs.iter().map(moving).sum::<usize>() as f64 * self.period_s
    }

    /// What a servo model is fitted to.
    #[must_use]
    pub fn for_fit(&self) -> Record {
        let first = self.first_scored();
        let run = |run: &Run| servo::Run {
            reference: run.reference.clone(),
            actual: run.actual.clone(),
            start: Some(run.start(self.period_s).into()),
            rows: std::iter::once(first.min(run.len())..run.len()).collect(),
        };
        Record { period_s: self.period_s, runs: self.runs.iter().map(run).collect() }
    }

    /// First sample of a run that is scored.
    #[must_use]
    pub fn first_scored(&self) -> usize {
        (UNSCORED_S / self.period_s).ceil() as usize
    }

    /// Largest commanded speed, mm/s.
    #[must_use]
    pub fn top_speed_mm_s(&self) -> f64 {
        let fastest = |run: &Run| run.reference.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
        self.runs.iter().map(fastest).fold(0.0, f64::max) / self.period_s
    }

    /// Acceleration of the command that one sample in twenty exceeds while it moves, mm/s².
    #[must_use]
    pub fn usual_top_acceleration_mm_s2(&self) -> f64 {
        let per_second = self.period_s.powi(2).recip();
        let second = |triple: &[f64]| (triple[2] - 2.0 * triple[1] + triple[0]).abs() * per_second;
        let mut all: Vec<f64> = self
            .runs
            .iter()
            .flat_map(|run| run.reference.windows(3))
            .filter(|triple| (triple[2] - triple[0]).abs() > 2.0 * MOVING_MM_S * self.period_s)
            .map(second)
            .collect();
        if all.is_empty() {
            return 0.0;
        }
        let place = all.len() - 1 - all.len() / 20;
        *all.select_nth_unstable_by(place, f64::total_cmp).1
    }
}
