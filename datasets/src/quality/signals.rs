//! The signals of one axis for the checks, and their statistics.

use motion::{Axis, AxisKind};

use crate::Log;

/// Commanded and actual position of one axis, with derived signals.
pub(super) struct Signals<'a> {
    pub axis: &'a Axis,
    pub reference: &'a [f64],
    pub actual: &'a [f64],
    /// Reference − actual.
    pub error: Vec<f64>,
    /// Change of the reference from each sample to the next.
    pub reference_steps: Vec<f64>,
    /// Change of the actual position from each sample to the next.
    pub actual_steps: Vec<f64>,
    pub period_s: f64,
    moves: bool,
}

/// Range of a command that does not move, and of one that is no more than corrections, mm and rad: in a compensated run an axis at rest is pushed
/// against what others do to it, and whether it follows by these micrometres says nothing about its columns.
const STILL: (f64, f64) = (1e-3, 1e-5);
const CORRECTIONS: (f64, f64) = (0.1, 2e-3);
/// Ratio of a range to [`CORRECTIONS`] from which on another axis moves beside them.
const MOTION: f64 = 10.0;

/// Which axes' commands move, of the ranges of all: not those that make only corrections while another one moves.
pub(crate) fn which_move(ranges: &[(AxisKind, f64)]) -> Vec<bool> {
    let least = |kind: AxisKind, of: (f64, f64)| if kind == AxisKind::Linear { of.0 } else { of.1 };
    let size = |(kind, range): &(AxisKind, f64)| range / least(*kind, CORRECTIONS);
    let others_move = ranges.iter().map(size).any(|size| size > MOTION);
    ranges.iter().map(|axis| axis.1 > least(axis.0, STILL) && !(others_move && size(axis) < 1.0)).collect()
}

impl<'a> Signals<'a> {
    /// One per axis.
    pub fn of(log: &'a Log) -> Vec<Self> {
        let columns = log.reference.columns().iter().zip(log.actual.columns());
        let ranges = log.axes().iter().zip(log.reference.columns()).map(|(axis, column)| (axis.kind, range(column)));
        let moves = which_move(&ranges.collect::<Vec<_>>());
        log.axes()
            .iter()
            .zip(columns)
            .zip(moves)
            .map(|((axis, (reference, actual)), moves)| Self {
                axis,
                reference,
                actual,
                error: reference.iter().zip(actual).map(|(r, a)| r - a).collect(),
                reference_steps: steps(reference),
                actual_steps: steps(actual),
                period_s: log.period_s(),
                moves,
            })
            .collect()
    }

    /// Whether the command moves: see [`which_move`].
    pub fn moves(&self) -> bool {
        self.moves
    }

    /// One of two thresholds, for a linear (mm) or a rotary axis (rad).
    pub fn of_kind(&self, linear_mm: f64, rotary_rad: f64) -> f64 {
        match self.axis.kind {
            AxisKind::Linear => linear_mm,
            AxisKind::Rotary => rotary_rad,
        }
    }

    pub fn unit(&self) -> &'static str {
        self.axis.kind.unit()
    }

    pub fn actual_name(&self) -> String {
        format!("{}_act", self.axis)
    }

    pub fn reference_name(&self) -> String {
        format!("{}_ref", self.axis)
    }
}

/// The first run, where all have the same axes.
pub(super) fn with_common_axes(logs: &[Log]) -> Option<&Log> {
    logs.first().filter(|first| logs.iter().all(|log| log.axes() == first.axes()))
}

/// Speed below which a command is at standstill: 0.01 mm/s, 1e-4 rad/s.
pub(crate) fn standstill_speed(kind: AxisKind) -> f64 {
    match kind {
        AxisKind::Linear => 1e-2,
        AxisKind::Rotary => 1e-4,
    }
}

pub(super) fn steps(values: &[f64]) -> Vec<f64> {
    values.windows(2).map(|pair| pair[1] - pair[0]).collect()
}

pub(super) fn range(values: &[f64]) -> f64 {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if high >= low { high - low } else { 0.0 }
}

pub(super) fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| value.abs().max(most))
}

pub(super) fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// The `share` quantile of the magnitudes, 0 for no values.
pub(super) fn quantile(values: &[f64], share: f64) -> f64 {
    let mut magnitudes: Vec<f64> = values.iter().map(|value| value.abs()).collect();
    motion::quantile(&mut magnitudes, share).unwrap_or(0.0)
}

/// Correlation about the means, and the slope of `b` on `a`; 0 if one of them is constant.
pub(super) fn correlation(a: &[f64], b: &[f64]) -> (f64, f64) {
    let count = a.len().min(b.len()).max(1) as f64;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / count;
    let (mean_a, mean_b) = (mean(a), mean(b));
    let (mut aa, mut bb, mut ab) = (0.0, 0.0, 0.0);
    for (a, b) in a.iter().zip(b) {
        let (a, b) = (a - mean_a, b - mean_b);
        aa += a * a;
        bb += b * b;
        ab += a * b;
    }
    if aa > 0.0 && bb > 0.0 { (ab / (aa * bb).sqrt(), ab / aa) } else { (0.0, 0.0) }
}
