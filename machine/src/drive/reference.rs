//! The reference between its samples.

use crate::options::Interpolation;
use crate::spec::{LoopSpec, Rates};

/// Command of the position loop in one of its periods.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Command {
    /// Position, mm.
    pub position: f64,
    /// Its rate, mm/s.
    pub slope: f64,
    /// Rate of the slope over the last sampling period, mm/s².
    pub acceleration: f64,
}

/// The commands of every period of the position loop up to the last sample, with the command
/// smoothing of the control.
pub(super) fn commands(
    samples: &[f64],
    loops: &LoopSpec,
    rates: Rates,
    period_s: f64,
    interpolation: Interpolation,
) -> Vec<Command> {
    let per_sample = rates.position_per_sample;
    let periods = samples.len().saturating_sub(1) * per_sample;
    let mut commands: Vec<Command> = (0..periods)
        .map(|i| {
            let fraction = (i % per_sample) as f64 / per_sample as f64;
            let (position, slope) = at(samples, i / per_sample, fraction, period_s, interpolation);
            Command { position, slope, acceleration: 0.0 }
        })
        .collect();
    let window = (loops.command_average_ms / loops.position_period_ms).round() as usize;
    if window > 1 {
        average(&mut commands, window);
    }
    if loops.command_lag_ms > 0.0 {
        lag(&mut commands, 1.0 - (-loops.position_period_ms / loops.command_lag_ms).exp());
    }
    if loops.acceleration_feed_forward > 0.0 {
        // Over a sampling period: the slope of a linear reference only changes from sample to
        // sample.
        for i in (per_sample..periods).rev() {
            commands[i].acceleration = (commands[i].slope - commands[i - per_sample].slope) / period_s;
        }
    }
    commands
}

/// Mean of the last `window` commands. Standstill before the first.
fn average(commands: &mut [Command], window: usize) {
    let Some(first) = commands.first().copied() else { return };
    let given = commands.to_vec();
    // Offsets from the first position, so that long sums keep their accuracy.
    let (mut position, mut slope) = (0.0, 0.0);
    for (i, command) in commands.iter_mut().enumerate() {
        position += given[i].position - first.position;
        slope += given[i].slope;
        if i >= window {
            position -= given[i - window].position - first.position;
            slope -= given[i - window].slope;
        }
        command.position = first.position + position / window as f64;
        command.slope = slope / window as f64;
    }
}

/// First-order lag that reduces the distance by the fraction `approach` per period. Starts at
/// standstill on the first command.
fn lag(commands: &mut [Command], approach: f64) {
    let Some(first) = commands.first() else { return };
    let (mut position, mut slope) = (first.position, 0.0);
    for command in commands {
        position += approach * (command.position - position);
        slope += approach * (command.slope - slope);
        (command.position, command.slope) = (position, slope);
    }
}

/// Position and velocity at `fraction` between sample `k` and the next. At standstill past the last
/// sample.
///
/// Linear: the chord and its slope. Cubic: the Hermite segment with central-difference slopes (Catmull-Rom).
pub(super) fn at(samples: &[f64], k: usize, fraction: f64, period_s: f64, interpolation: Interpolation) -> (f64, f64) {
    let last = samples.len().saturating_sub(1);
    let sample = |index: usize| samples.get(index.min(last)).copied().unwrap_or(0.0);
    let (here, next) = (sample(k), sample(k + 1));
    let chord = next - here;
    match interpolation {
        Interpolation::Linear => (here + fraction * chord, chord / period_s),
        Interpolation::Cubic => {
            let leaving = 0.5 * (next - sample(k.saturating_sub(1)));
            let arriving = 0.5 * (sample(k + 2) - here);
            // p(f) = here + leaving f + b f² + c f³ with p(1) = next and p′(1) = arriving.
            let b = 3.0 * chord - 2.0 * leaving - arriving;
            let c = leaving + arriving - 2.0 * chord;
            let position = here + fraction * (leaving + fraction * (b + fraction * c));
            let slope = leaving + fraction * (2.0 * b + fraction * 3.0 * c);
            (position, slope / period_s)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubic_follows_a_parabola_and_linear_its_chords() {
        let samples: Vec<f64> = (0..6).map(|k| (k as f64).powi(2)).collect();
        let (position, slope) = at(&samples, 2, 0.5, 1.0, Interpolation::Cubic);
        assert!((position - 6.25).abs() < 1e-12 && (slope - 5.0).abs() < 1e-12);
        let (position, slope) = at(&samples, 2, 0.5, 1.0, Interpolation::Linear);
        assert!((position - 6.5).abs() < 1e-12 && (slope - 5.0).abs() < 1e-12);
    }

    #[test]
    fn the_reference_is_constant_after_its_last_sample() {
        for kind in [Interpolation::Linear, Interpolation::Cubic] {
            assert_eq!(at(&[1.0, 2.0], 9, 0.3, 1.0, kind), (2.0, 0.0));
        }
    }
}
