//! Input features of the networks (Paper D, section III): one function for training and for prediction.

use serde::{Deserialize, Serialize};

use crate::AxisSignal;
use crate::ranges::{ACCELERATION, MOST_SAMPLES, at_most, within};

/// Feature set of a network (Paper D, table II).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FeatureSet {
    /// (i) past velocities `v(k−6…k)`.
    I,
    /// (ii) position, velocity and acceleration at `k`.
    Ii,
    /// (iii) velocities `v(k−6…k+6)` (eq. 8-10), backlash flag and motor-start flag (eq. 11-12).
    Iii,
}

impl FeatureSet {
    /// Whether the set depends on the position.
    #[must_use]
    pub fn depends_on_position(self) -> bool {
        self == Self::Ii
    }
}

/// Reach of the velocity window of sets i and iii, samples: a cascaded drive's tracking error is of
/// sixth order.
const REACH: isize = 6;

/// A feature set with the windows of its flags.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FeatureSpec {
    /// The set.
    pub set: FeatureSet,
    /// `n1`: samples that the backlash flag lasts after a reversal.
    pub backlash_window: usize,
    /// `n2`: samples that the motor-start flag lasts after a standstill.
    pub start_window: usize,
    /// `a_max` of eq. 12, mm/s² or rad/s²: the largest reference acceleration in the training data.
    pub acceleration_max: f64,
}

impl FeatureSpec {
    pub(crate) fn check(&self) -> Result<(), String> {
        at_most("backlash_window", self.backlash_window, MOST_SAMPLES)?;
        at_most("start_window", self.start_window, MOST_SAMPLES)?;
        within("acceleration_max", self.acceleration_max, ACCELERATION)
    }

    /// Number of features.
    #[must_use]
    pub fn width(&self) -> usize {
        match self.set {
            FeatureSet::I => 7,
            FeatureSet::Ii => 3,
            FeatureSet::Iii => 15,
        }
    }

    /// The feature rows of a signal, row-major, [`FeatureSpec::width`] values per sample.
    /// Velocities are backward differences. The axis stands still before the first and after the
    /// last sample.
    #[must_use]
    pub fn rows(&self, signal: &AxisSignal<'_>) -> Vec<f32> {
        let v = velocity(signal.reference, signal.period_s);
        let n = v.len();
        let at = |k: isize| if (0..n as isize).contains(&k) { v[k as usize] } else { 0.0 };
        let mut rows = Vec::with_capacity(n * self.width());
        let flags = (self.set == FeatureSet::Iii).then(|| self.flags(signal.flag_source(), signal.period_s));
        for k in 0..n {
            let i = k as isize;
            match self.set {
                FeatureSet::I => rows.extend((-REACH..=0).map(|lag| at(i + lag) as f32)),
                FeatureSet::Ii => {
                    let acceleration = (at(i) - at(i - 1)) / signal.period_s;
                    rows.extend([signal.reference[k], v[k], acceleration].map(|value| value as f32));
                }
                FeatureSet::Iii => rows.extend((-REACH..=REACH).map(|lag| at(i + lag) as f32)),
            }
            if let Some((backlash, start)) = &flags {
                rows.extend([backlash[k], start[k]]);
            }
        }
        rows
    }

    /// Backlash flag `ch1` and motor-start flag `ch2` of every sample (Paper D, eq. 11-12).
    #[must_use]
    pub fn flags(&self, positions: &[f64], period_s: f64) -> (Vec<f32>, Vec<f32>) {
        let n = positions.len();
        let v = velocity(positions, period_s);
        let (mut backlash, mut start) = (vec![0.0_f32; n], vec![0.0_f32; n]);
        let acceleration = |k: usize| if k > 0 && k < n { ((v[k] - v[k - 1]) / period_s).abs() } else { 0.0 };
        for event in events(&v) {
            let sign = event.sign as f32;
            match event.kind {
                EventKind::Reversal => fill(&mut backlash, event.sample, self.backlash_window, sign),
                EventKind::Start => {
                    let window = event.sample..=event.sample + self.start_window;
                    let mean = window.map(acceleration).sum::<f64>() / (self.start_window + 1) as f64;
                    let strength = if mean <= self.acceleration_max / 4.0 { 1.0 } else { 2.0 };
                    fill(&mut start, event.sample, self.start_window, strength * sign);
                }
            }
        }
        (backlash, start)
    }
}

