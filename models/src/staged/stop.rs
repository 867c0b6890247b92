//! The stop operator, the elementary model of dry friction with presliding.

use super::friction_map::Levels;

/// Number of operators evaluated together, since each recursion waits for its previous sample.
const TOGETHER: usize = 5;

/// Writes the outputs of stop operators along `position` to `outputs`, one series per operator,
/// each normalised to −1…1.
///
/// `z(k) = clip(z(k−1) + x(k) − x(k−1), ±w) / w` with half-width `w`, in the unit of `position`;
/// the initial strain is `start`. With position-dependent `levels` of friction, `z` saturates at
/// them instead of ±1; the stiffness is constant.
pub fn run_stops(position: &[f64], half_widths: &[f64], start: f64, levels: Option<&Levels>, outputs: &mut Vec<Vec<f64>>) {
    match levels {
        None => run_between(position, half_widths, start, |_| [1.0, -1.0], outputs),
        Some(levels) => {
            let bounds = |sample: usize| [levels.forwards[sample], -levels.backwards[sample]];
            run_between(position, half_widths, start, bounds, outputs);
        }
    }
}

/// The operators with outputs between the two `bounds` of a sample.
fn run_between(
    position: &[f64],
    half_widths: &[f64],
    start: f64,
    bounds: impl Fn(usize) -> [f64; 2] + Copy,
    outputs: &mut Vec<Vec<f64>>,
) {
    outputs.resize(half_widths.len(), Vec::new());
    outputs.iter_mut().for_each(|output| output.resize(position.len(), 0.0));
    let mut outputs = outputs.as_mut_slice();
    for widths in half_widths.chunks(TOGETHER) {
        let (group, rest) = outputs.split_at_mut(widths.len());
        match group.first_chunk_mut::<TOGETHER>() {
            Some(group) => run_group(position, widths, start, bounds, group),
            None => group
                .iter_mut()
                .zip(widths)
                .for_each(|(output, width)| run_group(position, &[*width], start, bounds, std::array::from_mut(output))),
        }
        outputs = rest;
    }
}

fn run_group<const N: usize>(
    position: &[f64],
    half_widths: &[f64],
    start: f64,
    bounds: impl Fn(usize) -> [f64; 2],
    outputs: &mut [Vec<f64>; N],
) {
    let gains: [f64; N] = std::array::from_fn(|i| 1.0 / half_widths[i]);
    let mut states: [f64; N] = std::array::from_fn(|i| (start * gains[i]).clamp(-1.0, 1.0));
    let mut outputs = outputs.each_mut().map(|output| output.iter_mut());
    let mut previous = position.first().copied().unwrap_or(0.0);
    for (k, &x) in position.iter().enumerate() {
        let [most, least] = bounds(k);
        let moved = x - previous;
        previous = x;
        for i in 0..N {
            let state = states[i] + moved * gains[i];
            // In this order a comparison is one instruction; `clamp` would check for NaN.
            let state = if state < most { state } else { most };
            states[i] = if state > least { state } else { least };
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
        run_stops(&there_and_back, &[2.0, 4.0], 0.0, None, &mut z);
        assert_eq!(z[0], [0.0, 0.5, 1.0, 1.0, 0.5, 0.0, -0.5, -1.0]);
        assert_eq!(z[1], [0.0, 0.25, 0.5, 0.75, 0.5, 0.25, 0.0, -0.25]);
        run_stops(&there_and_back, &[2.0, 4.0], -3.0, None, &mut z);
        assert_eq!(z[0], [-1.0, -0.5, 0.0, 0.5, 0.0, -0.5, -1.0, -1.0]);
        assert_eq!(z[1][..4], [-0.75, -0.5, -0.25, 0.0]);
    }

    #[test]
    fn a_level_bounds_the_output_and_leaves_the_stiffness() {
        let position = [0.0, 1.0, 2.0, 3.0, 4.0, 3.0, 2.0, 1.0, 0.0, -1.0];
        let levels = Levels { forwards: vec![1.5; 10], backwards: vec![0.5; 10] };
        let mut z = Vec::new();
        run_stops(&position, &[2.0], 0.0, Some(&levels), &mut z);
        assert_eq!(z[0], [0.0, 0.5, 1.0, 1.5, 1.5, 1.0, 0.5, 0.0, -0.5, -0.5]);
    }

    #[test]
    fn operators_side_by_side_are_as_each_alone() {
        let position: Vec<f64> = (0..200).map(|k| (f64::from(k) * 0.3).sin() * f64::from(k % 17)).collect();
        let widths: Vec<f64> = (1..13).map(f64::from).collect();
        let (mut together, mut alone) = (vec![vec![9.0; 300]; 20], Vec::new());
        run_stops(&position, &widths, 0.7, None, &mut together);
        for (output, width) in together.iter().zip(&widths) {
            run_stops(&position, &[*width], 0.7, None, &mut alone);
            assert_eq!(output, &alone[0]);
        }
        assert_eq!(together.len(), widths.len());
    }
}
