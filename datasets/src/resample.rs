//! Interpolation onto a uniform grid.

/// Values at `times` (increasing, at least 4) interpolated at `times[0] + k·period_s` by cubic Hermite pieces.
///
/// The tangent at a sample is that of the parabola through it and its two neighbours, so that
/// parabolas are exact.
pub(crate) fn resample(times: &[f64], values: &[f64], period_s: f64) -> Vec<f64> {
    let (Some(first), Some(last)) = (times.first(), times.last()) else {
        return Vec::new();
    };
    let tangents = tangents(times, values);
    let count = ((last - first) / period_s + 1e-9).floor() as usize + 1;
    let mut piece = 0;
    (0..count)
        .map(|k| {
            let time = (first + k as f64 * period_s).min(*last);
            while piece + 2 < times.len() && times[piece + 1] <= time {
                piece += 1;
            }
            let width = times[piece + 1] - times[piece];
            let u = (time - times[piece]) / width;
            let (p, q) = (values[piece], values[piece + 1]);
            let (m, n) = (tangents[piece] * width, tangents[piece + 1] * width);
            motion::hermite(p, q, m, n, u).0
        })
        .collect()
}

fn tangents(times: &[f64], values: &[f64]) -> Vec<f64> {
    let slope = |k: usize| (values[k + 1] - values[k]) / (times[k + 1] - times[k]);
    let last = times.len() - 1;
    (0..=last)
        .map(|k| {
            if k == 0 {
                slope(0)
            } else if k == last {
                slope(last - 1)
            } else {
                let (before, after) = (times[k] - times[k - 1], times[k + 1] - times[k]);
                (slope(k - 1) * after + slope(k) * before) / (before + after)
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parabolas_are_resampled_exactly() {
        let times = [0.0, 0.1, 0.25, 0.3, 0.5, 0.6];
        let values: Vec<f64> = times.map(|t| 1.0 + 2.0 * t + 3.0 * t * t).to_vec();
        let resampled = resample(&times, &values, 0.05);
        assert_eq!(resampled.len(), 13);
        for (k, value) in resampled.iter().enumerate().skip(2).take(8) {
            let t = 0.05 * k as f64;
            assert!((value - (1.0 + 2.0 * t + 3.0 * t * t)).abs() < 1e-12);
        }
    }
}
