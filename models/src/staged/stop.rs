//! The stop operator, the elementary model of dry friction with presliding.

/// Operators whose recursions run side by side instead of each waiting for itself.
const TOGETHER: usize = 5;

/// Writes the outputs of stop operators along `position` to `outputs`, one series an operator, each normalised to −1…1.
///
/// `z(k) = clip(z(k−1) + x(k) − x(k−1), ±w) / w` with half-width `w`, in the unit of `position`; they start strained by `start`.
pub fn run_stops(position: &[f64], half_widths: &[f64], start: f64, outputs: &mut Vec<Vec<f64>>) {
    outputs.resize(half_widths.len(), Vec::new());
    outputs.iter_mut().for_each(|output| output.resize(position.len(), 0.0));
    let mut outputs = outputs.as_mut_slice();
    for widths in half_widths.chunks(TOGETHER) {
        let (group, rest) = outputs.split_at_mut(widths.len());
        match group.first_chunk_mut::<TOGETHER>() {
            Some(group) => run_group(position, widths, start, group),
            None => group
                .iter_mut()
                .zip(widths)
                .for_each(|(output, width)| run_group(position, &[*width], start, std::array::from_mut(output))),
        }
        outputs = rest;
    }
}

fn run_group<const N: usize>(position: &[f64], half_widths: &[f64], start: f64, outputs: &mut [Vec<f64>; N]) {
    let gains: [f64; N] = std::array::from_fn(|i| 1.0 / half_widths[i]);
    let mut states: [f64; N] = std::array::from_fn(|i| (start * gains[i]).clamp(-1.0, 1.0));
    let mut outputs = outputs.each_mut().map(|output| output.iter_mut());
    let mut previous = position.first().copied().unwrap_or(0.0);
    for &x in position {
        let moved = x - previous;
        previous = x;
        for i in 0..N {
            let state = states[i] + moved * gains[i];
            // In this order a comparison is one instruction; `clamp` would look for numbers that are none.
            let state = if state < 1.0 { state } else { 1.0 };
            states[i] = if state > -1.0 { state } else { -1.0 };
            if let Some(output) = outputs[i].next() {
                *output = states[i];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn saturates_and_comes_back_after_twice_the_half_width() {
        let there_and_back = [0.0, 1.0, 2.0, 3.0, 2.0, 1.0, 0.0, -1.0];
        let mut z = Vec::new();
        run_stops(&there_and_back, &[2.0, 4.0], 0.0, &mut z);
        assert_eq!(z[0], [0.0, 0.5, 1.0, 1.0, 0.5, 0.0, -0.5, -1.0]);
        assert_eq!(z[1], [0.0, 0.25, 0.5, 0.75, 0.5, 0.25, 0.0, -0.25]);
        run_stops(&there_and_back, &[2.0, 4.0], -3.0, &mut z);
        assert_eq!(z[0], [-1.0, -0.5, 0.0, 0.5, 0.0, -0.5, -1.0, -1.0]);
        assert_eq!(z[1][..4], [-0.75, -0.5, -0.25, 0.0]);
    }

    #[test]
    fn operators_side_by_side_are_as_each_alone() {
        let position: Vec<f64> = (0..200).map(|k| (f64::from(k) * 0.3).sin() * f64::from(k % 17)).collect();
        let widths: Vec<f64> = (1..13).map(f64::from).collect();
        let (mut together, mut alone) = (vec![vec![9.0; 300]; 20], Vec::new());
        run_stops(&position, &widths, 0.7, &mut together);
        for (output, width) in together.iter().zip(&widths) {
            run_stops(&position, &[*width], 0.7, &mut alone);
            assert_eq!(output, &alone[0]);
        }
        assert_eq!(together.len(), widths.len());
    }
}
