//! Estimate of the part of a model's error that repeats in every run of a path.
//!
//! The errors of the runs are split into bands of frequency by zero-phase filters. What the runs have in common in a band is the mean product
//! of two different runs, in which the noise of independent runs cancels. Each band of the mean error is kept by its share of repeatable
//! power (Wiener filter). A single run cannot show what repeats: of it only what exceeds the model's held-out error is kept.

use compensation::LowPass;

use crate::error::Result;

/// Highest border between bands as a share of the sampling rate, and ratio of successive borders: octaves.
const HIGHEST_BORDER: f64 = 0.2;
const NEXT_BORDER: f64 = 0.5;
/// Lowest border, Hz: bands of slower changes hold few independent samples, too few to compare runs.
const LOWEST_BORDER_HZ: f64 = 0.3;

/// Repeatable part of `runs`, the model's errors of one axis in several runs of a path, one value a sample. `counted` marks the samples whose
/// power is compared; `held_out` is the RMS of the model's error on motions that it was not trained on.
///
/// # Errors
/// Those of [`LowPass::new`], which the cut-offs here do not cause.
pub fn repeated(runs: &[&[f64]], counted: &[bool], held_out: f64, period_s: f64) -> Result<Vec<f64>> {
    let mut rest: Vec<Vec<f64>> = runs.iter().map(|run| run.to_vec()).collect();
    let of_single = runs.first().map_or(0.0, |run| kept_of_single(run, counted, held_out));
    let kept = |band: &[Vec<f64>]| if band.len() == 1 { of_single } else { kept(band, counted) };
    let mut sum = vec![0.0; counted.len()];
    let mut border_hz = HIGHEST_BORDER / period_s;
    while border_hz > LOWEST_BORDER_HZ
        && let Some(filter) = LowPass::new(border_hz, period_s)?
    {
        let below: Vec<Vec<f64>> = rest.iter().map(|run| filter.zero_phase(run)).collect();
        let band: Vec<Vec<f64>> = rest.iter().zip(&below).map(|(run, below)| difference(run, below)).collect();
        add_mean(&mut sum, &band, kept(&band));
        rest = below;
        border_hz *= NEXT_BORDER;
    }
    add_mean(&mut sum, &rest, kept(&rest));
    Ok(sum)
}

/// Share of the mean of `runs` that repeats: `S/(S + N/n)` with the repeatable power `S` and the power `N` of what differs between `n` runs.
fn kept(runs: &[Vec<f64>], counted: &[bool]) -> f64 {
    let n = runs.len() as f64;
    let total = runs.iter().map(|run| power(run, run, counted)).sum::<f64>() / n;
    let pairs = runs.iter().enumerate().flat_map(|(i, one)| runs[i + 1..].iter().map(move |other| (one, other)));
    let products: f64 = pairs.map(|(one, other)| power(one, other, counted)).sum();
    let common = products / (0.5 * n * (n - 1.0));
    let noise = (total - common).max(0.0);
    if common > 0.0 { common / (common + noise / n) } else { 0.0 }
}

/// Share of a single run beyond the error that the model has on other motions (positive-part James–Stein estimate).
fn kept_of_single(run: &[f64], counted: &[bool], held_out: f64) -> f64 {
    let total = power(run, run, counted);
    if total > 0.0 { (1.0 - held_out * held_out / total).max(0.0) } else { 0.0 }
}

/// Mean product of two runs over the samples that count.
fn power(one: &[f64], other: &[f64], counted: &[bool]) -> f64 {
    let products = one.iter().zip(other).zip(counted).filter(|(_, counts)| **counts).map(|((x, y), _)| x * y);
    products.sum::<f64>() / counted.iter().filter(|counts| **counts).count().max(1) as f64
}

fn difference(one: &[f64], other: &[f64]) -> Vec<f64> {
    one.iter().zip(other).map(|(x, y)| x - y).collect()
}

/// Adds the share `kept` of the mean of `runs` to `sum`.
fn add_mean(sum: &mut [f64], runs: &[Vec<f64>], kept: f64) {
    let share = kept / runs.len().max(1) as f64;
    for run in runs {
        sum.iter_mut().zip(run).for_each(|(sum, x)| *sum += share * x);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_S: f64 = 0.002;
    const SAMPLES: usize = 8000;

    /// White noise of RMS 1.
    fn noise(seed: u64) -> Vec<f64> {
        let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f64 / f64::from(1 << 24) - 0.5
        };
        (0..SAMPLES).map(|_| 12.0_f64.sqrt() * uniform()).collect()
    }

    /// A wave of 2 Hz of RMS 1.
    fn wave() -> Vec<f64> {
        let at = |k: usize| 2.0_f64.sqrt() * (std::f64::consts::TAU * 2.0 * k as f64 * PERIOD_S).sin();
        (0..SAMPLES).map(at).collect()
    }

    fn off(runs: &[Vec<f64>], truth: &[f64]) -> f64 {
        let of_runs: Vec<&[f64]> = runs.iter().map(Vec::as_slice).collect();
        let counted = vec![true; SAMPLES];
        let found = difference(&repeated(&of_runs, &counted, 1.0, PERIOD_S).unwrap(), truth);
        power(&found, &found, &counted).sqrt()
    }

    #[test]
    fn what_runs_have_in_common_is_kept_and_noise_is_not() {
        let run = |seed: u64| -> Vec<f64> { wave().iter().zip(noise(seed)).map(|(wave, noise)| wave + noise).collect() };
        let runs: Vec<Vec<f64>> = (1..=8).map(run).collect();
        // The mean of two runs would be off by 0.71, that of eight by 0.35.
        let (two, eight) = (off(&runs[..2], &wave()), off(&runs, &wave()));
        assert!(two < 0.2 && eight < 0.1 && eight < two, "{two} {eight}");
    }

    #[test]
    fn of_noise_alone_next_to_nothing_is_kept() {
        let runs: Vec<Vec<f64>> = (1..=3).map(noise).collect();
        let left = off(&runs, &vec![0.0; SAMPLES]);
        assert!(left < 0.15, "{left}");
    }

    #[test]
    fn of_a_single_run_only_what_the_model_does_not_explain_is_kept() {
        assert_eq!(off(&[noise(1).iter().map(|x| 0.9 * x).collect()], &vec![0.0; SAMPLES]), 0.0);
        let large: Vec<f64> = wave().iter().map(|x| 10.0 * x).collect();
        assert!(off(std::slice::from_ref(&large), &large) < 0.11);
    }

    #[test]
    fn samples_that_do_not_count_do_not_decide() {
        let mut runs = [wave(), wave()];
        runs[0][..SAMPLES / 2].fill(100.0);
        runs[1][..SAMPLES / 2].fill(-100.0);
        let of_runs: Vec<&[f64]> = runs.iter().map(Vec::as_slice).collect();
        let counted: Vec<bool> = (0..SAMPLES).map(|k| k > SAMPLES / 2 + 2000).collect();
        let found = difference(&repeated(&of_runs, &counted, 1.0, PERIOD_S).unwrap(), &wave());
        let off = power(&found, &found, &counted).sqrt();
        assert!(off < 0.1, "{off}");
    }
}
