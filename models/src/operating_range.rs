//! Operating range of a model, and the excess of a new path beyond it.

use std::collections::VecDeque;

use motion::Trajectory;
use serde::{Deserialize, Serialize};

use crate::LearnedMachine;
use crate::features::{EventKind, events, velocity};
use crate::ranges::{ACCELERATION, JERK, POSITION, RATIO, VELOCITY, all_within, within};
use crate::spread::SETTLING_S;

/// The motions of one axis in the training data, in mm or rad.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OperatingRange {
    /// Smallest and largest reference position.
    pub position: (f64, f64),
    /// Largest speed.
    pub velocity: f64,
    /// Largest acceleration.
    pub acceleration: f64,
    /// Largest jerk.
    pub jerk: f64,
    /// Number of reversals.
    pub reversals: usize,
    /// Number of starts from a standstill.
    pub starts: usize,
    /// Time at standstill, s.
    pub dwell_s: f64,
    /// Whether both directions of travel occur.
    pub both_directions: bool,
}

/// Why a sample lies outside the operating range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Outside {
    /// Beyond the positions of the training data.
    Position,
    /// Faster than the training data.
    Velocity,
    /// Larger acceleration than the training data.
    Acceleration,
    /// The work offset is unknown, and the predictor depends on the position.
    Unplaced,
}

impl std::fmt::Display for Outside {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Position => "position",
            Self::Velocity => "speed",
            Self::Acceleration => "acceleration",
            Self::Unplaced => "unknown position",
        })
    }
}

impl OperatingRange {
    /// Operating range of some runs of one axis, from the reference positions. A run may begin and end in motion.
    #[must_use]
    pub fn of<'a>(runs: impl Iterator<Item = &'a [f64]>, period_s: f64) -> Self {
        let mut coverage = Self {
            position: (f64::INFINITY, f64::NEG_INFINITY),
            velocity: 0.0,
            acceleration: 0.0,
            jerk: 0.0,
            reversals: 0,
            starts: 0,
            dwell_s: 0.0,
            both_directions: false,
        };
        let (mut forward, mut backward) = (false, false);
        for run in runs {
            let rates = |values: &[f64]| -> Vec<f64> { values.windows(2).map(|two| (two[1] - two[0]) / period_s).collect() };
            let v = rates(run);
            let a = rates(&v);
            let j = rates(&a);
            let top = |values: &[f64]| values.iter().fold(0.0_f64, |top, value| top.max(value.abs()));
            coverage.position = run.iter().fold(coverage.position, |(low, high), x| (low.min(*x), high.max(*x)));
            coverage.velocity = coverage.velocity.max(top(&v));
            coverage.acceleration = coverage.acceleration.max(top(&a));
            coverage.jerk = coverage.jerk.max(top(&j));
            for event in events(&v) {
                match event.kind {
                    EventKind::Reversal => coverage.reversals += 1,
                    EventKind::Start => coverage.starts += 1,
                }
            }
            coverage.dwell_s += v.iter().filter(|v| **v == 0.0).count() as f64 * period_s;
            forward |= v.iter().any(|v| *v > 0.0);
            backward |= v.iter().any(|v| *v < 0.0);
        }
        coverage.both_directions = forward && backward;
        coverage
    }

    /// The same range without bounds on the position.
    pub(crate) fn check(&self) -> Result<(), String> {
        let (low, high) = self.position;
        all_within("position", &[low, high], POSITION)?;
        if low > high {
            return Err(format!("`position` is from {low} to {high}; the lower bound comes first"));
        }
        within("velocity", self.velocity, VELOCITY)?;
        within("acceleration", self.acceleration, ACCELERATION)?;
        within("jerk", self.jerk, JERK)?;
        within("dwell_s", self.dwell_s, RATIO)
    }

    fn anywhere(self) -> Self {
        Self { position: (f64::NEG_INFINITY, f64::INFINITY), ..self }
    }

    /// Taper of the correction at every sample of `positions`: 1 within the operating range,
    /// decreasing to 0 outside (one range beyond the trained positions, 1.5 × the trained speed, 2
    /// × the trained acceleration), with the reason for each sample outside. For a predictor that holds `beyond_travel` positions
    /// taper nothing, and for one that holds `beyond_speed` speeds and accelerations do from 4.5 times the trained ones on.
    #[must_use]
    pub fn weights(
        &self,
        positions: &[f64],
        period_s: f64,
        beyond_travel: bool,
        beyond_speed: bool,
    ) -> Vec<(f64, Option<Outside>)> {
        let range = (self.position.1 - self.position.0).max(1e-9);
        let held = if beyond_speed { HELD } else { MARGIN };
        let beyond = |ratio: f64, reach: f64| (1.0 - (ratio / held - 1.0) / reach).clamp(0.0, 1.0);
        let of = |(x, [of_speed, of_acceleration]): (&f64, [f64; 2])| {
            let off = (self.position.0 - x).max(x - self.position.1) - 0.05 * range;
            let of_position = if beyond_travel { 1.0 } else { (1.0 - off.max(0.0) / range).max(0.0) };
            let candidates = [
                (of_position, off > 0.0, Outside::Position),
                (beyond(of_speed, 0.5), of_speed > MARGIN, Outside::Velocity),
                (beyond(of_acceleration, 1.0), of_acceleration > MARGIN, Outside::Acceleration),
            ];
            let outside = candidates.into_iter().filter(|(_, is_outside, _)| *is_outside);
            let least = outside.reduce(|least, other| if other.0 < least.0 { other } else { least });
            least.map_or((1.0, None), |(taper, _, reason)| (taper, Some(reason)))
        };
        positions.iter().zip(self.ratios(positions, period_s)).map(of).collect()
    }

    /// Speed and acceleration at every sample of `positions` over the largest of the training data.
    fn ratios(&self, positions: &[f64], period_s: f64) -> Vec<[f64; 2]> {
        let v = velocity(positions, period_s);
        let ratios = |k: usize| {
            // A path may begin in motion.
            let a = if k > 1 { (v[k] - v[k - 1]) / period_s } else { 0.0 };
            [v[k].abs() / self.velocity.max(1e-9), a.abs() / self.acceleration.max(1e-9)]
        };
        (0..positions.len()).map(ratios).collect()
    }

    /// How much larger the error of a model is at every sample of `positions` than within the operating range. Beyond a margin of a tenth and up to 4.5
    /// times the trained speed or acceleration it grows with their power 1.5, and stays as large for 0.25 s, while the axis settles. Of 18 runs (models of logs at
    /// 0.22 to 0.45 of the limits of seven random machines, two curves at all of them) the RMS and the MAX of all lie below the upper bounds so, and the RMS is 0.88
    /// of what is expected in the median; in proportion and without the time to settle 10, 15 and 1.21; squared and with it 18, 18 and 0.63.
    #[must_use]
    pub fn extrapolation(&self, positions: &[f64], period_s: f64) -> Vec<f64> {
        let settling = (SETTLING_S[1] / period_s).ceil() as usize;
        let of = |[speed, acceleration]: [f64; 2]| {
            let ratio = speed.max(acceleration);
            if ratio > MARGIN { ratio.min(HELD).powf(1.5) } else { 1.0 }
        };
        // Samples of the last while, each above all behind it.
        let mut falling: VecDeque<(usize, f64)> = VecDeque::new();
        let mut largest = |(k, growth): (usize, f64)| {
            while falling.pop_back_if(|(_, before)| *before <= growth).is_some() {}
            falling.push_back((k, growth));
            while falling.pop_front_if(|(before, _)| *before + settling < k).is_some() {}
            falling.front().map_or(growth, |(_, largest)| *largest)
        };
        self.ratios(positions, period_s).into_iter().map(of).enumerate().map(&mut largest).collect()
    }
}

