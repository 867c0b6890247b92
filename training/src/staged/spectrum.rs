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

/// Power of `values` at `count` equally spaced spatial frequencies.
fn periodogram(position: &[f64], values: &[f64], lowest: f64, spacing: f64, count: usize) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    // The phasor of each sample rotates by a constant angle from frequency to frequency.
    let (mut re, mut im): (Vec<f64>, Vec<f64>) = position
        .iter()
        .zip(values)
        .map(|(x, y)| {
            let (sin, cos) = (TAU * lowest * x).sin_cos();
            ((y - mean) * cos, (y - mean) * sin)
        })
        .unzip();
    let (turn_sin, turn_cos): (Vec<f64>, Vec<f64>) = position.iter().map(|x| (TAU * spacing * x).sin_cos()).unzip();
    (0..count)
        .map(|_| {
            let power = re.iter().sum::<f64>().powi(2) + im.iter().sum::<f64>().powi(2);
            for (((re, im), cos), sin) in re.iter_mut().zip(&mut im).zip(&turn_cos).zip(&turn_sin) {
                (*re, *im) = (*re * cos - *im * sin, *re * sin + *im * cos);
            }
            power
        })
        .collect()
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
