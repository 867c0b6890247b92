//! The reference between its samples.

use crate::Interpolation;

/// Position and velocity at `fraction` of the way from sample `k` to the next; at rest past the last sample.
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
    fn the_reference_rests_after_its_last_sample() {
        for kind in [Interpolation::Linear, Interpolation::Cubic] {
            assert_eq!(at(&[1.0, 2.0], 9, 0.3, 1.0, kind), (2.0, 0.0));
        }
    }
}