/// Margin for motions that a log misses by little.
const MARGIN: f64 = 1.1;
/// Multiple of the trained speed and acceleration up to which a predictor whose laws hold beyond them corrects in full. Models of 60 s of log at 0.45 of
/// the limits of `random:61001`, `61003`, `61006` and `61008`, on two curves at all of them: 2.3 to 9.4 µm RMS where the correction faded from the margin
/// on, 0.19 to 0.88 without; at 0.22 of the limits of `61003` and `61006` 6.1 to 13.3 and 0.32 to 0.56.
const HELD: f64 = 4.5;

/// Minimum of the tapers over the axes at every sample, smoothed so that a correction does not
/// jump, and the reasons.
#[must_use]
pub fn fade(coverage: &[OperatingRange], machine: &LearnedMachine, path: &Trajectory) -> (Vec<f64>, Vec<Vec<Option<Outside>>>) {
    let mut least = vec![1.0_f64; path.len()];
    let mut reasons = Vec::with_capacity(coverage.len());
    for (axis, ((coverage, predictor), column)) in coverage.iter().zip(machine.predictors()).zip(path.columns()).enumerate() {
        let (holds, faster) = (predictor.holds_beyond_travel(), predictor.holds_beyond_speed());
        let taper = match (machine.is_placed(axis), holds) {
            (true, _) => coverage.weights(column, path.period_s(), holds, faster),
            // Position-dependent terms are left out; no position is outside.
            (false, true) => coverage.anywhere().weights(column, path.period_s(), holds, faster),
            (false, false) => vec![(0.0, Some(Outside::Unplaced)); column.len()],
        };
        for (low, (taper, _)) in least.iter_mut().zip(&taper) {
            *low = low.min(*taper);
        }
        reasons.push(taper.into_iter().map(|(_, reason)| reason).collect());
    }
    (smoothed(&least, (0.02 / path.period_s()).ceil() as usize), reasons)
}

