//! The samples with the largest errors.

/// The `most` samples with the largest magnitudes, largest first, each at least `apart` samples from those before. Samples whose magnitude is
/// not finite do not count.
#[must_use]
pub fn worst_samples(magnitudes: &[f64], most: usize, apart: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..magnitudes.len()).filter(|k| magnitudes[*k].is_finite()).collect();
    order.sort_by(|a, b| magnitudes[*b].total_cmp(&magnitudes[*a]));
    let mut chosen: Vec<usize> = Vec::new();
    for k in order {
        if chosen.len() == most {
            break;
        }
        if chosen.iter().all(|other| other.abs_diff(k) > apart) {
            chosen.push(k);
        }
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_of_a_peak_are_left_out() {
        let magnitudes = [1.0, 9.0, 8.0, f64::NAN, 2.0, 3.0];
        assert_eq!(worst_samples(&magnitudes, 3, 1), [1, 5]);
        assert_eq!(worst_samples(&magnitudes, 1, 0), [1]);
    }
}
