//! How a correction begins and ends beside moves that stay as they are.

/// 1 where `open`, 0 elsewhere, with a fade over so many samples at both ends of each open stretch.
#[must_use]
pub fn taper(open: &[bool], fade: f64) -> Vec<f64> {
    let fade = fade.round().max(1.0);
    let mut weights: Vec<f64> = open.iter().map(|open| f64::from(u8::from(*open))).collect();
    let ramp = |weights: &mut [f64], order: &mut dyn Iterator<Item = usize>| {
        let mut inside = 0.0_f64;
        for k in order {
            inside = if weights[k] > 0.0 { inside + 1.0 } else { 0.0 };
            // A raised cosine has no kink at either end; the sample at rest beside another move is not shifted at all.
            let share = 0.5 - 0.5 * (std::f64::consts::PI * ((inside - 1.0) / fade).clamp(0.0, 1.0)).cos();
            weights[k] = weights[k].min(share);
        }
    };
    let n = weights.len();
    ramp(&mut weights, &mut (0..n));
    ramp(&mut weights, &mut (0..n).rev());
    weights
}