/// Minimum over `±reach` samples, then the mean over as many: never above the input.
fn smoothed(taper: &[f64], reach: usize) -> Vec<f64> {
    if taper.iter().all(|w| *w == 1.0) {
        return taper.to_vec();
    }
    let window = |values: &[f64], k: usize| (k.saturating_sub(reach), (k + reach + 1).min(values.len()));
    let low: Vec<f64> = (0..taper.len())
        .map(|k| {
            let (from, to) = window(taper, k);
            taper[from..to].iter().fold(1.0_f64, |least, w| least.min(*w))
        })
        .collect();
    (0..low.len())
        .map(|k| {
            let (from, to) = window(&low, k);
            low[from..to].iter().sum::<f64>() / (to - from) as f64
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sine(amplitude: f64, hz: f64) -> Vec<f64> {
        (0..1000).map(|k| amplitude * (std::f64::consts::TAU * hz * f64::from(k) * 0.002).sin()).collect()
    }

    #[test]
    fn inside_counts_fully_and_outside_fades_with_a_reason() {
        let trained = sine(10.0, 1.0);
        let coverage = OperatingRange::of(std::iter::once(trained.as_slice()), 0.002);
        assert!(coverage.both_directions && coverage.reversals >= 3);
        let inside = coverage.weights(&sine(9.0, 1.0), 0.002, false, false);
        assert!(inside.iter().all(|(w, reason)| *w == 1.0 && reason.is_none()));
        let faster = coverage.weights(&sine(9.0, 1.4), 0.002, false, false);
        assert!(faster.iter().any(|(w, reason)| *w < 0.9 && reason.is_some()));
        let held = coverage.weights(&sine(9.0, 2.0), 0.002, true, true);
        assert!(held.iter().all(|(w, _)| *w == 1.0) && held.iter().any(|(_, reason)| *reason == Some(Outside::Velocity)));
        assert!(coverage.weights(&sine(9.0, 8.0), 0.002, true, true).iter().any(|(w, _)| *w == 0.0));
        assert!(coverage.weights(&sine(9.0, 2.0), 0.002, true, false).iter().any(|(w, _)| *w < 0.5));
        let further = coverage.extrapolation(&sine(9.0, 1.5), 0.002);
        assert!(further.iter().all(|more| (1.0..3.2).contains(more)) && further[500..].iter().any(|more| *more > 1.5));
        // A quarter of a second after a push the axis has settled.
        let pushed: Vec<f64> = (0..1000).map(|k| if k < 100 { 0.0 } else { 5e-3 }).collect();
        let after = coverage.extrapolation(&pushed, 0.002);
        assert!(after[..99].iter().all(|more| *more == 1.0) && after[101..220].iter().all(|more| *more > 1.1));
        assert!(after[230..].iter().all(|more| *more == 1.0), "{:?}", &after[225..240]);
        let axis_that_stood = OperatingRange::of(std::iter::once(&[1.0; 100][..]), 0.002);
        assert!(axis_that_stood.extrapolation(&sine(9.0, 1.5), 0.002).iter().all(|more| (1.0..=HELD.powf(1.5)).contains(more)));
        let far: Vec<f64> = sine(10.0, 1.0).iter().map(|x| x + 100.0).collect();
        assert!(
            coverage.weights(&far, 0.002, false, false)[500..].iter().all(|(w, r)| *w == 0.0 && *r == Some(Outside::Position))
        );
        assert!(coverage.weights(&far, 0.002, true, true)[500..].iter().all(|(w, r)| *w == 1.0 && *r == Some(Outside::Position)));
    }

    #[test]
    fn a_run_that_begins_in_motion_reaches_no_more_than_the_whole() {
        let whole = sine(10.0, 1.0);
        let from = |k: usize| OperatingRange::of(std::iter::once(&whole[k..]), 0.002);
        let (largest, part) = (from(0), from(3));
        assert!(part.acceleration <= largest.acceleration && part.jerk <= largest.jerk, "{part:?}");
        // 10·(2π)² mm/s².
        assert!((largest.acceleration / 394.8 - 1.0).abs() < 0.01, "{largest:?}");
        assert_eq!(part.starts, 0);
        assert!(largest.weights(&whole[3..], 0.002, false, false).iter().all(|(w, reason)| *w == 1.0 && reason.is_none()));
    }

    #[test]
    fn smoothed_tapers_never_exceed_the_raw_ones() {
        let mut raw = vec![1.0; 200];
        raw[100] = 0.2;
        let soft = smoothed(&raw, 10);
        assert!(soft.iter().zip(&raw).all(|(s, r)| s <= &(r + 1e-15)));
        assert!((soft[100] - 0.2).abs() < 1e-12 && soft[0] == 1.0);
    }
}
