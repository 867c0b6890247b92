//! The stop operator, the elementary model of dry friction with presliding.

/// Outputs of stop operators along `position`, one series an operator, each normalised to −1…1.
///
/// `z(k) = clip(z(k−1) + x(k) − x(k−1), ±w) / w` with half-width `w`, in the unit of `position`; they start unstressed.
#[must_use]
pub fn run_stops(position: &[f64], half_widths: &[f64]) -> Vec<Vec<f64>> {
    let gains: Vec<f64> = half_widths.iter().map(|width| 1.0 / width).collect();
    let mut states = vec![0.0_f64; gains.len()];
    let mut outputs = vec![vec![0.0; position.len()]; gains.len()];
    let mut previous = position.first().copied().unwrap_or(0.0);
    // Sample by sample, so that the operators' recursions run side by side instead of each waiting for itself.
    for (k, &x) in position.iter().enumerate() {
        let moved = x - previous;
        previous = x;
        for ((state, gain), output) in states.iter_mut().zip(&gains).zip(&mut outputs) {
            *state = (*state + moved * gain).clamp(-1.0, 1.0);
            output[k] = *state;
        }
    }
    outputs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn saturates_and_comes_back_after_twice_the_half_width() {
        let there_and_back = [0.0, 1.0, 2.0, 3.0, 2.0, 1.0, 0.0, -1.0];
        let z = run_stops(&there_and_back, &[2.0, 4.0]);
        assert_eq!(z[0], [0.0, 0.5, 1.0, 1.0, 0.5, 0.0, -0.5, -1.0]);
        assert_eq!(z[1], [0.0, 0.25, 0.5, 0.75, 0.5, 0.25, 0.0, -0.25]);
    }
}
