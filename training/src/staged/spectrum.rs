//! Peaks of the residual's spectrum along the axis: the frequencies of possible position harmonics.

use std::f64::consts::TAU;

use super::recipe::HarmonicRecipe;

/// Residual along the axis, one value per sample.
#[derive(Debug, Default)]
pub struct Residuals {
    /// Expected position less the centre.
    pub position: Vec<f64>,
    /// Residual.
    pub residual: Vec<f64>,
    /// Direction of motion.
    pub sign: Vec<f64>,
}

/// Spatial frequencies of the peaks of the residual, or of the residual times the direction;
/// strongest first.
///
/// A peak exceeds `peak_over_median` times the median power around it. It is at least one cycle
/// over the travel away from stronger peaks and from the harmonics `known` already.
pub fn peaks(residuals: &Residuals, travel: f64, unit: f64, known: &[f64], recipe: &HarmonicRecipe) -> Vec<f64> {
    if travel <= 0.0 || !travel.is_finite() || residuals.position.is_empty() {
        return Vec::new();
    }
    let lowest = recipe.lowest_cycles / travel;
    let spacing = recipe.spacing_cycles / travel;
    let count = ((recipe.highest / unit - lowest) / spacing).floor().max(0.0) as usize;
    let signed: Vec<f64> = residuals.residual.iter().zip(&residuals.sign).map(|(e, s)| e * s).collect();
    let mut peaks: Vec<(f64, f64)> = Vec::new();
    for values in [&residuals.residual, &signed] {
        let power = periodogram(&residuals.position, values, lowest, spacing, count);
        for i in 1..count.saturating_sub(1) {
            if power[i] < power[i - 1] || power[i] < power[i + 1] {
                continue;
            }
            let around = i.saturating_sub(recipe.median_bins)..count.min(i + recipe.median_bins + 1);
            let mut nearby = power[around].to_vec();
            let middle = nearby.len() / 2;
            let median = *nearby.select_nth_unstable_by(middle, f64::total_cmp).1;
            if power[i] > recipe.peak_over_median * median {
                let offset = parabola_peak(power[i - 1], power[i], power[i + 1]);
                peaks.push((power[i] / median, lowest + spacing * (i as f64 + offset)));
            }
        }
    }
    peaks.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut found: Vec<f64> = Vec::new();
    for (_, frequency) in peaks {
        let apart = |other: &f64| (frequency - other).abs() >= 1.0 / travel;
        if found.iter().chain(known).all(apart) {
            found.push(frequency);
        }
    }
    found
}

/// Position of the maximum of the parabola through three neighbours, from −½ to ½.
fn parabola_peak(before: f64, at: f64, after: f64) -> f64 {
    let curvature = before - 2.0 * at + after;
    if curvature < 0.0 { (0.5 * (before - after) / curvature).clamp(-0.5, 0.5) } else { 0.0 }
}

/// Samples that are turned through all frequencies together: they stay in the first-level cache.
const BLOCK: usize = 512;
/// Sums that run side by side.
const TOGETHER: usize = 8;

/// Power of `values` at `count` equally spaced spatial frequencies.
fn periodogram(position: &[f64], values: &[f64], lowest: f64, spacing: f64, count: usize) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    let mut sums = vec![(0.0, 0.0); count];
    for (position, values) in position.chunks(BLOCK).zip(values.chunks(BLOCK)) {
        // The phasor of each sample turns by a constant angle from frequency to frequency. Those beyond the last one stay 0.
        let mut phasors = [Phasors::default(); BLOCK / TOGETHER];
        for (k, (x, y)) in position.iter().zip(values).enumerate() {
            let (sin, cos) = (TAU * lowest * x).sin_cos();
            let (turn_sin, turn_cos) = (TAU * spacing * x).sin_cos();
            phasors[k / TOGETHER].set(k % TOGETHER, [(y - mean) * cos, (y - mean) * sin, turn_cos, turn_sin]);
        }
        let used = values.len().div_ceil(TOGETHER);
        for (re, im) in &mut sums {
            let (mut all_re, mut all_im) = ([0.0; TOGETHER], [0.0; TOGETHER]);
            for phasors in &mut phasors[..used] {
                phasors.add_and_turn(&mut all_re, &mut all_im);
            }
            *re += all_re.iter().sum::<f64>();
            *im += all_im.iter().sum::<f64>();
        }
    }
    sums.iter().map(|(re, im)| re * re + im * im).collect()
}

/// Phasors of some samples, and the angle by which each turns.
#[derive(Debug, Clone, Copy, Default)]
struct Phasors {
    re: [f64; TOGETHER],
    im: [f64; TOGETHER],
    turn_re: [f64; TOGETHER],
    turn_im: [f64; TOGETHER],
}

impl Phasors {
    fn set(&mut self, sample: usize, [re, im, turn_re, turn_im]: [f64; 4]) {
        (self.re[sample], self.im[sample]) = (re, im);
        (self.turn_re[sample], self.turn_im[sample]) = (turn_re, turn_im);
    }

    /// Adds the phasors to sums and turns them.
    fn add_and_turn(&mut self, all_re: &mut [f64; TOGETHER], all_im: &mut [f64; TOGETHER]) {
        for k in 0..TOGETHER {
            let (re, im) = (self.re[k], self.im[k]);
            all_re[k] += re;
            all_im[k] += im;
            self.re[k] = re * self.turn_re[k] - im * self.turn_im[k];
            self.im[k] = re * self.turn_im[k] + im * self.turn_re[k];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wave_in_the_residual_is_found_where_it_is() {
        let position: Vec<f64> = (0..6000).map(|k| 40.0 * (k as f64 * 1e-3).sin()).collect();
        let noise = |k: usize| ((k * 7919) % 1009) as f64 / 1009.0 - 0.5;
        let residuals = Residuals {
            residual: position.iter().enumerate().map(|(k, x)| 0.3 * (TAU * 0.2 * x + 1.0).cos() + noise(k)).collect(),
            sign: position.iter().map(|_| 1.0).collect(),
            position,
        };
        let found = peaks(&residuals, 80.0, 1.0, &[], &HarmonicRecipe::default());
        assert!((found[0] - 0.2).abs() < 2e-3, "{found:?}");
        assert!(peaks(&residuals, 80.0, 1.0, &[0.2], &HarmonicRecipe::default()).iter().all(|f| (f - 0.2).abs() >= 1.0 / 80.0));
    }
}