fn fill(flag: &mut [f32], from: usize, window: usize, value: f32) {
    let to = (from + window + 1).min(flag.len());
    flag[from..to].fill(value);
}

/// Backward-difference velocity, mm/s or rad/s; zero at the first sample.
#[must_use]
pub fn velocity(positions: &[f64], period_s: f64) -> Vec<f64> {
    let mut previous = positions.first().copied().unwrap_or_default();
    positions
        .iter()
        .map(|position| {
            let v = (position - previous) / period_s;
            previous = *position;
            v
        })
        .collect()
}

/// Kind of event.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EventKind {
    /// The velocity changed sign without a standstill.
    Reversal,
    /// The axis started from a standstill.
    Start,
}

/// A reversal or a start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Event {
    /// Last sample before the new direction.
    pub sample: usize,
    /// Kind of the event.
    pub kind: EventKind,
    /// New direction, `+1` or `−1`.
    pub sign: f64,
}

/// Reversals and starts in a velocity signal. Speeds below a millionth of the largest speed count
/// as standstill.
#[must_use]
pub fn events(velocity: &[f64]) -> Vec<Event> {
    let still = 1e-6 * velocity.iter().fold(0.0_f64, |top, v| top.max(v.abs()));
    let moving = |v: f64| v.abs() > still;
    velocity
        .windows(2)
        .enumerate()
        .filter(|(_, pair)| moving(pair[1]))
        .filter_map(|(sample, pair)| {
            let kind = match (moving(pair[0]), pair[0] * pair[1] < 0.0) {
                (false, _) => EventKind::Start,
                (true, true) => EventKind::Reversal,
                (true, false) => return None,
            };
            Some(Event { sample, kind, sign: pair[1].signum() })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spec(set: FeatureSet) -> FeatureSpec {
        FeatureSpec { set, backlash_window: 3, start_window: 2, acceleration_max: 1000.0 }
    }

    /// Standstill, forward at 1 mm/s, back.
    fn positions() -> Vec<f64> {
        let mut x = vec![0.0; 5];
        x.extend((1..=10).map(|k| f64::from(k) * 0.01));
        x.extend((0..10).rev().map(|k| f64::from(k) * 0.01));
        x
    }

    #[test]
    fn flags_follow_equations_11_and_12() {
        let (backlash, start) = spec(FeatureSet::Iii).flags(&positions(), 0.01);
        // Starts between samples 4 and 5: flagged from 4 for two more samples; low acceleration, so
        // strength 1.
        assert_eq!(&start[3..8], [0.0, 1.0, 1.0, 1.0, 0.0]);
        // Reverses between samples 14 and 15.
        assert_eq!(&backlash[13..19], [0.0, -1.0, -1.0, -1.0, -1.0, 0.0]);
        // Starts with more than a quarter of the largest acceleration.
        let sharp = FeatureSpec { acceleration_max: 10.0, ..spec(FeatureSet::Iii) };
        assert_eq!(sharp.flags(&positions(), 0.01).1[4], 2.0);
    }

    #[test]
    fn rows_have_the_velocity_window_of_equation_10() {
        let x = positions();
        for set in [FeatureSet::I, FeatureSet::Ii, FeatureSet::Iii] {
            let spec = spec(set);
            let rows = spec.rows(&AxisSignal::uncompensated(&x, 0.01));
            assert_eq!(rows.len(), x.len() * spec.width());
        }
        let rows = spec(FeatureSet::Iii).rows(&AxisSignal::uncompensated(&x, 0.01));
        let row = &rows[14 * 15..15 * 15];
        assert!(row[..7].iter().all(|v| (v - 1.0).abs() < 1e-5));
        assert!(row[7..13].iter().all(|v| (v + 1.0).abs() < 1e-5));
        assert_eq!(row[13], -1.0);
    }

    #[test]
    fn flags_come_from_the_desired_path_where_there_is_one() {
        let desired = positions();
        let shifted: Vec<f64> = desired.iter().enumerate().map(|(k, x)| x + 1e-5 * (k as f64).sin()).collect();
        let signal = AxisSignal { reference: &shifted, desired: Some(&desired), period_s: 0.01, placed: true };
        let rows = spec(FeatureSet::Iii).rows(&signal);
        let plain = spec(FeatureSet::Iii).rows(&AxisSignal::uncompensated(&desired, 0.01));
        for k in 0..desired.len() {
            assert_eq!(rows[k * 15 + 13..k * 15 + 15], plain[k * 15 + 13..k * 15 + 15]);
        }
    }
}
