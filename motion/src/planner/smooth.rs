//! Sampling and smoothing of a speed profile.

use super::profile::Phase;

/// Arc length every period, from standstill to standstill, smoothed by two moving averages of
/// `windows` samples.
///
/// An average over `n` samples changes a step of acceleration `Δa` into a ramp of jerk `Δa/(n·T)`.
/// The second one makes the jerk continuous. Averaging arc length instead of axis positions keeps
/// every sample on the path.
pub(super) fn sample(phases: &[Vec<Phase>], period_s: f64, windows: [usize; 2]) -> Vec<f64> {
    let raw = positions(phases, period_s);
    averaged(raw, windows)
}

/// Arc length that never decreases, smoothed by two moving averages.
pub(super) fn averaged(motion: Vec<f64>, windows: [usize; 2]) -> Vec<f64> {
    windows.iter().fold(motion, |positions, window| average(&positions, (*window).max(1)))
}

/// Arc length after so many samples, before smoothing, mm. `None` if the end is reached before.
pub(super) fn position_after(phases: &[Vec<Phase>], samples: usize, period_s: f64) -> Option<f64> {
    let mut left_s = samples as f64 * period_s;
    let mut position_mm = 0.0;
    for phase in phases.iter().flatten() {
        if phase.duration_s > left_s {
            return Some(position_mm + left_s * (phase.speed + 0.5 * phase.acceleration * left_s));
        }
        left_s -= phase.duration_s;
        position_mm += phase.duration_s * (phase.speed + 0.5 * phase.acceleration * phase.duration_s);
    }
    None
}

fn positions(phases: &[Vec<Phase>], period_s: f64) -> Vec<f64> {
    let seconds: f64 = phases.iter().flatten().map(|phase| phase.duration_s).sum();
    let mut out = Vec::with_capacity((seconds / period_s) as usize + 3);
    out.push(0.0);
    // Time and position at the start of the phase. Compensated sums, as there may be millions of
    // terms.
    let (mut start_s, mut start_mm) = (Sum::default(), Sum::default());
    for phase in phases.iter().flatten() {
        let end_s = start_s.value() + phase.duration_s;
        loop {
            let time = out.len() as f64 * period_s;
            if time >= end_s {
                break;
            }
            let t = time - start_s.value();
            out.push(start_mm.value() + t * (phase.speed + 0.5 * phase.acceleration * t));
        }
        start_s.add(phase.duration_s);
        start_mm.add(phase.duration_s * (phase.speed + 0.5 * phase.acceleration * phase.duration_s));
    }
    out.push(start_mm.value());
    out
}

/// Causal average over `window` samples. Standstill at both ends, so the result is `window − 1`
/// samples longer.
fn average(positions: &[f64], window: usize) -> Vec<f64> {
    let mut out = filtered(positions, window);
    if let Some(&last) = positions.last() {
        out.iter_mut().for_each(|position| *position = position.min(last));
    }
    out
}

/// The same for positions that may decrease, without the bound by the last one.
pub(super) fn filtered(positions: &[f64], window: usize) -> Vec<f64> {
    let (Some(&first), Some(&last)) = (positions.first(), positions.last()) else { return Vec::new() };
    let scale = 1.0 / window as f64;
    let mut padded = vec![first; window - 1];
    padded.extend_from_slice(positions);
    padded.extend(std::iter::repeat_n(last, window - 1));
    let mut out = vec![0.0; positions.len() + window - 1];
    // The inner loop runs over samples: their sums are independent.
    for back in (0..window).rev() {
        out.iter_mut().zip(&padded[back..]).for_each(|(sum, position)| *sum += position);
    }
    out.iter_mut().for_each(|sum| *sum *= scale);
    if let Some(end) = out.last_mut() {
        *end = last;
    }
    out
}

/// Kahan summation.
#[derive(Default)]
struct Sum {
    total: f64,
    lost: f64,
}

impl Sum {
    fn add(&mut self, value: f64) {
        let value = value - self.lost;
        let total = self.total + value;
        self.lost = (total - self.total) - value;
        self.total = total;
    }

    fn value(&self) -> f64 {
        self.total
    }
}
