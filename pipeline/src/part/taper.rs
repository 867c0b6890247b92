//! Taper of a correction beside moves that are not compensated.

/// Weights of samples, each in a segment or in none: 0 in none, 1 within a segment, with raised-cosine ramps of `ramp_samples` samples at
/// both of its ends.
#[must_use]
pub fn taper<T: PartialEq>(segments: &[Option<T>], ramp_samples: f64) -> Vec<f64> {
    let ramp_samples = ramp_samples.round().max(1.0);
    let mut weights: Vec<f64> = segments.iter().map(|segment| f64::from(u8::from(segment.is_some()))).collect();
    let ramp = |weights: &mut [f64], order: &mut dyn Iterator<Item = usize>| {
        let (mut inside, mut before) = (0.0_f64, None);
        for k in order {
            let segment = segments[k].as_ref();
            inside = if segment.is_some() && before == segment { inside + 1.0 } else { 0.0 };
            // A raised cosine has no kink at either end. The first sample of the segment is not shifted.
            let share = 0.5 - 0.5 * (std::f64::consts::PI * (inside / ramp_samples).clamp(0.0, 1.0)).cos();
            weights[k] = weights[k].min(share);
            before = segment;
        }
    };
    let n = weights.len();
    ramp(&mut weights, &mut (0..n));
    ramp(&mut weights, &mut (0..n).rev());
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbouring_segments_meet_at_zero() {
        let segments = [None, Some(0), Some(0), Some(0), Some(0), Some(1), Some(1), Some(1), None];
        let weights = taper(&segments, 2.0);
        assert_eq!([0, 1, 4, 5, 7, 8].map(|k| weights[k]), [0.0; 6]);
        assert!([2, 3, 6].iter().all(|k| weights[*k] > 0.4), "{weights:?}");
    }
}
