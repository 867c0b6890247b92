//! Interpolating splines of degree five that start and end at a standstill.

use crate::DatasetError;

/// A C⁴ spline of degree five through points over time, with zero speed and acceleration at both
/// ends.
///
/// It is stored as position, speed and acceleration at its knots. The inner speeds and
/// accelerations follow from the continuity of the third and fourth derivatives: a
/// block-tridiagonal system of 2 × 2 blocks.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct QuinticSpline {
    times: Vec<f64>,
    /// Position, speed, acceleration at each knot.
    knots: Vec<[f64; 3]>,
}

type Block = [[f64; 2]; 2];
type Pair = [f64; 2];

impl QuinticSpline {
    /// The spline through `values` at increasing `times` (at least two of each).
    pub fn through(times: &[f64], values: &[f64]) -> Result<Self, DatasetError> {
        let increasing = times.windows(2).all(|pair| pair[1] > pair[0]);
        if times.len() != values.len() || times.len() < 2 || !increasing {
            return Err(DatasetError::Runs("a spline needs two or more points at increasing times".to_owned()));
        }
        let last = times.len() - 1;
        let width = |k: usize| times[k + 1] - times[k];
        // Forward sweep over the inner knots: unknown pair of knot k = offset − gain · unknown pair of knot k + 1.
        let mut gains: Vec<Block> = Vec::with_capacity(last);
        let mut offsets: Vec<Pair> = Vec::with_capacity(last);
        for k in 1..last {
            let (before, after) = (width(k - 1), width(k));
            let (left, mut middle, right) = blocks(before, after);
            let step = [values[k] - values[k - 1], values[k + 1] - values[k]];
            let mut side = [
                60.0 * (step[1] / after.powi(3) - step[0] / before.powi(3)),
                -360.0 * (step[1] / after.powi(4) + step[0] / before.powi(4)),
            ];
            if let (Some(gain), Some(offset)) = (gains.last(), offsets.last()) {
                middle = minus(middle, product(left, *gain));
                let moved = apply(left, *offset);
                side = [side[0] - moved[0], side[1] - moved[1]];
            }
            let inverse = inverse(middle);
            gains.push(product(inverse, right));
            offsets.push(apply(inverse, side));
        }
        let mut knots = vec![[0.0; 3]; times.len()];
        for (knot, value) in knots.iter_mut().zip(values) {
            knot[0] = *value;
        }
        let mut next = [0.0; 2];
        for k in (1..last).rev() {
            let moved = apply(gains[k - 1], next);
            next = [offsets[k - 1][0] - moved[0], offsets[k - 1][1] - moved[1]];
            (knots[k][1], knots[k][2]) = (next[0], next[1]);
        }
        Ok(Self { times: times.to_vec(), knots })
    }

    pub fn duration_s(&self) -> f64 {
        self.times[self.times.len() - 1] - self.times[0]
    }

    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Position and its first three derivatives at `time`, which is clamped to the spline.
    pub fn at(&self, time: f64) -> [f64; 4] {
        let piece = self.times.partition_point(|knot| *knot <= time).clamp(1, self.times.len() - 1) - 1;
        let h = self.times[piece + 1] - self.times[piece];
        let s = (time - self.times[piece]).clamp(0.0, h);
        let ([p0, v0, a0], [p1, v1, a1]) = (self.knots[piece], self.knots[piece + 1]);
        let d = p1 - p0;
        let c3 = 10.0 * d / h.powi(3) - (6.0 * v0 + 4.0 * v1) / h.powi(2) - (3.0 * a0 - a1) / (2.0 * h);
        let c4 = -15.0 * d / h.powi(4) + (8.0 * v0 + 7.0 * v1) / h.powi(3) + (3.0 * a0 - 2.0 * a1) / (2.0 * h.powi(2));
        let c5 = 6.0 * d / h.powi(5) - 3.0 * (v0 + v1) / h.powi(4) - (a0 - a1) / (2.0 * h.powi(3));
        [
            p0 + s * (v0 + s * (0.5 * a0 + s * (c3 + s * (c4 + s * c5)))),
            v0 + s * (a0 + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5))),
            a0 + s * (6.0 * c3 + s * (12.0 * c4 + s * 20.0 * c5)),
            6.0 * c3 + s * (24.0 * c4 + s * 60.0 * c5),
        ]
    }

    /// The same shape, scaled towards the line between its ends until it stays between `low` and
    /// `high`, which contain both ends.
    pub fn squeezed(mut self, (low, high): (f64, f64)) -> Self {
        const PER_KNOT: usize = 40;
        let (start, end) = (self.knots[0][0], self.knots[self.knots.len() - 1][0]);
        let line = Self::rest_to_rest(self.duration_s(), start, end);
        let begin = self.times[0];
        let mut share: f64 = 1.0;
        let count = PER_KNOT * self.times.len();
        for k in 0..=count {
            let time = self.duration_s() * k as f64 / count as f64;
            let base = line.at(time)[0];
            let away = self.at(begin + time)[0] - base;
            let room = if away > 0.0 { high - base } else { base - low }.max(0.0);
            if away.abs() > room {
                share = share.min(room / away.abs());
            }
        }
        if share < 1.0 {
            // A margin for the motion between the sampled times.
            share *= 0.99;
            for (time, knot) in self.times.iter().zip(&mut self.knots) {
                let base = line.at(time - begin);
                for (value, base) in knot.iter_mut().zip(base) {
                    *value = base + share * (*value - base);
                }
            }
        }
        self
    }

    fn rest_to_rest(duration_s: f64, start: f64, end: f64) -> Self {
        Self { times: vec![0.0, duration_s], knots: vec![[start, 0.0, 0.0], [end, 0.0, 0.0]] }
    }
}

