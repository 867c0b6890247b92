//! Taper of a correction beside moves that are not compensated.

/// Weights: 1 where `open`, 0 elsewhere, with raised-cosine ramps of `ramp_samples` samples at both ends of each open segment.
#[must_use]
pub fn taper(open: &[bool], ramp_samples: f64) -> Vec<f64> {
    let ramp_samples = ramp_samples.round().max(1.0);
    let mut weights: Vec<f64> = open.iter().map(|open| f64::from(u8::from(*open))).collect();
    let ramp = |weights: &mut [f64], order: &mut dyn Iterator<Item = usize>| {
        let mut inside = 0.0_f64;
        for k in order {
            inside = if weights[k] > 0.0 { inside + 1.0 } else { 0.0 };
            // A raised cosine has no kink at either end. The first sample of the segment is not shifted.
            let share = 0.5 - 0.5 * (std::f64::consts::PI * ((inside - 1.0) / ramp_samples).clamp(0.0, 1.0)).cos();
            weights[k] = weights[k].min(share);
        }
    };
    let n = weights.len();
    ramp(&mut weights, &mut (0..n));
    ramp(&mut weights, &mut (0..n).rev());
    weights
}
