//! Amplitude spectrum of an error vector by Welch's method.

use std::f64::consts::TAU;

use motion::Vec3;

/// Longest and shortest window, samples.
const WINDOW: [usize; 2] = [2048, 128];

/// One-sided amplitude spectral density.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectrum {
    /// Frequencies, Hz, without zero.
    pub hz: Vec<f64>,
    /// Density at each, mm/√Hz: its square integrates over frequency to the mean square of the error without its mean.
    pub density: Vec<f64>,
}

/// Spectrum of the error vectors over the stretches in which all samples count: the sum of the power of the three components, which does not
/// depend on the directions of the axes. Hann windows with half overlap (Welch 1967). `None` where no stretch is as long as the shortest window.
#[must_use]
pub fn spectrum(errors: &[Vec3], counts: &[bool], period_s: f64) -> Option<Spectrum> {
    let stretches: Vec<(usize, usize)> = stretches(counts).collect();
    let longest = stretches.iter().map(|(from, to)| to - from).max()?;
    let [most, least] = WINDOW;
    let window = (1_usize << longest.max(1).ilog2()).min(most);
    if window < least {
        return None;
    }
    let hann: Vec<f64> = (0..window).map(|k| 0.5 - 0.5 * (TAU * k as f64 / window as f64).cos()).collect();
    let weight: f64 = hann.iter().map(|w| w * w).sum();
    let mut power = vec![0.0; window / 2];
    let mut windows = 0_usize;
    for (from, to) in stretches {
        let mut start = from;
        while start + window <= to {
            let part = &errors[start..start + window];
            let mean = part.iter().sum::<Vec3>() / window as f64;
            for component in 0..3 {
                let mut bins: Vec<[f64; 2]> =
                    part.iter().zip(&hann).map(|(error, w)| [(error[component] - mean[component]) * w, 0.0]).collect();
                fourier(&mut bins);
                power.iter_mut().zip(&bins[1..=window / 2]).for_each(|(sum, [re, im])| *sum += re * re + im * im);
            }
            windows += 1;
            start += window / 2;
        }
    }
    let scale = 2.0 * period_s / (weight * windows.max(1) as f64);
    Some(Spectrum {
        hz: (1..=window / 2).map(|bin| bin as f64 / (window as f64 * period_s)).collect(),
        density: power.into_iter().map(|sum| (sum * scale).sqrt()).collect(),
    })
}

/// Ranges in which all samples count.
fn stretches(counts: &[bool]) -> impl Iterator<Item = (usize, usize)> {
    let mut at = 0;
    let chunks = counts.chunk_by(|a, b| a == b).map(move |chunk| {
        let from = at;
        at += chunk.len();
        (chunk[0], from, at)
    });
    chunks.filter(|(counts, ..)| *counts).map(|(_, from, to)| (from, to))
}

/// Discrete Fourier transform in place, radix 2 (Cooley and Tukey 1965); the length is a power of two. Real and imaginary parts.
fn fourier(values: &mut [[f64; 2]]) {
    let n = values.len();
    let bits = n.trailing_zeros();
    for k in 0..n {
        let mirrored = k.reverse_bits().checked_shr(usize::BITS - bits).unwrap_or(0);
        if mirrored > k {
            values.swap(k, mirrored);
        }
    }
    let mut half = 1;
    while half < n {
        for turn in 0..half {
            let angle = -TAU * turn as f64 / (2 * half) as f64;
            let (sin, cos) = angle.sin_cos();
            for low in (turn..n).step_by(2 * half) {
                let ([a, b], [c, d]) = (values[low], values[low + half]);
                let (re, im) = (c * cos - d * sin, c * sin + d * cos);
                values[low] = [a + re, b + im];
                values[low + half] = [a - re, b - im];
            }
        }
        half *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_power_of_the_spectrum_is_that_of_the_error() {
        let (period, n) = (0.002, 20_000);
        let at = |k: usize| (TAU * 40.0 * k as f64 * period).sin();
        let errors: Vec<Vec3> = (0..n).map(|k| Vec3::new(0.003 * at(k), 0.0, 0.004 * at(k) + 1.0)).collect();
        // A hole splits the run; what does not count is far off and may not show.
        let counts: Vec<bool> = (0..n).map(|k| !(9000..9100).contains(&k)).collect();
        let errors: Vec<Vec3> =
            errors.into_iter().zip(&counts).map(|(e, counts)| if *counts { e } else { Vec3::repeat(1e3) }).collect();
        let found = spectrum(&errors, &counts, period).unwrap();
        let step = found.hz[1] - found.hz[0];
        let power: f64 = found.density.iter().map(|d| d * d * step).sum();
        assert!((power / (0.5 * 0.005_f64.powi(2)) - 1.0).abs() < 0.01, "{power}");
        let peak = (0..found.hz.len()).max_by(|a, b| found.density[*a].total_cmp(&found.density[*b])).unwrap();
        assert!((found.hz[peak] - 40.0).abs() <= step);
        assert!(spectrum(&errors[..100], &counts[..100], period).is_none());
        assert!(spectrum(&[], &[], period).is_none());
    }
}
