//! Delay of an axis.

use crate::interpolate::cubic;

/// Maximum iterations. Each gains about three digits on smooth motion.
const ROUNDS: usize = 12;

/// Delay of `actual` behind `reference` (same unit, one sample every `period_s`), s: the minimum of
/// the mean squared difference.
///
/// Resolved to a fraction of a sample, by Gauss-Newton on `Σ (x_r(t − τ) − x(t))²`. `None` if the
/// reference does not move.
#[must_use]
pub fn lag_s(reference: &[f64], actual: &[f64], period_s: f64) -> Option<f64> {
    let n = reference.len().min(actual.len());
    let last = n.checked_sub(2)?;
    let mut samples = 0.0_f64;
    for _ in 0..ROUNDS {
        let (mut slope, mut curvature) = (0.0, 0.0);
        for (k, position) in actual.iter().enumerate().take(n) {
            let at = k as f64 - samples;
            if at < 1.0 || at > (last - 1) as f64 {
                continue;
            }
            let (value, speed) = cubic(reference, at);
            slope += (value - position) * speed;
            curvature += speed * speed;
        }
        if curvature <= 0.0 {
            return None;
        }
        let step = slope / curvature;
        // A lag longer than the record is invalid.
        samples = (samples + step).clamp(-0.25 * n as f64, 0.25 * n as f64);
        if step.abs() < 1e-9 {
            break;
        }
    }
    Some(samples * period_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_delay_is_found_to_a_small_part_of_a_sample() {
        let position = |t: f64| 20.0 * (3.0 * t).sin() + 5.0 * (11.0 * t).cos();
        let late = |delay: f64| -> Vec<f64> { (0..2000).map(|k| position(f64::from(k) * 0.002 - delay)).collect() };
        for delay in [0.0, 0.000_37, 0.0123, -0.004] {
            let found = lag_s(&late(0.0), &late(delay), 0.002).unwrap();
            assert!((found - delay).abs() < 1e-7, "{found} for {delay}");
        }
        assert!(lag_s(&[1.0; 50], &[1.0; 50], 0.002).is_none());
        assert!(lag_s(&[1.0], &[1.0], 0.002).is_none());
    }
}
