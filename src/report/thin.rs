//! Which samples of a long run the page holds: no peak of any column is lost, nor the shape of the path.

use motion::Vec3;

/// Samples that are looked at together when the shape of the path is kept.
const PIECE: usize = 4096;
/// First tolerance of the shape, as a share of the path's extent; it grows until the points are few enough.
const FINEST: f64 = 1e-6;
/// Share of the samples that the shape may take.
const SHAPE: f64 = 0.4;

/// At most about `most` samples of a run: all where there are no more. Otherwise the run is cut into equal spans, and of each span the first
/// sample stays and, for every column, the samples with the least and the largest value; further those samples that keep the shape of `path`.
/// Values that are not finite do not count.
#[must_use]
pub fn thinned(most: usize, columns: &[&[f64]], path: &[Vec3]) -> Vec<usize> {
    let n = path.len();
    if n <= most {
        return (0..n).collect();
    }
    let mut kept = vec![false; n];
    let spans = ((1.0 - SHAPE) * most as f64 / (2 * columns.len() + 1) as f64).ceil() as usize;
    let length = n.div_ceil(spans.max(1));
    for from in (0..n).step_by(length) {
        kept[from] = true;
        let span = from..(from + length).min(n);
        for column in columns {
            let finite = || span.clone().filter(|k| column[*k].is_finite());
            let least = finite().min_by(|a, b| column[*a].total_cmp(&column[*b]));
            let largest = finite().max_by(|a, b| column[*a].total_cmp(&column[*b]));
            least.into_iter().chain(largest).for_each(|k| kept[k] = true);
        }
    }
    kept[n - 1] = true;
    keep_shape(&mut kept, path, (SHAPE * most as f64) as usize);
    (0..n).filter(|k| kept[*k]).collect()
}

/// Keeps further samples, at most `most` but for the ends of pieces, so that straight lines between kept samples stay close to the path.
fn keep_shape(kept: &mut [bool], path: &[Vec3], most: usize) {
    let (low, high) = path.iter().fold((path[0], path[0]), |(low, high), p| (low.inf(p), high.sup(p)));
    let mut tolerance = FINEST * (high - low).norm();
    loop {
        let shape: Vec<usize> = (0..path.len())
            .step_by(PIECE)
            .flat_map(|from| corners(path, from, (from + PIECE).min(path.len() - 1), tolerance))
            .collect();
        if shape.len() <= most.max(2 * path.len() / PIECE) || tolerance == 0.0 {
            shape.into_iter().for_each(|k| kept[k] = true);
            return;
        }
        tolerance *= 2.0;
    }
}

/// Samples of `from..=to` such that no other one lies further than the tolerance from the chord over it (Ramer 1972, Douglas and Peucker 1973).
fn corners(path: &[Vec3], from: usize, to: usize, tolerance: f64) -> Vec<usize> {
    let mut kept = vec![from];
    let mut open = vec![(from, to)];
    while let Some((a, b)) = open.pop() {
        let far = (a + 1..b).map(|k| (k, distance(&path[k], &path[a], &path[b])));
        if let Some((k, off)) = far.max_by(|one, other| one.1.total_cmp(&other.1))
            && off > tolerance
        {
            kept.push(k);
            open.extend([(a, k), (k, b)]);
        }
    }
    kept
}

/// Distance of a point from the line segment between two others.
fn distance(point: &Vec3, a: &Vec3, b: &Vec3) -> f64 {
    let (chord, arm) = (b - a, point - a);
    let along = if chord.norm_squared() > 0.0 { (arm.dot(&chord) / chord.norm_squared()).clamp(0.0, 1.0) } else { 0.0 };
    (arm - chord * along).norm()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers that repeat with the seed.
    fn noise(seed: u64, n: usize) -> Vec<f64> {
        let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        (0..n).map(|_| next()).collect()
    }

    fn square(n: usize) -> Vec<Vec3> {
        let at = |k: usize| {
            let s = 4.0 * k as f64 / n as f64;
            let (side, t) = (s as usize, 100.0 * s.fract());
            [Vec3::new(t, 0.0, 0.0), Vec3::new(100.0, t, 0.0), Vec3::new(100.0 - t, 100.0, 0.0), Vec3::new(0.0, 100.0 - t, 0.0)]
                [side]
        };
        (0..n).map(at).collect()
    }

    #[test]
    fn every_peak_of_every_span_stays() {
        for seed in 1..20 {
            let n = 20_000 + 977 * seed as usize;
            let mut columns: Vec<Vec<f64>> = (0..5).map(|c| noise(seed * 10 + c, n)).collect();
            columns[2][n / 3] = 1e3;
            columns[3][n / 2..].fill(f64::NAN);
            columns[4].fill(f64::NAN);
            let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
            let most = 4000;
            let kept = thinned(most, &columns, &square(n));
            assert!(kept.len() <= most + 16 && kept.is_sorted_by(|a, b| a < b), "{}", kept.len());
            let spans = (0.6 * most as f64 / 11.0).ceil() as usize;
            let length = n.div_ceil(spans);
            for column in &columns {
                for from in (0..n).step_by(length) {
                    let of = |range: &mut dyn Iterator<Item = usize>| {
                        let values = range.map(|k| column[k]).filter(|value| value.is_finite());
                        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
                    };
                    let span = from..(from + length).min(n);
                    let all = of(&mut span.clone());
                    assert_eq!(all, of(&mut kept.iter().copied().filter(|k| span.contains(k))));
                }
            }
        }
    }

    #[test]
    fn the_corners_of_the_path_stay() {
        let n = 30_000;
        let path = square(n);
        let kept = thinned(3000, &[&vec![0.0; n]], &path);
        for corner in [n / 4, n / 2, 3 * n / 4] {
            let near = kept.iter().map(|k| (path[*k] - path[corner]).norm()).fold(f64::INFINITY, f64::min);
            assert!(near < 0.1, "{corner}: {near}");
        }
        assert_eq!(thinned(n, &[], &path).len(), n);
        assert!(thinned(10, &[], &[]).is_empty());
    }
}
