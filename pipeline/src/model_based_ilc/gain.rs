//! Segments without gain: the correction is kept only where the forecast gains by it.

use std::f64::consts::PI;

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
/// How often the correction is faded around the largest errors before the whole segment is reduced; the last time it is taken out there.
const FADES: usize = 3;
/// Half of the time that is faded around a large error, and the time of each transition, s. The spiral of short lines on `random:170` overshoots its end
/// by 26.9 µm, corrected by 1 nm more: half of the whole correction leaves 3.17 of 5.87 µm RMS, these times 1.33, half of them and 0.3 and 0.5 s the same
/// within 1 %; a fifth of them does not help.
const FADE_S: f64 = 0.1;
const TRANSITION_S: f64 = 0.2;
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
    corrected: Vec<Corrected>,
    without_gain: Vec<WithoutGain>,
}

/// A segment with a correction.
struct Corrected {
    segment: PathSegment,
    /// Share of the correction that it keeps.
    share: f64,
    /// How often the correction was faded around the largest errors.
    fades: usize,
}

impl<'a> Gains<'a> {
    /// Gains over a run whose samples cost `before_mm`; `None` where `input` is no program. A gain below `least_mm` is none.
    pub fn of(input: &'a Input, before_mm: Vec<f64>, least_mm: f64) -> Option<Self> {
        let part = input.part()?;
        let corrected = part.segments().into_iter().map(|segment| Corrected { segment, share: 1.0, fades: 0 }).collect();
        Some(Self { path: input.trajectory(), part, before_mm, least_mm, corrected, without_gain: Vec::new() })
    }

    /// Whether any segment is corrected.
    pub fn corrects(&self) -> bool {
        !self.corrected.is_empty()
    }

    /// Reduces the correction of segments that do not gain by a run of `reference` with these costs of its samples: around the largest errors
    /// where only those grow, else to its half, and where a quarter does not gain either, to none. `None` where every corrected segment gains.
    pub fn reduce(&mut self, reference: &Trajectory, after_mm: &[f64]) -> Result<Option<Trajectory>> {
        let mut columns = reference.columns().to_vec();
        let mut all_gain = true;
        for mut corrected in std::mem::take(&mut self.corrected) {
            let samples = corrected.segment.samples.clone();
            let [before, after] = [&self.before_mm, after_mm].map(|costs| rms_max(&costs[samples.clone()]));
            if self.gains(before, after) {
                self.corrected.push(corrected);
                continue;
            }
            all_gain = false;
            let kept = if corrected.fades < FADES && self.gains(before, (after.0, before.1)) {
                corrected.fades += 1;
                let least = if corrected.fades < FADES { 0.5 } else { 0.0 };
                let is_large: Vec<bool> = after_mm[samples.clone()].iter().map(|cost| *cost > before.1 + SAME_MAX_MM).collect();
                faded(&is_large, least, self.path.period_s())
            } else {
                let factor = if corrected.share > LEAST_SHARE { 0.5 } else { 0.0 };
                corrected.share *= factor;
                vec![factor; samples.len()]
            };
            for (column, desired) in columns.iter_mut().zip(self.path.columns()) {
                let of_segment = column[samples.clone()].iter_mut().zip(&desired[samples.clone()]);
                of_segment.zip(&kept).for_each(|((command, desired), kept)| *command = desired + kept * (*command - desired));
            }
            if corrected.share > 0.0 {
                self.corrected.push(corrected);
            } else {
                self.without_gain.push(self.without_gain(&corrected.segment, before, after));
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

/// Share of the correction that every sample keeps: `least` up to [`FADE_S`] from the large errors, all beyond the transition.
fn faded(is_large: &[bool], least: f64, period_s: f64) -> Vec<f64> {
    let kept = |distance: Option<usize>| {
        let of_transition = distance.map_or(1.0, |samples| ((samples as f64 * period_s - FADE_S) / TRANSITION_S).clamp(0.0, 1.0));
        least + (1.0 - least) * 0.5 * (1.0 - (PI * of_transition).cos())
    };
    let since_large = |samples: &mut dyn Iterator<Item = &bool>| -> Vec<Option<usize>> {
        let since = samples.scan(None, |since: &mut Option<usize>, is_large| {
            *since = if *is_large { Some(0) } else { since.map(|since| since + 1) };
            Some(*since)
        });
        since.collect()
    };
    let (since, until) = (since_large(&mut is_large.iter()), since_large(&mut is_large.iter().rev()));
    since.into_iter().zip(until.into_iter().rev()).map(|(since, until)| kept(since.into_iter().chain(until).min())).collect()
}

#[cfg(test)]
mod tests {
    use machine::MachineSpec;

    use crate::{ReadSettings, Setup};

    use super::*;

    #[test]
    fn a_largest_error_that_grows_at_one_place_takes_no_correction_elsewhere() {
        let setup = Setup::new(&MachineSpec::builtin("ballscrew").unwrap(), None).unwrap();
        let settings = ReadSettings { at_zero: true, ..ReadSettings::default() };
        let part =
            Part::read("line.nc", "G21 G90 G94\nG0 X0. Y0. Z0.\nG1 X100. F1500\nG0 Y1.\nM30\n", &setup, &settings).unwrap();
        let input = Input::from(part);
        let samples = input.part().unwrap().segments()[0].samples.clone();
        let path = input.trajectory();
        let shifted = path.columns().iter().map(|column| column.iter().map(|at| at + 0.01).collect());
        let reference = path.with_columns(shifted.collect()).unwrap();
        let (mut before, mut after) = (vec![0.005; path.len()], vec![0.001; path.len()]);
        let last = samples.end - 1;
        (before[last], after[last]) = (0.02, 0.021);
        let mut gains = Gains::of(&input, before, 0.0).unwrap();
        let kept = gains.reduce(&reference, &after).unwrap().unwrap();
        let shift = |of: &Trajectory, k: usize| of.columns()[0][k] - path.columns()[0][k];
        assert!((shift(&kept, last) - 0.005).abs() < 1e-9, "{}", shift(&kept, last));
        assert!((shift(&kept, samples.start + samples.len() / 2) - 0.01).abs() < 1e-9);
        // Where the largest error never stops growing, nothing is left there, and at last nowhere in the segment.
        let mut at = kept;
        let mut rounds = 1;
        while let Some(next) = gains.reduce(&at, &after).unwrap() {
            (at, rounds) = (next, rounds + 1);
            if rounds == FADES {
                assert!(shift(&at, last).abs() < 1e-9 && (shift(&at, samples.start) - 0.01).abs() < 1e-9);
            }
        }
        assert!(shift(&at, samples.start).abs() < 1e-9 && !gains.corrects());
        assert_eq!(gains.into_without_gain().len(), 1);
    }

    #[test]
    fn a_correction_fades_around_large_errors_and_is_whole_elsewhere() {
        let mut is_large = vec![false; 1000];
        is_large[600] = true;
        let kept = faded(&is_large, 0.5, 0.002);
        assert!(kept[550..=650].iter().all(|kept| (*kept - 0.5).abs() < 1e-12), "{:?}", &kept[540..560]);
        assert!(kept[..450].iter().chain(&kept[751..]).all(|kept| (*kept - 1.0).abs() < 1e-12), "{:?}", &kept[440..460]);
        assert!((kept[500] - 0.75).abs() < 1e-12 && kept[650..=750].is_sorted(), "{:?}", &kept[650..=750]);
        assert!(faded(&[false; 5], 0.0, 0.002).iter().all(|kept| *kept == 1.0));
    }
}