/// Coefficients of the speeds and accelerations before, at and after a knot between intervals `g` and `h`: rows for the third and for
/// the fourth derivative, right side of the knot minus left side, with the signs brought to `left·u₋ + middle·u + right·u₊ = side`.
fn blocks(g: f64, h: f64) -> (Block, Block, Block) {
    let left = [[-24.0 / g.powi(2), -3.0 / g], [-168.0 / g.powi(3), -24.0 / g.powi(2)]];
    let middle = [
        [36.0 / h.powi(2) - 36.0 / g.powi(2), 9.0 / h + 9.0 / g],
        [-192.0 / h.powi(3) - 192.0 / g.powi(3), -36.0 / h.powi(2) + 36.0 / g.powi(2)],
    ];
    let right = [[24.0 / h.powi(2), -3.0 / h], [-168.0 / h.powi(3), 24.0 / h.powi(2)]];
    (left, middle, right)
}

fn product(a: Block, b: Block) -> Block {
    let cell = |i: usize, j: usize| a[i][0] * b[0][j] + a[i][1] * b[1][j];
    [[cell(0, 0), cell(0, 1)], [cell(1, 0), cell(1, 1)]]
}

fn minus(a: Block, b: Block) -> Block {
    [[a[0][0] - b[0][0], a[0][1] - b[0][1]], [a[1][0] - b[1][0], a[1][1] - b[1][1]]]
}

fn apply(a: Block, x: Pair) -> Pair {
    [a[0][0] * x[0] + a[0][1] * x[1], a[1][0] * x[0] + a[1][1] * x[1]]
}

fn inverse(a: Block) -> Block {
    let determinant = a[0][0] * a[1][1] - a[0][1] * a[1][0];
    [[a[1][1] / determinant, -a[0][1] / determinant], [-a[1][0] / determinant, a[0][0] / determinant]]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wavy() -> QuinticSpline {
        let times = [0.0, 0.1, 0.19, 0.31, 0.4, 0.52];
        QuinticSpline::through(&times, &[0.0, 5.0, -3.0, 8.0, 1.0, 2.0]).unwrap()
    }

    #[test]
    fn it_passes_its_points_and_starts_and_ends_at_rest() {
        let spline = wavy();
        for (time, value) in [(0.0, 0.0), (0.1, 5.0), (0.19, -3.0), (0.31, 8.0), (0.4, 1.0), (0.52, 2.0)] {
            assert!((spline.at(time)[0] - value).abs() < 1e-9, "{time}");
        }
        for end in [0.0, 0.52] {
            assert!(spline.at(end)[1].abs() < 1e-6 && spline.at(end)[2].abs() < 1e-4);
        }
    }

    #[test]
    fn four_derivatives_are_continuous() {
        let spline = wavy();
        let h = 1e-6;
        for knot in [0.1, 0.19, 0.31, 0.4] {
            for order in 0..4 {
                let (before, after) = (spline.at(knot - h)[order], spline.at(knot + h)[order]);
                let slope = spline.at(knot - 2.0 * h)[order] - before;
                let scale = before.abs().max(1.0);
                assert!((after - before + 2.0 * slope).abs() < 1e-3 * scale, "derivative {order} at {knot}");
            }
            let jerk = |t: f64| spline.at(t)[3];
            let left = (jerk(knot - h) - jerk(knot - 2.0 * h)) / h;
            let right = (jerk(knot + 2.0 * h) - jerk(knot + h)) / h;
            assert!((left - right).abs() < 1e-3 * left.abs().max(right.abs()), "{left} {right}");
        }
    }

    #[test]
    fn one_rest_to_rest_polynomial_of_degree_five_comes_back_exactly() {
        let p = |u: f64| 7.0 * u.powi(3) * (10.0 - 15.0 * u + 6.0 * u * u);
        let times = [0.0, 0.2, 0.5, 0.65, 1.0];
        let spline = QuinticSpline::through(&times, &times.map(p)).unwrap();
        for k in 0..=100 {
            let u = f64::from(k) / 100.0;
            assert!((spline.at(u)[0] - p(u)).abs() < 1e-11, "{u}");
        }
    }

    #[test]
    fn squeezing_keeps_the_ends_and_the_room() {
        let spline = wavy().squeezed((-1.0, 3.0));
        for k in 0..=1000 {
            let position = spline.at(0.52 * f64::from(k) / 1000.0)[0];
            assert!((-1.0..=3.0).contains(&position), "{position}");
        }
        assert!((spline.at(0.0)[0]).abs() < 1e-12 && (spline.at(0.52)[0] - 2.0).abs() < 1e-9);
    }
}
