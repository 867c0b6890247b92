//! Segments without gain: the correction is kept only where the forecast gains by it.

use motion::Trajectory;

use super::acceptance::cost_of;
use crate::error::Result;
use crate::input::Input;
use crate::part::{Part, PathSegment};
use crate::statistics::rms_max;

/// Least predicted gain for which a segment is changed, as a share of its cost.
pub(super) const LEAST_GAIN: f64 = 0.05;
/// Least share of its correction that a segment keeps. A correction that is right in phase and too large still gains in part: with the model
/// of EMPS on `nist_cover`, 55 instead of 26 % of the feed length gain by shares down to this one, 62 % down to an eighth.
const LEAST_SHARE: f64 = 0.25;
/// Growth of the largest error that counts as none, mm: far below what machines repeat.
pub(super) const SAME_MAX_MM: f64 = 1e-5;

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

/// Gains of the segments of a program over its uncompensated run.
pub(super) struct Gains<'a> {
    path: &'a Trajectory,
    part: &'a Part,
    /// Cost of every sample without correction, mm.
    before_mm: Vec<f64>,
    /// Least gain of a segment, mm.
    least_mm: f64,
    /// Segments with a correction, and the share of it that they keep.
    corrected: Vec<(PathSegment, f64)>,
    without_gain: Vec<WithoutGain>,
}

impl<'a> Gains<'a> {
    /// Gains over a run whose samples cost `before_mm`; `None` where `input` is no program. A gain below `least_mm` is none.
    pub fn of(input: &'a Input, before_mm: Vec<f64>, least_mm: f64) -> Option<Self> {
        let part = input.part()?;
        let corrected = part.segments().into_iter().map(|segment| (segment, 1.0)).collect();
        Some(Self { path: input.trajectory(), part, before_mm, least_mm, corrected, without_gain: Vec::new() })
    }

    /// Whether any segment is corrected.
    pub fn corrects(&self) -> bool {
        !self.corrected.is_empty()
    }

    /// Halves the correction of segments that do not gain by a run of `reference` with these costs of its samples, and takes it out where a
    /// quarter of it does not gain either. `None` where every corrected segment gains.
    pub fn reduce(&mut self, reference: &Trajectory, after_mm: &[f64]) -> Result<Option<Trajectory>> {
        let mut columns = reference.columns().to_vec();
        let mut all_gain = true;
        for (segment, share) in std::mem::take(&mut self.corrected) {
            let [before, after] = [&self.before_mm, after_mm].map(|costs| rms_max(&costs[segment.samples.clone()]));
            if self.gains(before, after) {
                self.corrected.push((segment, share));
                continue;
            }
            all_gain = false;
            let factor = if share > LEAST_SHARE { 0.5 } else { 0.0 };
            for (column, desired) in columns.iter_mut().zip(self.path.columns()) {
                let of_segment = column[segment.samples.clone()].iter_mut().zip(&desired[segment.samples.clone()]);
                of_segment.for_each(|(command, desired)| *command = desired + factor * (*command - desired));
            }
            if factor > 0.0 {
                self.corrected.push((segment, factor * share));
            } else {
                self.without_gain.push(self.without_gain(&segment, before, after));
            }
        }
        Ok((!all_gain).then(|| self.path.with_columns(columns)).transpose()?)
    }

    /// The segments without gain, in the program's order.
    pub fn into_without_gain(mut self) -> Vec<WithoutGain> {
        self.without_gain.sort_by_key(|left| left.lines);
        self.without_gain
    }

    /// Whether the cost falls enough, and neither RMS nor MAX grows.
    fn gains(&self, before: (f64, f64), after: (f64, f64)) -> bool {
        let [cost_before, cost_after] = [before, after].map(|(rms_mm, max_mm)| cost_of(rms_mm, max_mm));
        let enough_mm = (LEAST_GAIN * cost_before).max(self.least_mm);
        cost_before - cost_after >= enough_mm && after.0 <= before.0 && after.1 <= before.1 + SAME_MAX_MM
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
