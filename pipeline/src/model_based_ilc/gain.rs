//! Segments without gain: the correction is kept only where the forecast gains by it.

use motion::Trajectory;

use super::acceptance::{SAME_FORECAST, cost_of};
use crate::error::Result;
use crate::input::Input;
use crate::part::{Part, PathSegment};
use crate::statistics::{costs, rms_max};

/// Least predicted gain for which a segment is changed, as a share of its cost.
pub(super) const LEAST_GAIN: f64 = 0.05;

/// A segment of a program that is not changed, because the forecast gains nothing by it. Errors are RMS and MAX of the contour error, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WithoutGain {
    /// First and last line, from 1.
    pub lines: (usize, usize),
    /// Length of its moves, mm.
    pub length_mm: f64,
    /// Predicted errors without correction.
    pub before_mm: (f64, f64),
    /// Predicted errors with correction.
    pub after_mm: (f64, f64),
}

/// The gain of every segment of a program.
pub(super) struct Gains<'a> {
    input: &'a Input,
    part: &'a Part,
    segments: Vec<PathSegment>,
    /// Cost of every sample without correction, mm.
    before: Vec<f64>,
    /// Least gain of a segment, mm.
    least_mm: f64,
}

impl<'a> Gains<'a> {
    /// Gains of the segments of a program over its uncompensated run; `None` where `input` is none. A gain below `least_mm` is none.
    pub fn of(input: &'a Input, uncompensated: &Trajectory, least_mm: f64) -> Result<Option<Self>> {
        let Some(part) = input.part() else { return Ok(None) };
        let before = costs(input.desired(), uncompensated)?;
        Ok(Some(Self { input, part, segments: part.segments(), before, least_mm }))
    }

    /// Takes the correction out of the segments without gain by the run `actual` of `reference`, and moves them to the returned list.
    pub fn leave_out(&mut self, reference: &Trajectory, actual: &Trajectory) -> Result<(Trajectory, Vec<WithoutGain>)> {
        let after = costs(self.input.desired(), actual)?;
        let path = self.input.trajectory();
        let mut columns = reference.columns().to_vec();
        let mut left = Vec::new();
        let mut kept = Vec::with_capacity(self.segments.len());
        for segment in std::mem::take(&mut self.segments) {
            let figures = |costs: &[f64]| rms_max(&costs[segment.samples.clone()]);
            let (before_mm, after_mm) = (figures(&self.before), figures(&after));
            if self.gains(before_mm, after_mm) {
                kept.push(segment);
                continue;
            }
            for (column, desired) in columns.iter_mut().zip(path.columns()) {
                column[segment.samples.clone()].copy_from_slice(&desired[segment.samples.clone()]);
            }
            left.push(self.without_gain(&segment, before_mm, after_mm));
        }
        self.segments = kept;
        Ok((path.with_columns(columns)?, left))
    }

    /// Whether the cost falls enough, and neither RMS nor MAX grows.
    fn gains(&self, before: (f64, f64), after: (f64, f64)) -> bool {
        let [cost_before, cost_after] = [before, after].map(|(rms_mm, max_mm)| cost_of(rms_mm, max_mm));
        let enough_mm = (LEAST_GAIN * cost_before).max(self.least_mm);
        let grows = |before: f64, after: f64| after > before * (1.0 + SAME_FORECAST);
        cost_before - cost_after >= enough_mm && !grows(before.0, after.0) && !grows(before.1, after.1)
    }

    /// Whether no segment is left.
    pub fn is_empty(&self) -> bool {
        self.segments.is_empty()
    }

    fn without_gain(&self, segment: &PathSegment, before_mm: (f64, f64), after_mm: (f64, f64)) -> WithoutGain {
        let moves = || self.part.owners[segment.pieces.clone()].iter().flatten().map(|owner| &self.part.toolpath.moves[*owner]);
        let line = |of: Option<&gcode::Move>| of.map_or(0, |step| step.block as usize + 1);
        WithoutGain {
            lines: (line(moves().next()), line(moves().next_back())),
            length_mm: moves().filter_map(gcode::Move::length_mm).sum(),
            before_mm,
            after_mm,
        }
    }
}
